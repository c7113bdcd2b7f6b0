"""Any argument, right or wrong, gives a result or a Python exception: no panic, no crash."""

import copy
import itertools
import os
import pathlib

import carom
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from hypothesis.extra import numpy as hnp

# With CAROM_EXAMPLES, this number of other cases is drawn for each test.
MORE = os.environ.get("CAROM_EXAMPLES")
settings.register_profile("carom", deadline=None, max_examples=int(MORE or 60), derandomize=MORE is None,
                          suppress_health_check=list(HealthCheck), database=None)
settings.load_profile("carom")

# What a wrong argument may raise. A panic of the compiled part is a BaseException.
ORDERLY = (carom.CaromError, TypeError, ValueError, OverflowError, KeyError, AttributeError,
           RecursionError, OSError, IndexError)

numbers = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(-(2**70), 2**70),
    st.sampled_from([0.0, -0.0, 5e-324, 1e-60, 1e-61, 1e60, 1e61, 1.7e308, -1.0, 1.0, 0.5, np.nan]),
)
small = st.floats(-2, 2, allow_nan=False)
words = st.one_of(st.text(max_size=12), st.sampled_from(["gas", "tee", "", "\0", "\ud800", "a,b", "pressure"]))
objects = st.one_of(st.none(), st.booleans(), numbers, words, st.binary(max_size=4), st.complex_numbers(),
                    st.lists(numbers, max_size=4), st.just(object()), st.just({}), st.just(Ellipsis))
arrays = st.one_of(
    objects,
    hnp.arrays(st.sampled_from([np.float64, np.float32, np.int8, np.uint64, np.int64, bool, complex, "U3", object]),
               hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4)),
    hnp.arrays(np.float64, st.sampled_from([(2,), (3, 2), (0, 2), (2, 2)]), elements=small),
    st.lists(st.tuples(small, small), max_size=3),
)
ids = st.one_of(objects, arrays, st.lists(st.integers(-1, 130), max_size=6), st.sampled_from(["gas", "tee", "x"]))
json = st.recursive(objects, lambda inner: st.one_of(
    st.lists(inner, max_size=3), st.dictionaries(words, inner, max_size=3)), max_leaves=8)


def orderly(call, *arguments, **keywords):
    try:
        return call(*arguments, **keywords)
    except ORDERLY:
        return None


def small_gas():
    tee = carom.Molecule.tee(0.02).at(0.5, 0.5, tags="tee")
    gas = {"radius": 0.02, "mass": 1.0, "energy": 1.0, "count": 30, "tags": ["gas"]}
    return carom.Simulation(carom.Scene(molecule=tee, gas=gas, seed=1))


BASE = small_gas()


def small_results():
    sim = small_gas()
    speeds = sim.measure("velocities", of="gas", every=0.05)
    sim.run(until=1.0)
    return speeds.results, speeds.table


RESULTS = small_results()


def fresh():
    return copy.copy(BASE)


def sound(sim):
    """The simulation is still one: it runs on, and nothing overlaps."""
    count = len(sim)
    assert sim.positions.shape == (count, 2) and np.isfinite(sim.positions).all()
    # A faster body would cross the box for years.
    if np.abs(sim.velocities).max(initial=0) < 1e3 and np.abs(sim.angular_velocities).max(initial=0) < 1e3:
        orderly(sim.run, sim.time + 0.01)
    assert sim.overlapping_pairs == 0


@given(json)
def test_scene_of_anything(source):
    scene = orderly(carom.Scene, source)
    if scene is not None:
        scene.to_toml(), repr(scene), scene.tables, hash(scene)


@given(st.dictionaries(st.sampled_from(["box", "seed", "replica", "gas", "molecule", "bumper", "wall", "start",
                                        "elasticity", "method", "run", "stage", "measure"]), json, max_size=3))
def test_scene_of_any_keywords(keywords):
    orderly(carom.Scene, **keywords)


@given(st.dictionaries(st.sampled_from(["radius", "mass", "energy", "temperature", "area_fraction", "tags", "shape",
                                        "scale", "velocities", "rotation", "molecule", "atoms"]), json, max_size=5),
       st.integers(-3, 60))
def test_gas_of_any_entries(entries, count):
    base = {"radius": 0.01, "mass": 1.0, "energy": 1.0, "count": count}
    scene = orderly(carom.Scene, gas={**base, **entries})
    if scene is not None:
        sim = orderly(carom.Simulation, scene)
        if sim is not None:
            sound(sim)


@given(objects, objects, objects, objects)
def test_simulation_of_anything(scene, detector, scheduler, threads):
    orderly(carom.Simulation, scene, detector=detector, scheduler=scheduler, threads=threads)
    gas = {"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 4}]}
    orderly(carom.Simulation, gas, detector=detector)
    orderly(carom.Simulation, gas, scheduler=scheduler)


@given(arrays)
def test_molecule_of_anything(atoms):
    molecule = orderly(carom.Molecule, atoms)
    if molecule is not None:
        assert molecule.mass > 0 and len(molecule) > 0 and repr(molecule)


@given(st.lists(st.tuples(small, small, st.floats(1e-3, 2), st.floats(1e-3, 2)), min_size=1, max_size=5), numbers,
       numbers)
def test_outlines_of_any_molecule(atoms, probe, area):
    molecule = orderly(carom.Molecule, atoms)
    if molecule is not None:
        for method in (molecule.exposed_arcs, molecule.exposed_perimeter, molecule.excluded_area,
                       molecule.atom_shares, molecule.svg):
            orderly(method, probe)
        orderly(molecule.mean_free_path, area, probe)
        # Atoms may be so close that rounding makes them coincide.
        again = orderly(carom.Molecule, molecule.atoms.tolist())
        assert again is None or np.allclose(again.atoms, molecule.atoms, atol=1e-12)


@given(st.sampled_from(["disc", "dumbbell", "cross", "tee"]), objects, objects, st.one_of(objects, st.integers()))
def test_named_molecules_of_anything(shape, radius, mass, count):
    orderly(getattr(carom.Molecule, shape), radius, mass=mass)
    orderly(carom.Molecule.rod, count, radius=radius, mass=mass)
    orderly(carom.Molecule.ring, count, radius=radius)


@given(st.sampled_from(["square", "triangle"]), objects, objects, objects, st.one_of(objects, st.integers()))
def test_molecules_with_sides_of_anything(shape, size, mass, rounding, number):
    orderly(getattr(carom.Molecule, shape), size, mass=mass, rounding=rounding)
    orderly(carom.Molecule.capsule, number, size=size, mass=mass)
    orderly(carom.Molecule.rectangle, number, size=size, mass=mass, rounding=rounding)
    orderly(carom.Molecule.regular_polygon, number, size=size, rounding=rounding)
    orderly(carom.Molecule.kite, number, size, size=1.0, mass=mass)


@given(arrays, arrays, objects, objects)
def test_polygons_and_edges_of_anything(corners, edges, radius, hollow):
    orderly(carom.Molecule.polygon, corners, rounding=radius)
    orderly(carom.Molecule, [(0, 0, 1, 1), (3, 0, 1, 2)], edges=edges, edge_radius=radius, hollow=hollow)


@given(st.lists(st.tuples(small, small), min_size=3, max_size=7), st.floats(1e-10, 2), numbers)
def test_outlines_of_any_polygon(corners, rounding, probe):
    molecule = orderly(carom.Molecule.polygon, corners, rounding=rounding)
    if molecule is not None:
        assert molecule.area > 0 and len(molecule.edges) == len(corners)
        for method in (molecule.exposed_sides, molecule.exposed_arcs, molecule.excluded_area,
                       molecule.edge_shares, molecule.svg):
            orderly(method, probe)


@given(arrays, arrays, arrays, arrays, arrays, objects)
def test_first_contact_of_anything(separation, velocity, angles, spins, until, detector):
    disc, tee = carom.Molecule.disc(0.5), carom.Molecule.tee(0.5)
    orderly(carom.first_contact, disc, tee, separation, velocity, angles=angles, angular_velocities=spins)
    orderly(carom.first_contact, disc, tee, [3, 0], velocity, until=until)
    orderly(carom.first_contact, disc, tee, separation, [1, 0], detector=detector)
    orderly(carom.first_contact, separation, tee, [3, 0], [1, 0])


@given(st.tuples(numbers, numbers), st.tuples(numbers, numbers), st.tuples(numbers, numbers),
       st.tuples(numbers, numbers), numbers)
def test_first_contact_of_any_numbers(separation, velocity, angles, spins, until):
    rod = carom.Molecule.rod(3, radius=0.5)
    found = orderly(carom.first_contact, rod, rod, separation, velocity, angles=angles,
                    angular_velocities=spins, until=until)
    if found is not None:
        assert found.time >= 0


@given(objects)
def test_run_until_anything(until):
    if isinstance(until, (int, float, np.floating)) and not isinstance(until, bool) and 1e4 < abs(until) < np.inf:
        return  # It would take years.
    sim = fresh()
    orderly(sim.run, until)
    orderly(sim.step, until)
    orderly(sim.collisions, until)
    sound(sim)


@given(objects, objects)
def test_subscriptions_of_anything(between, callback):
    sim = fresh()
    orderly(sim.collisions, 0.05, between=between)
    decorate = orderly(sim.on_collision, between=between)
    if decorate is not None:
        orderly(decorate, callback)
        orderly(sim.run, 0.1)


@given(st.one_of(words, st.sampled_from(sorted(carom.measures()))), objects, objects, objects,
       st.dictionaries(st.sampled_from(["bins", "max", "interval", "every", "shells", "x", "tau"]), objects, max_size=2))
def test_measures_of_anything(kind, of, every, name, parameters):
    sim = fresh()
    every = every if isinstance(every, float) and (not every > 0 or every > 1e-3) else 0.05
    parameters = {key: value for key, value in parameters.items() if key != "every"}
    for bodies in (of, "tee", "gas", None):
        measure = orderly(sim.measure, kind, bodies, every=every, name=name, **parameters)
        if measure is not None:
            sim.run(until=0.2)
            measure.results, measure.tables, measure._repr_html_()
            measure.stop()
    sound(sim)


@given(ids, arrays)
def test_edits_of_anything(which, energy):
    sim = fresh()
    for call in (sim.lock, sim.unlock, sim.remove):
        orderly(call, which)
    orderly(sim.set_energy, energy, which)
    orderly(sim.set_energy, 1.0, which)
    orderly(sim.set_velocity, energy, which)
    orderly(sim.set_angular_velocity, energy, which)
    orderly(sim.tag, which, "x")
    orderly(sim.untag, which, "x")
    sound(sim)


@given(arrays, arrays, arrays, arrays, objects, st.booleans(), st.booleans())
def test_added_bodies_of_anything(at, angle, velocity, spin, tags, locked, fixed):
    sim = fresh()
    disc, tee = carom.Molecule.disc(0.001), carom.Molecule.tee(0.001)
    orderly(sim.add, disc, at)
    orderly(sim.add, tee, [0.111, 0.222], angle=angle, locked=locked, fixed=fixed)
    orderly(sim.add, tee, [[0.811, 0.222]], velocity=velocity, angular_velocity=spin, tags=tags)
    orderly(sim.add, at, [0.1, 0.1])
    sound(sim)


@given(objects, objects, arrays, objects, objects, objects)
def test_walls_of_anything(x, y, ends, radius, temperature, tags):
    sim = carom.Simulation(carom.Scene())
    orderly(sim.add_wall, x=x, y=y)
    orderly(sim.add_wall, ends=ends, radius=radius)
    orderly(sim.add_wall, x=0.5, temperature=temperature, tags=tags)


@given(objects, objects, json)
def test_elasticities_of_anything(default, contact_time, pairs):
    sim = fresh()
    orderly(sim.set_elasticity, default)
    orderly(sim.set_drag, default)
    orderly(sim.set_gravity, default)
    orderly(sim.set_gravity, [default, contact_time])
    orderly(sim.set_elasticity, 0.9, contact_time=contact_time, pairs=pairs)
    orderly(sim.run, 0.05)


@given(words, words, st.dictionaries(st.sampled_from([
    "every", "energy", "temperature", "speed", "rotational_diffusion", "friction", "momentum"]), arrays, max_size=3))
def test_thermostats_of_anything(tag, kind, numbers):
    sim = fresh()
    orderly(sim.thermostat, tag, kind, **numbers)
    for known in ("energy-reset", "maxwell", "active", "langevin", "rotate", "kick", "rescale"):
        orderly(sim.thermostat, "gas", known, **numbers)
    orderly(sim.set_transparent, [tag, kind])
    sound(sim)


@given(objects)
def test_shear_rates_of_anything(rate):
    sim = fresh()
    orderly(sim.set_shear_rate, rate)
    # A faster image would pass the box for years.
    if isinstance(rate, (int, float)) and abs(rate) < 1e3:
        sound(sim)


@given(objects)
def test_files_of_anything(path):
    if isinstance(path, str):
        path = f"/no/such/{path}"
    if isinstance(path, int) and not isinstance(path, bool):
        return
    for call in (carom.load, carom.open_run, carom.Scene.from_file, fresh().save):
        orderly(call, path)


@given(st.binary(max_size=200))
def test_bytes_are_no_results(data):
    orderly(carom.Results, data)
    orderly(carom._carom.merge_records, data, data)
    orderly(carom._carom.table_pictures, data, "x")


@given(st.data())
def test_checkpoints_with_changed_bytes(tmp_path_factory, data):
    path = pathlib.Path(tmp_path_factory.getbasetemp()) / "hostile"
    sim = fresh()
    sim.measure("pressure", every=0.01)
    sim.save(path)
    whole = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(bytes(whole[: data.draw(st.integers(0, len(whole)))]))
    orderly(carom.load, path)


@given(json, objects, json, objects, objects)
def test_runs_of_anything(run, until, measures, n, processes):
    if isinstance(until, (int, float)) and not 0 < until < 10:
        until = -1.0
    gas = {"radius": 0.02, "mass": 1, "energy": 1, "count": 5}
    scene = orderly(carom.Scene, gas=gas, run=run)
    if scene is not None and scene.tables["run"]["until"] < 10:
        orderly(carom.run, scene)
    plain = carom.Scene(gas=gas)
    orderly(carom.run, plain, until=until, measures=measures)
    orderly(carom.replicas, plain, n if not isinstance(n, int) or n < 4 else 2, processes=processes, until=0.1)


@given(st.lists(st.tuples(st.sampled_from(["remove", "lock", "energy", "add", "tag", "run", "step", "measure", "save"]),
                          st.integers(0, 40)), max_size=12))
def test_any_order_of_calls(tmp_path_factory, calls):
    """Deleted bodies, use after edit: what is refused changes nothing."""
    path = pathlib.Path(tmp_path_factory.getbasetemp()) / "order"
    sim = fresh()
    found = []
    for name, which in calls:
        if name == "remove":
            orderly(sim.remove, [which])
        elif name == "lock":
            orderly(sim.lock, [which])
        elif name == "energy":
            orderly(sim.set_energy, 0.1 + which, [which])
        elif name == "add":
            orderly(sim.add, carom.Molecule.tee(0.004), [which / 41, 0.37], tags="new")
        elif name == "tag":
            orderly(sim.tag, [which], f"t{which % 3}")
        elif name == "run":
            sim.run(sim.time + 0.002 * which)
        elif name == "step":
            sim.step()
        elif name == "measure":
            kind = sorted(carom.measures())[which % len(carom.measures())]
            found.append(orderly(sim.measure, kind, ["tee", "gas", None][which % 3], every=0.01))
        else:
            sim.save(path)
            assert (carom.load(path).positions == sim.positions).all()
        for measure in found:
            if measure is not None:
                measure.results
    sound(sim)


@given(arrays, objects, objects, objects, objects, objects)
def test_entries_of_anything(velocity, x, angle, tags, locked, fixed):
    molecule = carom.Molecule.tee(0.01)
    orderly(molecule.at, x, 0.5, velocity=velocity)
    orderly(molecule.at, 0.5, 0.5, angle=angle, tags=tags)
    entry = orderly(molecule.at, 0.5, 0.5, angular_velocity=x, locked=locked, fixed=fixed)
    if entry is not None:
        orderly(carom.Simulation, orderly(carom.Scene, molecule=entry) or {})


@given(st.text(max_size=60), st.dictionaries(st.sampled_from(["box", "seed", "gas", "nothing"]), json, max_size=2))
def test_scene_texts_of_anything(text, changes):
    orderly(carom.Scene.from_toml, text)
    orderly(carom.Scene, text + "\n")
    orderly(carom.Scene().replaced, **changes)


@given(objects, arrays)
def test_views_of_anything(value, array):
    sim = fresh()
    for given_value in (value, array):
        for call in (sim.show, sim.svg, sim.mask, sim.off_collision):
            orderly(call, *([] if call is sim.show else [given_value]),
                    **({"height": given_value} if call is sim.show else {}))
        orderly(sim.run, sim.time, progress=given_value)
        orderly(carom.Html, given_value)
    sound(sim)


@given(objects, arrays)
def test_results_with_anything(value, array):
    results, table = RESULTS
    for given_value in (value, array):
        for operand in (results, table):
            orderly(lambda: operand + given_value)
            orderly(lambda: given_value + operand)
            orderly(lambda: operand[given_value])
            orderly(lambda: operand == given_value)


@given(objects)
def test_columns_and_axes_of_anything(ax):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("Agg")
    orderly(RESULTS[1].plot, ax)
    orderly(RESULTS[1].plot, ax=ax)
    pyplot.close("all")


@given(objects, objects, objects)
def test_replicas_of_anything(n, first, executor):
    plain = carom.Scene(gas={"radius": 0.02, "mass": 1, "energy": 1, "count": 5})
    orderly(carom.replicas, plain, 1, first=first, until=0.1)
    orderly(carom.replicas, plain, 1, executor=executor, until=0.1)


def test_callbacks_may_do_anything_to_their_simulation():
    """Edits, measures, copies and files below a callback; a run is refused."""
    sim = fresh()
    refused, calls = [], []

    @sim.on_collision()
    def interfere(hit):
        calls.append(hit)
        orderly(sim.remove, [hit.ids[len(calls) % 2]])
        orderly(sim.add, carom.Molecule.disc(0.001), [0.1 * (len(calls) % 10), 0.5], velocity=[1.0, 0.0])
        orderly(sim.measure, "pressure", every=0.01)
        assert sim.copy().time == hit.time
        for call in (sim.run, sim.step, sim.collisions):
            with pytest.raises(carom.BusyError):
                call(until=9.0)
            refused.append(call)
        sim.off_collision(interfere)
        sim.on_collision()(interfere)

    sim.run(until=0.5)
    assert len(calls) > 5 and len(refused) == 3 * len(calls)
    sim.off_collision(interfere)
    sound(sim)


def test_an_endless_list_of_atoms_is_refused():
    with pytest.raises(carom.MoleculeError, match="at most 65536"):
        carom.Molecule((i, 0, 0.5, 1) for i in itertools.count())


@pytest.mark.parametrize("value", [1 + 2j, np.complex128(1 + 2j), True, np.True_, "1", None, [1.0]])
def test_what_is_no_real_number_is_no_time(value):
    with pytest.raises(TypeError, match="`until` must be a number"):
        fresh().run(value)


def test_numbers_of_numpy_are_numbers():
    sim = fresh()
    sim.run(until=np.array(0.125))
    assert sim.time == 0.125
    plain = carom.Scene(gas={"radius": 0.02, "mass": 1, "energy": 1, "count": 5})
    assert carom.replicas(plain, np.int64(2), until=0.1).runs == [(0, 0), (0, 1)]
    for size in (-1, 0, 10**9, np.nan, 100.5):
        with pytest.raises(ValueError, match="`height` must be a whole number from 16 to 16384"):
            sim.show(height=size)


def test_nested_and_endless_structures_are_refused():
    endless = {}
    endless["gas"] = endless
    deep = {}
    for _ in range(300):
        deep = {"gas": [deep]}
    for source in (endless, deep, {"gas": [[[[]]]]}, {1: 2}, {"box": {"sides": [10**400, 1]}}):
        with pytest.raises(ORDERLY):
            carom.Simulation(carom.Scene(source))
