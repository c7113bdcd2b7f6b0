"""The scripts of the book's page on clusters give the tables of one process."""

import importlib.util
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time

import pytest

PAGE = pathlib.Path(__file__).parents[3] / "crates" / "book" / "src" / "clusters.md"
GAS = "[[gas]]\nradius = 0.02\nmass = 1.0\ntemperature = 1.0\ncount = 50\n"
SCENE = GAS + '[run]\nuntil = {until}\nsample_interval = 0.1\nobserve = ["pressure"]\n'
STUDY = 'scene = "scene.toml"\nreplicas = 4\n[[vary]]\nkey = "gas.0.count"\nvalues = [50, 100]\n'


def listing(name):
    """The code block after the file's name on the page."""
    _, rest = PAGE.read_text().split(f"`{name}`", 1)
    return re.search(r"```\w+\n(.*?)```", rest, re.DOTALL)[1]


@pytest.fixture
def study(tmp_path, monkeypatch):
    """A function that writes a study into a folder, which it returns; `carom` is on the path."""
    found = os.environ.get("CAROM_COMMAND") or shutil.which("carom")
    if not found:
        pytest.skip("the command `carom` is not installed, and CAROM_COMMAND does not name it")
    words = " ".join(map(shlex.quote, shlex.split(found)))
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "carom").write_text(f'#!/bin/sh\nexec {words} "$@"\n')
    (tmp_path / "bin" / "carom").chmod(0o755)
    monkeypatch.setenv("PATH", os.pathsep.join([str(tmp_path / "bin"), os.environ["PATH"]]))

    def folder(name, until):
        (tmp_path / name).mkdir()
        (tmp_path / name / "scene.toml").write_text(SCENE.format(until=until))
        (tmp_path / name / "study.toml").write_text(STUDY)
        return tmp_path / name

    return folder


def table_of_one_process(folder):
    subprocess.run(["carom", "sweep", "study.toml", "--out", "one"], cwd=folder, check=True, capture_output=True)
    return (folder / "one" / "table.csv").read_bytes()


def pbs(folder, script, **variables):
    (folder / "script.pbs").write_text(listing(script))
    environment = {**os.environ, "PBS_O_WORKDIR": str(folder), **variables}
    return subprocess.Popen(["bash", str(folder / "script.pbs")], env=environment, cwd="/",
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def test_pbs(study):
    folder = study("short", 1.0)
    for index in range(1, 17):
        assert pbs(folder, "shards.pbs", PBS_ARRAY_INDEX=str(index)).wait(60) == 0
    assert pbs(folder, "merge.pbs").wait(60) == 0
    assert (folder / "all" / "table.csv").read_bytes() == table_of_one_process(folder)


def test_a_shard_that_pbs_ends_continues(study):
    folder = study("long", 1e6)
    shard = pbs(folder, "shards.pbs", PBS_ARRAY_INDEX="1")
    wait_for((folder / "shards" / "1" / "shards.json").exists)
    time.sleep(0.5)
    shard.send_signal(signal.SIGTERM)
    assert shard.wait(60) == 143
    assert list((folder / "shards" / "1" / "points").iterdir())


# Runs the command of a host on this machine, as sshd does: by a shell, in another folder, with the
# standard input of the connection. The host DOWN refuses.
SSH = """#!/bin/sh
while [ "$1" = -o ]; do shift 2; done
host=$1
shift
[ "$host" = "$DOWN" ] && { echo "ssh: connect to host $host: refused" >&2; exit 255; }
cd / && exec sh -c "$*"
"""


def hosts(folder, out):
    """Writes the scripts of a study for three hosts; `ssh` is a script that runs them here."""
    ssh = folder.parent / "bin" / "ssh"
    ssh.write_text(SSH)
    ssh.chmod(0o755)
    (folder / "hosts.txt").write_text("# my cluster\nnode1\nme@node2  # slow\n\nnode3\n")
    words = ["carom", "sweep", "study.toml", "--hosts", "hosts.txt", "--out", out]
    subprocess.run(words, cwd=folder, check=True, capture_output=True)
    # The scripts name the program, which in the tests may be a part of another one.
    for script in (folder / out / "run.sh", folder / out / "shard.sh"):
        script.write_text(re.sub(r"^'.*?'(?= --quiet sweep | merge )", "carom", script.read_text(), flags=re.M))
    return folder / out


def test_hosts(study):
    folder = study("short", 1.0)
    out = hosts(folder, "it's big")
    words = ["bash", str(out / "run.sh")]
    ended = subprocess.run(words, env={**os.environ, "DOWN": "node3"}, capture_output=True, text=True, timeout=120)
    assert ended.returncode == 1 and not (out / "all").exists()
    assert "shard 3 on node3 failed with the exit code 255" in ended.stderr and "1 of 3 shards failed" in ended.stderr
    assert "connect to host node3: refused" in (out / "logs" / "shard-3.log").read_text()
    assert not (out / "shards" / "3-of-3").exists()
    before = {path: path.stat().st_mtime_ns for path in out.glob("shards/*/points/*/*.record")}
    # Without the host that is down, its shard runs on another one; the others have ended.
    (out / "hosts").write_text("node1\nnode2\n")
    again = subprocess.run(words, env={**os.environ, "DOWN": "node3"}, capture_output=True, text=True, timeout=120)
    assert again.returncode == 0, again.stderr
    assert before and all(path.stat().st_mtime_ns == at for path, at in before.items())
    assert (out / "all" / "table.csv").read_bytes() == table_of_one_process(folder)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_shards_end_with_the_script_that_has_started_them(study, number):
    folder = study("long", 1e6)
    out = hosts(folder, "out")
    script = subprocess.Popen(["bash", str(out / "run.sh")], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wait_for(lambda: len(list(out.glob("shards/*/shards.json"))) == 3)
    time.sleep(0.5)
    script.send_signal(number)
    script.wait(60)
    # A shard that ends by SIGTERM has written a checkpoint of each replica that had begun.
    wait_for(lambda: len(list(out.glob("shards/*/points/*"))) >= 3)
    wait_for(lambda: not running(out))


def running(out):
    """Whether a process has the folder in its command line."""
    command = ["ps", "-A", "-o", "args="]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    return any(str(out) in line and "--quiet sweep" in line for line in lines)


def wait_for(condition):
    limit = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < limit
        time.sleep(0.05)


def test_snakemake(study):
    if importlib.util.find_spec("snakemake") is None:
        pytest.skip("no Snakemake")
    folder = study("short", 1.0)
    (folder / "Snakefile").write_text(listing("Snakefile"))
    words = [sys.executable, "-m", "snakemake", "--cores", "2"]
    ended = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    assert ended.returncode == 0, ended.stderr
    assert (folder / "all" / "table.csv").read_bytes() == table_of_one_process(folder)
