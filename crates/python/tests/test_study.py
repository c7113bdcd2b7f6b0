"""Studies: points, random numbers, executors, progress; the digits of the command `carom sweep`."""

import concurrent.futures
import json
import math
import multiprocessing
import os
import shlex
import shutil
import subprocess
import sys

import carom
import pytest

GAS = {"radius": 0.02, "mass": 1.0, "temperature": 1.0, "velocities": "maxwell", "count": 50, "tags": ["gas"]}
SCENE = carom.Scene(gas=GAS, run={"until": 1.0, "sample_interval": 0.05}, seed=5)
VARY = {"gas.0.count": [50, 80], ("gas.0.radius", "elasticity.default"): [(0.02, 1.0), (0.01, 0.95)]}


def study(**changes):
    return carom.Study(SCENE, VARY, **{"replicas": 2, "measures": ["pressure"], **changes})


class Backwards(concurrent.futures.Executor):
    """Runs all tasks when the first result is waited for, the last one first."""

    def __init__(self):
        self._tasks = []

    def submit(self, function, *arguments):
        future = concurrent.futures.Future()
        self._tasks.append((future, function, arguments))
        if len(self._tasks) == 8:
            for task, called, given in reversed(self._tasks):
                task.set_result(called(*given))
        return future


def test_random_numbers_of_a_point_are_those_of_the_command():
    # Pinned in `crates/sweeps/src/point.rs`.
    base = carom.Scene.from_toml("[box]\nseed = 5\n[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 10\n")
    [scene] = carom.Study(base, {"gas.0.radius": [0.02]}).scenes
    assert scene.tables["box"]["seed"] == 1_378_381_359_289_797_912 and scene.tables["box"]["replica"] == 1


def test_points_are_all_combinations_and_their_seeds_depend_on_values_alone():
    whole = study()
    assert [list(point.values()) for point in whole.points] == [
        [50, 0.02, 1.0], [50, 0.01, 0.95], [80, 0.02, 1.0], [80, 0.01, 0.95]
    ]
    assert [scene.tables["box"]["replica"] for scene in whole.scenes] == [1, 2] * 4
    assert len({scene.tables["box"]["seed"] for scene in whole.scenes}) == 4
    reversed_keys = {keys: values[::-1] for keys, values in reversed(VARY.items())}
    other = carom.Study(SCENE, reversed_keys, replicas=2, measures=["pressure"])
    assert set(other.scenes) == set(whole.scenes) and other.scenes != whole.scenes


@pytest.mark.parametrize("kind", ["backwards", "processes", "dask"])
def test_an_executor_gives_the_results_of_one_thread(kind):
    alone = study().run(processes=1)
    assert [point.results.runs[0][1] for point in alone] == [1] * 4
    if kind == "backwards":
        assert study().run(executor=Backwards()) == alone
    elif kind == "processes":
        context = multiprocessing.get_context("spawn")
        with concurrent.futures.ProcessPoolExecutor(2, context) as pool:
            assert study().run(executor=pool) == alone
    else:
        distributed = pytest.importorskip("distributed")
        with distributed.Client(n_workers=2, threads_per_worker=1, dashboard_address=None, processes=True) as client:
            assert study().run(executor=client.get_executor()) == alone


MPI_PROGRAM = """
import carom
from mpi4py.futures import MPICommExecutor
from mpi4py import MPI
import test_study

with MPICommExecutor(MPI.COMM_WORLD, root=0) as pool:
    if pool is not None:
        assert MPI.COMM_WORLD.size == 3
        assert test_study.study().run(executor=pool) == test_study.study().run(processes=1)
        print("equal")
"""


def test_mpi_gives_the_results_of_one_thread(tmp_path):
    # In a process of its own: MPI is initialised when it is imported.
    if subprocess.run([sys.executable, "-c", "import mpi4py.MPI"], capture_output=True, check=False).returncode:
        pytest.skip("no mpi4py with an MPI library")
    launcher = shutil.which("mpiexec", path=os.pathsep.join([os.path.dirname(sys.executable), os.environ["PATH"]]))
    if launcher is None:
        pytest.skip("no mpiexec")
    (tmp_path / "program.py").write_text(MPI_PROGRAM)
    path = os.pathsep.join([os.path.dirname(__file__), *filter(None, sys.path)])
    words = [launcher, "-n", "3", sys.executable, str(tmp_path / "program.py")]
    ended = subprocess.run(words, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=120)
    assert ended.returncode == 0 and ended.stdout.strip() == "equal", ended.stderr


def test_the_command_gives_the_same_digits(tmp_path):
    found = os.environ.get("CAROM_COMMAND") or shutil.which("carom")
    if not found:
        pytest.skip("the command `carom` is not installed, and CAROM_COMMAND does not name it")
    (tmp_path / "scene.toml").write_text(SCENE.to_toml())
    (tmp_path / "study.toml").write_text(
        'scene = "scene.toml"\nreplicas = 2\nmeasure = ["pressure"]\n'
        '[[vary]]\nkey = "gas.0.count"\nvalues = [50, 80]\n'
        '[[vary]]\nkeys = ["gas.0.radius", "elasticity.default"]\nvalues = [[0.02, 1.0], [0.01, 0.95]]\n'
    )
    out = tmp_path / "out"
    words = [*shlex.split(found), "sweep", str(tmp_path / "study.toml"), "--out", str(out)]
    subprocess.run(words, check=True, capture_output=True)
    rows = (out / "table.csv").read_text().splitlines()
    table = [dict(zip(rows[0].split(","), row.split(","))) for row in rows[1:]]
    points = study().run()
    assert len(table) == len(points)
    for row, point in zip(table, points):
        pressure = point.results.figures["pressure"]
        assert float(row["pressure"]) == pressure.value, json.dumps(row)


def test_errors_name_the_point_the_value_and_the_range():
    for vary, error, words in [
        ({"gas.1.radius": [0.1]}, carom.SceneError, "`gas.1.radius`: '1' is no entry of a list of 1 entries"),
        ({"gas.x.radius": [0.1]}, carom.SceneError, "'x' is no entry of a list"),
        ({"gas.0.radius.x": [0.1]}, carom.SceneError, "which has no entries"),
        ({"gas.0.raduis": [0.1]}, carom.SceneError, "(?s)point gas.0.raduis = 0.1: .*did you mean `radius`?"),
        ({"box.seed": [1]}, ValueError, "`box.seed` cannot vary: `replicas`"),
        ({"gas.0.radius": []}, ValueError, "gas.0.radius needs a sequence of at least one value"),
        ({"gas.0.tags": "gas"}, ValueError, "needs a sequence of at least one value, not 'gas'"),
        ({"gas.0.count": [50, 50.0]}, ValueError, "point gas.0.count = 50 occurs twice"),
        ({("gas.0.count", "gas.0.mass"): [(1,)]}, ValueError, r"needs 2 values at each point, not \(1,\)"),
        ({"gas.0.count": [1], ("gas.0.count",): [(2,)]}, ValueError, "`vary` has a key twice"),
    ]:
        with pytest.raises(error, match=words):
            carom.Study(SCENE, vary)
    with pytest.raises(ValueError, match="`replicas` must be a whole number from 1 on, but is 0"):
        study(replicas=0)
    with pytest.raises(carom.RunError, match=r"point gas.0.radius = 0.9, replica 1: gas\[0\]"):
        carom.Study(SCENE, {"gas.0.radius": [0.02, 0.9]}).run()


def test_an_error_cancels_the_runs_that_have_not_begun():
    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        endless = carom.Study(SCENE, {"gas.0.radius": [0.9], "run.until": [1.0, *(1e5 + k for k in range(3))]})
        with pytest.raises(carom.RunError, match="gas.0.radius = 0.9"):
            endless.run(executor=pool)


def test_progress_is_a_line_without_tqdm(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    study().run(progress=True)
    assert capsys.readouterr().err.endswith("8 of 8 runs\n")


def test_progress_is_that_of_tqdm(capsys):
    pytest.importorskip("tqdm.auto")
    study().run(progress=True)
    assert "8/8" in capsys.readouterr().err


def test_a_study_without_keys_is_one_point():
    [point] = carom.Study(SCENE, {}, until=0.5).run()
    assert point.values == {} and math.isclose(point.results.simulated_time, 0.5)
