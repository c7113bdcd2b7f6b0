"""Measures, tables, merging, run folders: the same numbers as the command."""

import concurrent.futures
import json
import multiprocessing
import os
import pathlib
import shlex
import shutil
import subprocess

import carom
import numpy as np
import pytest

GAS = {"radius": 0.02, "mass": 1.0, "temperature": 1.0, "velocities": "maxwell", "count": 150, "tags": ["gas"]}
RUN = {"until": 2.0, "sample_interval": 0.05}


def scene(**changes):
    return carom.Scene(gas=GAS, run=RUN, seed=5).replaced(**changes)


@pytest.fixture(scope="session")
def command():
    """The words of the command `carom`, which CI builds before."""
    found = os.environ.get("CAROM_COMMAND") or shutil.which("carom")
    if not found:
        pytest.skip("the command `carom` is not installed, and CAROM_COMMAND does not name it")
    return shlex.split(found)


def run_command(command, scene, folder, *options):
    file = folder.with_suffix(".toml")
    file.write_text(scene.to_toml())
    subprocess.run([*command, "run", str(file), "--out", str(folder), *options], check=True, capture_output=True)


def state(sim):
    return np.column_stack([sim.positions, sim.velocities, sim.angles, sim.angular_velocities])


def test_measures_of_a_simulation_are_those_of_a_run():
    whole = carom.run(scene(), measures=["pressure", "velocities:gas", "pair-distribution:gas"])
    sim = carom.Simulation(scene())
    parts = [sim.measure("pressure"), sim.measure("velocities", "gas"), sim.measure("rdf", "gas")]
    sim.run(until=2.0)
    for part in parts:
        for name, table in part.tables.items():
            for column in table:
                assert np.array_equal(table[column], whole[name][column], equal_nan=True), (name, column)
        for name, figure in part.figures.items():
            assert figure == whole.figures[name]


def test_tables_have_units_errors_and_predictions():
    table = carom.run(scene(), measures=["velocities:gas"])["speeds-gas"]
    assert table.abscissa == "speed" and table.units["speed"] == "length/time"
    assert set(table.predictions) == {"density"} and table.sources
    error = table.errors["density"]
    assert error.shape == (len(table),) and np.nanmax(error) > 0
    array = table.to_numpy()
    assert array.dtype.names == tuple(table) and np.array_equal(array["speed"], table["speed"])
    with pytest.raises(ValueError):
        table["density"][0] = 1.0
    with pytest.raises(KeyError, match="columns"):
        table["nothing"]
    # The measured density agrees with Maxwell's within five standard errors nearly everywhere.
    known = error > 0
    off = np.abs(table["density"] - table.predictions["density"])[known] / error[known]
    assert known.sum() > 10 and np.mean(off < 5) > 0.9


def test_pandas_and_matplotlib_show_what_numpy_has():
    pandas = pytest.importorskip("pandas")
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    table = carom.run(scene(), measures=["velocities:gas"])["speeds-gas"]
    frame = table.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and list(frame) == list(table)
    assert frame.attrs["units"] == table.units
    ax = table.plot()
    assert np.array_equal(ax.lines[0].get_ydata(), table["density"], equal_nan=True)
    assert ax.get_xlabel() == "speed (length/time)" and ax.collections
    moments = carom.run(scene(), measures=["velocities:gas"])["velocities-gas"]
    ax = moments.plot("kurtosis")
    assert np.array_equal(ax.lines[0].get_ydata(), moments["kurtosis"], equal_nan=True)
    with pytest.raises(ValueError, match="must be one of mean_square, kurtosis"):
        moments.plot("curtosis")
    assert table.svg()[0].count("<svg") == 1 and "<svg" in table._repr_html_()
    for measure in carom.measures():
        if measure in ("impulses", "events"):
            continue
        of_one = ("directions", "drift", "kicks", "projections", "running-average", "contact-density")
        of = "tee" if measure in of_one else None
        tee = carom.Molecule.tee(0.02).at(0.5, 0.5, tags="tee")
        sim = carom.Simulation(scene(molecule=tee, gas={**GAS, "count": 40}))
        try:
            found = sim.measure(measure, of, every=0.1)
        except carom.MeasureError as error:
            assert of is None or "no tag" in str(error), (measure, error)
            continue
        sim.run(until=1.0)
        for table in found.tables.values():
            if any(column.role == "abscissa" for column in table.columns.values()):
                table.plot()
                matplotlib.pyplot.close("all")
        assert found.results._repr_html_()


def test_polars_and_xarray_hold_what_numpy_has():
    polars, xarray = pytest.importorskip("polars"), pytest.importorskip("xarray")
    scene = carom.Scene(gas={"radius": 0.02, "mass": 1, "energy": 1, "count": 50, "tags": ["gas"]})
    sim = carom.Simulation(scene)
    correlation, fields = sim.measure("correlation", every=0.1), sim.measure("fields", of="gas", every=0.1)
    sim.run(until=2)
    table = correlation.table
    frame, data = table.to_polars(), table.to_xarray()
    assert isinstance(frame, polars.DataFrame) and isinstance(data, xarray.Dataset)
    for name, values in table.columns.items():
        assert np.array_equal(data[name].values, values.values, equal_nan=True)
        assert np.array_equal(frame[name].to_numpy(), values.values, equal_nan=True)
        assert data[name].attrs["units"] == values.unit
    assert list(data.sizes) == ["lag"]
    assert frame["mean_square_displacement"].is_nan().sum() == 0
    grid = fields.table.to_xarray()
    assert list(grid.sizes) == ["cell"] and len(grid.coords) == 2


def test_the_mean_of_a_series_has_the_error_of_measures():
    rng = np.random.default_rng(3)
    # x' = a x + noise: the mean of n has the variance (1 + a)/(1 − a)/n, ten times that of single samples.
    memory, n, found = 0.8, 4000, []
    for _ in range(40):
        noise = rng.normal(size=n) * np.sqrt(1 - memory**2)
        x = np.empty(n)
        x[0] = rng.normal()
        for i in range(1, n):
            x[i] = memory * x[i - 1] + noise[i]
        found.append(carom.estimate(x))
    exact = np.sqrt((1 + memory) / (1 - memory) / n)
    errors = np.sqrt(np.mean([figure.standard_error**2 for figure in found]))
    assert 0.85 < errors / exact < 1.15
    assert np.abs([figure.value for figure in found]).max() < 4 * exact
    assert sum(figure.stationary is True for figure in found) > 35
    rising = carom.estimate(np.linspace(0, 1, 200) + rng.normal(size=200) * 0.01)
    assert rising.stationary is False
    assert carom.estimate([1.0]).standard_error is None
    weighted = carom.estimate([1.0, 3.0], [1.0, 3.0], name="speed", unit="length/time")
    assert (weighted.value, weighted.name, weighted.unit) == (2.5, "speed", "length/time")
    for wrong in ([], [[1.0]], [1.0, np.nan]):
        with pytest.raises(ValueError):
            carom.estimate(wrong)
    for weights in ([1.0], [0.0, 1.0], [-1.0, 1.0]):
        with pytest.raises(ValueError):
            carom.estimate([1.0, 2.0], weights)


def test_a_function_is_sampled_at_equal_intervals():
    gas = {"radius": 0.02, "mass": 1, "energy": 1, "count": 20}
    sim, same = (carom.Simulation(carom.Scene(gas=gas, seed=1)) for _ in range(2))
    times = sim.sample(lambda sim: sim.time, every=0.1, until=1.05)
    assert np.allclose(times, np.arange(1, 11) * 0.1) and sim.time == 1.05
    same.run(1.05)
    assert np.array_equal(sim.positions, same.positions)
    assert len(sim.sample(lambda sim: 0, every=10.0, until=1.1)) == 0 and sim.time == 1.1
    for every in (0.0, -1.0, 1e-12):
        with pytest.raises(ValueError):
            sim.sample(lambda sim: 0, every=every, until=2.0)


def test_replicas_merge_to_the_same_digits_in_any_order():
    parts = [carom.run(scene(replica=index), measures=["pressure"]) for index in range(3)]
    one = parts[0] + parts[1] + parts[2]
    other = parts[2] + (parts[0] + parts[1])
    by_threads = carom.replicas(scene(), 3, measures=["pressure"])
    assert one == other == by_threads == sum(parts) and one.runs == [(5, 0), (5, 1), (5, 2)]
    pressures = [part.figures["pressure"].value for part in parts]
    assert min(pressures) < one.figures["pressure"].value < max(pressures)
    with pytest.raises(carom.MeasureError, match="twice"):
        one + parts[1]
    with pytest.raises(carom.MeasureError, match="another run"):
        one + carom.run(scene(seed=6, gas={**GAS, "count": 20}), measures=["pressure"])
    tables = [carom.run(scene(replica=index), measures=["pair-distribution:gas"]) for index in (0, 1)]
    merged = tables[0]["pair-distribution-gas"] + tables[1]["pair-distribution-gas"]
    assert sum(part["pair-distribution-gas"] for part in tables).results == merged.results
    assert np.nanmean(merged.errors["g"]) < np.nanmean(tables[0]["pair-distribution-gas"].errors["g"]) * 1.1


def test_replicas_run_in_other_processes():
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(2, context) as pool:
        found = carom.replicas(scene(), 2, measures=["pressure"], executor=pool)
    assert found == carom.replicas(scene(), 2, measures=["pressure"], processes=1)


def test_the_command_and_python_give_the_same_bits(command, tmp_path):
    described = scene(
        molecule=carom.Molecule.tee(0.02).at(0.5, 0.5, tags="tee"),
        run={**RUN, "observe": ["pressure", "velocities:gas", "correlation:gas", "directions:tee"]},
    )
    folder = tmp_path / "run"
    run_command(command, described, folder)
    opened, found = carom.open_run(folder), carom.run(described)
    assert opened == found and found.overlapping_pairs == 0 and found.energy_drift < 1e-11
    sim = carom.Simulation(described)
    sim.run(until=2.0)
    ended = carom.load(folder)
    assert ended.time == 2.0 and (state(ended) == state(sim)).all()
    # The rows of the command's files are those of the tables.
    rows = np.genfromtxt(folder / "velocities-gas.csv", delimiter=",", names=True)
    for column in rows.dtype.names:
        assert np.array_equal(rows[column], found["velocities-gas"][column], equal_nan=True)
    summary = json.loads((folder / "summary.json").read_text())
    pressure = next(entry for entry in summary["figures"] if entry["name"] == "pressure")
    assert pressure["value"] == found.figures["pressure"].value


def test_the_command_starts_from_a_saved_simulation(command, tmp_path):
    sim = carom.Simulation(scene())
    sim.run(until=1.0)
    (tmp_path / "saved").mkdir()
    sim.save(tmp_path / "saved" / "checkpoint")
    rules = carom.Scene(run=RUN, seed=5)
    run_command(command, rules, tmp_path / "next", "--from", str(tmp_path / "saved"))
    sim.run(until=3.0)
    ended = carom.load(tmp_path / "next")
    assert ended.time == 2.0
    distance = ended.positions - sim.positions
    # The clock begins anew at 0, so that times differ by rounding.
    assert np.abs(distance - np.round(distance)).max() < 1e-3


def test_a_run_that_has_not_ended_is_refused_by_open_run(tmp_path):
    with pytest.raises(carom.CheckpointError, match="no run that has ended"):
        carom.open_run(tmp_path)


THREE_WAYS = pathlib.Path(__file__).parents[3] / "tests" / "data"


def fingerprint(sim):
    """FNV-1a, 64 bits, as in `tests/determinism.rs`."""
    found = 0xCBF29CE484222325
    for byte in np.ascontiguousarray(state(sim), dtype="<f8").tobytes():
        found = (found ^ byte) * 0x100000001B3 % 2**64
    return f"{found:#018x}"


def test_rust_and_the_command_and_python_give_the_same_bits(command, tmp_path):
    # The test of the Rust library reads the same two files.
    pinned = (THREE_WAYS / "three_ways.fingerprint").read_text().strip()
    described = carom.Scene.from_file(THREE_WAYS / "three_ways.toml")
    end = described.tables["run"]["until"]
    sim = carom.Simulation(described)
    sim.run(until=end)
    assert sim.collision_count > 500 and fingerprint(sim) == pinned
    run_command(command, described, tmp_path / "run")
    ended = carom.load(tmp_path / "run")
    assert ended.time == end and fingerprint(ended) == pinned


def test_parallel_libraries_run_replicas():
    joblib = pytest.importorskip("joblib")
    scenes = [scene(replica=index) for index in range(4)]
    alone = carom.replicas(scene(), 4, measures=["pressure"], processes=1)
    for backend in ("loky", "threading"):
        jobs = (joblib.delayed(carom.run)(one, measures=["pressure"]) for one in scenes)
        assert sum(joblib.Parallel(n_jobs=2, backend=backend)(jobs)) == alone


def of_replica(index):
    return carom.run(scene(replica=index), measures=["pressure"])


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_multiprocessing_runs_replicas(method):
    # Also a fork of a process whose threads have run simulations.
    alone = carom.replicas(scene(), 3, measures=["pressure"])
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert sum(pool.map_async(of_replica, range(3)).get(timeout=120)) == alone


def test_dask_runs_replicas():
    distributed = pytest.importorskip("distributed")
    alone = carom.replicas(scene(), 3, measures=["pressure"])
    with distributed.Client(n_workers=2, threads_per_worker=1, dashboard_address=None, processes=True) as client:
        assert carom.replicas(scene(), 3, measures=["pressure"], executor=client.get_executor()) == alone
        futures = [client.submit(carom.run, scene(replica=index), measures=["pressure"]) for index in range(3)]
        assert sum(client.gather(futures)) == alone
