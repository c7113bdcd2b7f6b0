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
    limit = time.monotonic() + 60
    while not (folder / "shards" / "1" / "shards.json").exists():
        assert time.monotonic() < limit
        time.sleep(0.05)
    time.sleep(0.5)
    shard.send_signal(signal.SIGTERM)
    assert shard.wait(60) == 143
    assert list((folder / "shards" / "1" / "points").iterdir())


def test_snakemake(study):
    if importlib.util.find_spec("snakemake") is None:
        pytest.skip("no Snakemake")
    folder = study("short", 1.0)
    (folder / "Snakefile").write_text(listing("Snakefile"))
    words = [sys.executable, "-m", "snakemake", "--cores", "2"]
    ended = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    assert ended.returncode == 0, ended.stderr
    assert (folder / "all" / "table.csv").read_bytes() == table_of_one_process(folder)
