"""Runs, arrays, edits and collisions: physics that must hold."""

import copy
import pickle
import signal
import threading
import time

import carom
import numpy as np
import pytest

GAS = {"radius": 0.02, "mass": 1.0, "energy": 1.0, "count": 100, "tags": ["gas"]}


def gas(**changes):
    return carom.Simulation(carom.Scene(gas={**GAS, **changes}, seed=3))


def tee_in_gas():
    tee = carom.Molecule.tee(0.02).at(0.5, 0.5, tags="tee")
    return carom.Simulation(carom.Scene(molecule=tee, gas=GAS, seed=3))


def state(sim):
    return np.column_stack([sim.positions, sim.velocities, sim.angles, sim.angular_velocities])


def test_energy_and_momentum_are_conserved_and_nothing_overlaps():
    sim = tee_in_gas()
    energy, momentum = sim.energy, sim.momentum
    sim.run(until=5)
    assert sim.collision_count > 500
    assert abs(sim.energy - energy) < 1e-11 * energy
    assert np.abs(sim.momentum - momentum).max() < 1e-11
    assert sim.overlapping_pairs == 0


def test_arrays_agree_with_one_another():
    sim = tee_in_gas()
    sim.run(until=1)
    assert sim.positions.shape == (101, 2) and ((sim.positions >= 0) & (sim.positions < 1)).all()
    energies = 0.5 * sim.masses * (sim.velocities**2).sum(axis=1)
    tee = carom.Molecule.tee(0.02)
    energies += 0.5 * tee.moment_of_inertia * sim.angular_velocities**2 * sim.mask("tee")
    assert np.allclose(energies, sim.energies, rtol=1e-13)
    assert abs(energies.sum() - sim.energy) < 1e-11
    boxes = sim.unwrapped_positions - sim.positions
    assert np.abs(boxes - np.round(boxes)).max() < 1e-12
    assert sim.tags[0] == ("tee",) and sim.tags[1:] == [("gas",)] * 100
    assert sim.mask("gas").sum() == 100
    assert list(sim.ids) == list(range(101))


def test_arrays_are_copies_of_one_time():
    sim = gas()
    before = sim.positions
    kept = before.copy()
    sim.run(until=1)
    assert (before == kept).all() and (sim.positions != kept).any()


def test_reversed_motion_returns():
    sim = gas()
    start = sim.positions
    sim.run(until=0.2)
    sim.reverse()
    sim.run(until=0.4)
    distance = sim.positions - start
    assert np.abs(distance - np.round(distance)).max() < 1e-6


def test_a_run_in_pieces_with_samples_and_bars_has_the_same_bits(capsys):
    whole, pieces = tee_in_gas(), tee_in_gas()
    whole.run(until=3)
    pieces.measure("pressure", every=0.0371)
    for end in (0.1, 0.1, 0.70001, 2.9):
        pieces.run(until=end, progress=True)
        pieces.positions
    pieces.run(until=3)
    assert (state(whole) == state(pieces)).all()
    assert "collisions" in capsys.readouterr().err


def test_steps_and_callbacks_and_arrays_report_the_same_collisions():
    by_array, by_step, by_callback = gas(), gas(), gas()
    rows = by_array.collisions(until=0.5)
    assert len(rows) == by_array.collision_count > 30
    steps = []
    while (hit := by_step.step(until=0.5)) is not None:
        steps.append(hit)
    assert [hit.time for hit in steps] == rows["time"].tolist()
    assert [hit.ids for hit in steps] == [tuple(pair) for pair in rows["ids"].tolist()]
    for name in carom.COLLISION.names:
        assert np.array_equal([getattr(hit, name) for hit in steps], rows[name]), name
    heard = []
    by_callback.on_collision()(heard.append)
    by_callback.run(until=0.5)
    assert [hit.time for hit in heard] == rows["time"].tolist()
    assert (state(by_array) == state(by_step)).all()
    assert (state(by_array) == state(by_callback)).all()


def test_reports_obey_mechanics():
    sim = tee_in_gas()
    rows = sim.collisions(until=1, between=["tee", "gas"])
    assert len(rows) > 10 and (rows["ids"][:, 0] == 0).all()
    masses = np.array([carom.Molecule.tee(0.02).mass, 1.0])
    change = rows["velocities_after"] - rows["velocities_before"]
    impulse = masses[None, :, None] * change
    assert np.allclose(impulse[:, 1], rows["impulse"], atol=1e-12)
    assert np.allclose(impulse.sum(axis=1), 0, atol=1e-12)
    # A smooth contact: the impulse is along the normal.
    normal, push = rows["normal"], rows["impulse"]
    assert np.allclose(normal[:, 0] * push[:, 1], normal[:, 1] * push[:, 0], atol=1e-12)
    assert (np.einsum("ij,ij->i", normal, push) > 0).all()
    assert (rows["elasticity"] == 1).all()
    assert len(gas().collisions(until=0.0)) == 0


def test_a_callback_may_edit_and_its_exception_ends_the_run_there():
    sim = tee_in_gas()
    calls = []

    @sim.on_collision(between=("tee", "gas"))
    def absorb(hit):
        assert sim.time == hit.time
        sim.remove([hit.ids[1]])
        calls.append(hit)
        if len(calls) == 5:
            raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        sim.run(until=100)
    assert len(calls) == 5 and len(sim) == 96 and sim.time == calls[-1].time
    sim.off_collision(absorb)
    sim.run(until=sim.time + 0.1)


def test_a_callback_cannot_run_the_simulation():
    sim = gas()
    sim.on_collision()(lambda hit: sim.run(until=9))
    with pytest.raises(carom.BusyError):
        sim.run(until=1)


def test_a_mask_selects_the_bodies_of_an_edit():
    sim = tee_in_gas()
    count, left = len(sim), sim.positions[:, 0] < 0.5
    sim.tag(left, "left")
    assert (sim.mask("left") == left).all() and 0 < left.sum() < count
    sim.set_energy(2.0, left)
    assert np.allclose(sim.energies[left], 2.0) and not np.allclose(sim.energies[~left], 2.0)
    sim.remove(left)
    assert len(sim) == count - left.sum() and not sim.mask("gas").all() | (sim.positions[:, 0] < 0.5).any()
    with pytest.raises(ValueError, match=f"one entry for each of the {len(sim)} bodies, but has {count}"):
        sim.remove(left)
    with pytest.raises(TypeError, match="or a mask"):
        sim.remove(np.zeros((2, 2), dtype=bool))
    with pytest.raises(TypeError, match="`energy` must be an array"):
        sim.set_energy("gas", 2.0)


def test_velocities_are_set_in_one_call():
    sim = tee_in_gas()
    gas = sim.mask("gas")
    sim.run(until=0.1)
    wanted = np.arange(2.0 * gas.sum()).reshape(-1, 2)
    sim.set_velocity(wanted, "gas")
    assert (sim.velocities[gas] == wanted).all()
    sim.set_velocity([0.5, -0.5])
    assert (sim.velocities == [0.5, -0.5]).all()
    sim.set_angular_velocity(2.0, ~gas)
    assert (sim.angular_velocities[~gas] == 2.0).all()
    energy = sim.energy
    with pytest.raises(carom.EditError, match="cannot turn"):
        sim.set_angular_velocity(1.0, "gas")
    with pytest.raises(carom.EditError, match="velocity"):
        sim.set_velocity([1e61, 0.0], "gas")
    with pytest.raises(ValueError, match="shape"):
        sim.set_velocity(wanted[1:], "gas")
    assert sim.energy == energy


def test_a_simulation_says_how_to_keep_it_in_place_of_a_pickle():
    with pytest.raises(TypeError, match="carom.load"):
        pickle.dumps(gas())


def test_a_molecule_is_given_to_an_entry_molecule_as_to_a_gas():
    ell = carom.Molecule([(0, 0, 0.02, 1), (0.04, 0, 0.02, 1), (0, 0.04, 0.02, 2)])
    entry = {"molecule": ell, "at": [0.5, 0.25], "tags": ["ell"]}
    one, two = (carom.Simulation(carom.Scene(molecule=given)) for given in (entry, ell.at(0.5, 0.25, tags="ell")))
    assert one.tags == two.tags and (state(one) == state(two)).all() and (one.masses == two.masses).all()


def test_edits_are_made_whole_or_not_at_all():
    sim = tee_in_gas()
    sim.run(until=0.3)
    before = state(sim)
    free = carom.Molecule.disc(0.001)
    with pytest.raises(carom.EditError, match="body 5 is not, or no longer"):
        sim.remove([5, 6, 5])
    with pytest.raises(carom.EditError, match="overlap"):
        sim.add(free, [sim.positions[4], sim.positions[4]])
    with pytest.raises(carom.EditError):
        sim.set_energy([1.0, -1.0], [4, 5])
    assert (state(sim) == before).all()
    new = sim.add(free, sim.positions[4:6] + [0.0, 0.0215], velocity=[[1, 0], [0, 1]], tags="new")
    assert new.tolist() == sim.ids[-2:].tolist() and sim.tags[-1] == ("new",)
    sim.remove("new")
    sim.remove(np.arange(1, 11))
    sim.set_energy(2.0, "gas")
    assert len(sim) == 91 and np.allclose(sim.energies[sim.mask("gas")], 2.0)
    sim.lock("tee")
    assert sim.locked[0] and sim.angular_velocities[0] == 0
    sim.unlock("tee")
    sim.tag("tee", "target")
    sim.untag("tee", "tee")
    assert sim.tags[0] == ("target",)
    sim.set_elasticity(0.8, pairs={("gas", "target"): 1.2, "target": 1.0})
    before = sim.energy
    sim.run(until=3)
    assert sim.energy < before and sim.overlapping_pairs == 0


def test_rough_discs_turn():
    sim = gas(count=50)
    assert (sim.angular_velocities == 0).all()
    pairs = {"gas": {"coefficient": {"speeds": [0, 5], "values": [1, 0.9]}, "tangential": 0.5, "friction": 0.4}}
    sim.set_elasticity(0.9, tangential=0.0, pairs=pairs)
    sim.run(until=2)
    assert (sim.angular_velocities != 0).any() and sim.overlapping_pairs == 0
    with pytest.raises(carom.EditError):
        sim.set_elasticity(1.0, tangential=1.5)
    rough = carom.Scene(
        gas={"radius": 0.02, "mass": 1, "temperature": 1, "velocities": "maxwell", "count": 50},
        elasticity={"tangential": 1.0},
    )
    assert (carom.Simulation(rough).angular_velocities != 0).all()


def test_walls_are_added():
    sim = gas(count=20)
    wall = sim.add_wall(ends=[[0.1, 0.0], [0.1, 0.02]], tags="flap")
    assert sim.fixed[-1] and sim.ids[-1] == wall
    sim.run(until=2)
    assert sim.overlapping_pairs == 0
    with pytest.raises(carom.EditError):
        sim.add_wall(x=0.1, y=0.2)


def test_removed_bodies_do_not_break_their_measures():
    sim = tee_in_gas()
    kinds = ["directions", "drift", "kicks", "projections", "running-average"]
    found = [sim.measure(kind, of="tee", every=0.05) for kind in kinds]
    found += [sim.measure(kind, every=0.05) for kind in ("correlation", "temperature", "velocities")]
    sim.run(until=0.5)
    sim.remove("tee")
    sim.run(until=1.0)
    assert all(entry.results is not None for entry in found)


def test_saved_and_loaded_simulations_continue_with_the_same_bits(tmp_path):
    sim = tee_in_gas()
    shells = sim.measure("pair-distribution", of="gas", every=0.05)
    sim.run(until=1)
    sim.save(tmp_path / "checkpoint")
    again = carom.load(tmp_path)
    assert again.time == 1 and (state(again) == state(sim)).all()
    for one in (sim, again):
        one.run(until=2)
    assert (state(again) == state(sim)).all()
    assert again.measures[0].results == shells.results
    assert again.measures[0].kind == shells.kind == "pair-distribution"
    copied = copy.deepcopy(sim)
    sim.run(until=3)
    copied.run(until=3)
    assert (state(copied) == state(sim)).all()


def test_damaged_files_are_refused(tmp_path):
    sim = gas()
    path = tmp_path / "checkpoint"
    sim.save(path)
    whole = path.read_bytes()
    for at in (3, 17, 25, 40, len(whole) - 1):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
        with pytest.raises(carom.CheckpointError):
            carom.load(path)
    path.write_bytes(b"")
    for bad in (path, tmp_path, tmp_path / "none"):
        with pytest.raises(carom.CheckpointError):
            carom.load(bad)
    with pytest.raises(carom.CheckpointError):
        sim.save(tmp_path / "no" / "folder")


def test_calls_from_another_thread_while_running_are_refused():
    sim = gas(count=500)
    ended = []
    thread = threading.Thread(target=lambda: ended.append(sim.run(until=20)))
    thread.start()
    refused = 0
    tries = [
        lambda: sim.positions,
        lambda: sim.run(until=1),
        lambda: sim.step(),
        lambda: sim.remove([0]),
        lambda: sim.measure("pressure"),
        lambda: sim.save("nowhere"),
        lambda: sim.copy(),
        lambda: sim.show(),
        lambda: len(sim),
    ]
    while thread.is_alive():
        for call in tries:
            try:
                call()
            except carom.BusyError:
                refused += 1
            except carom.CaromError:
                pass
            if not thread.is_alive():
                break
    thread.join()
    assert refused > 3


@pytest.fixture
def ctrl_c():
    """Python's handler, which a shell takes away from a program in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_stops_a_run_that_can_be_continued(ctrl_c):
    sim = gas(count=400)
    timer = threading.Timer(0.4, lambda: signal.raise_signal(signal.SIGINT))
    timer.start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        sim.run(until=1e9)
    assert time.monotonic() - begun < 10
    stopped = sim.time
    assert 0 < stopped < 1e9 and sim.overlapping_pairs == 0
    sim.run(until=stopped + 0.01)


@pytest.mark.parametrize("call", ["step", "collisions", "run"])
def test_ctrl_c_stops_a_single_fast_body(ctrl_c, call):
    sim = carom.Simulation(carom.Scene())
    sim.add(carom.Molecule.disc(0.1), [0.5, 0.5], velocity=[1e6, 1.0])
    if call == "run":
        sim.on_collision()(print)
    timer = threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT))
    timer.start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        getattr(sim, call)(until=1e6)
    assert time.monotonic() - begun < 10


def test_ctrl_c_stops_a_search_for_contacts(ctrl_c):
    tee, places = carom.Molecule.tee(0.5), np.full((3_000_000, 2), 40.0)
    timer = threading.Timer(1.0, lambda: signal.raise_signal(signal.SIGINT))
    timer.start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        carom.first_contact(tee, tee, places, [-1.0, -1.0], angular_velocities=[1.0, 2.0])
    assert time.monotonic() - begun < 10


def test_ctrl_c_stops_replicas(ctrl_c):
    timer = threading.Timer(0.4, lambda: signal.raise_signal(signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        carom.replicas(carom.Scene(gas=GAS, run={"until": 1e6}), 3)


def test_first_contacts_are_those_of_planted_answers():
    disc, tee = carom.Molecule.disc(0.5), carom.Molecule.tee(0.5)
    found = carom.first_contact(disc, disc, [3, 0], [[-1, 0], [-2, 0], [1, 0]])
    assert found.time.tolist() == [2.0, 1.0, np.inf]
    assert found.atoms.tolist() == [[0, 0], [0, 0], [-1, -1]] and found.is_decided.all()
    assert np.isinf(carom.first_contact(disc, disc, [3, 0], [-1, 0], until=1.9).time)
    # A disc at rest is met by the tip of a turning rod of four atoms after a quarter turn.
    rod = carom.Molecule.rod(4, radius=0.5)
    tip = carom.first_contact(rod, disc, [0, 2.5], [0, 0], angular_velocities=[1, 0], until=10)
    assert abs(tip.time - np.pi / 2) < 1e-6 and tip.atoms.tolist() == [3, 0]
    many = carom.first_contact(tee, disc, np.ones((5, 1, 2)) * 4, np.ones((1, 7, 2)) * -1.0)
    assert many.time.shape == (5, 7) and many.atoms.shape == (5, 7, 2)


def test_scenes_molecules_and_results_pickle():
    scene = carom.Scene(gas={**GAS, "count": 20}, run={"until": 1, "sample_interval": 0.1})
    results = carom.run(scene, measures=["velocities:gas"])
    for value in (scene, results, results["velocities-gas"].results, carom.Molecule.tee(0.1),
                  carom.Molecule([(0, 0, 1, 1), (1, 0, 1, 2)])):
        assert pickle.loads(pickle.dumps(value)) == value
    table = pickle.loads(pickle.dumps(results["velocities-gas"]))
    for column in table:
        assert np.array_equal(table[column], results["velocities-gas"][column], equal_nan=True)


@pytest.mark.parametrize("vector", [(0.25, 0.5, 0.75), [0.25, 0.5, 0.75], np.array([0.25, 0.5, 0.75]), [0.25]],
                         ids=["tuple", "list", "array", "one"])
def test_other_than_two_numbers_are_no_vector(vector):
    tee, words = carom.Molecule.tee(0.01), r"two numbers \[x, y\]"
    disc = {"shape": "disc", "atom_radius": 0.1, "atom_mass": 1}
    for scene in [
        {"box": {"sides": vector}},
        {"molecule": [{**disc, "at": vector}]},
        {"molecule": [{**disc, "at": (0.5, 0.5), "velocity": vector}]},
        {"bumper": [{"radius": 0.1, "at": vector}]},
        {"wall": [{"from": vector, "to": (1, 1)}]},
    ]:
        with pytest.raises(carom.SceneError, match=words + rf", but there are {len(vector)}: \[0.25"):
            carom.Scene(scene)
    with pytest.raises(carom.SceneError, match=words):
        carom.Scene(box=vector)
    sim = carom.Simulation(carom.Scene())
    for refused in [
        lambda: sim.add(tee, vector),
        lambda: sim.add(tee, [vector, vector]),
        lambda: sim.add(tee, [0.5, 0.5], velocity=vector),
        lambda: sim.add_wall(ends=[vector, vector]),
        lambda: tee.at(0.5, 0.5, velocity=vector),
    ]:
        with pytest.raises(ValueError, match=words):
            refused()
    assert len(sim) == 0
    with pytest.raises(carom.MoleculeError, match="an atom is"):
        carom.Molecule([{"at": vector, "radius": 0.1, "mass": 1}])


STATE = ("positions", "unwrapped_positions", "velocities", "angles", "angular_velocities", "radii", "masses",
         "energies", "fixed", "locked", "ids", "momentum")


@pytest.mark.parametrize("name", STATE)
def test_arrays_of_the_state_cannot_be_written_to(name):
    sim = gas()
    values = getattr(sim, name)
    with pytest.raises(ValueError, match="read-only"):
        values[0] = 0
    copied = np.array(values)
    copied[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        carom.Molecule.tee(0.01).atoms[0] = 0


@pytest.mark.parametrize("call", ["run", "step", "collisions"])
def test_a_run_neither_goes_back_nor_to_infinity(call):
    sim = gas()
    sim.run(until=0.5)
    for until in (-1, 0.0, 0.499):
        with pytest.raises(carom.RunError, match=f"a run cannot end at {float(until)}, before its present time 0.5"):
            getattr(sim, call)(until)
    for until in (1e308, np.inf, -np.inf, np.nan):
        with pytest.raises(carom.RunError, match="a run must end at a finite time of at most 1e300, not at"):
            getattr(sim, call)(until)
    for until in (0.0, -1.0, np.nan, np.inf, 1e308):
        with pytest.raises(carom.CaromError, match="run.until must be"):
            carom.run(carom.Scene(gas=GAS), until=until)
    assert sim.time == 0.5
    sim.run(sim.time)
    assert sim.time == 0.5


def test_a_scene_that_does_not_fit_into_the_memory_is_refused():
    # 200 gases of 2^27 discs need 5 terabytes.
    scene = carom.Scene(gas=[{"radius": 1e-12, "mass": 1, "energy": 1, "count": 2**27}] * 200)
    for refused in (carom.Simulation, carom.run):
        with pytest.raises(carom.CaromError, match=r"bodies need at least \d+ bytes of memory .* available: take fewer"):
            refused(scene)


def test_the_size_of_a_picture_is_bounded():
    for size in (0, 16385, 2**32 - 1):
        with pytest.raises(ValueError, match="from 1 to 16384 pixels"):
            gas()._core.picture(size)


def test_exports_agree_with_the_arrays_for_any_molecule():
    hoomd, ase, freud = (pytest.importorskip(name) for name in ("gsd.hoomd", "ase", "freud"))
    ring = {"shape": "ring:7", "atom_radius": 0.02, "atom_mass": 1, "at": [1.29, 0.01], "velocity": [3, -2]}
    rods = {"shape": "rod:3", "atom_radius": 0.008, "atom_mass": 1, "temperature": 1, "count": 50}
    scene = carom.Scene(box=[1.3, 0.7], molecule=ring, gas={**rods, "tags": ["rods"]}, wall={"x": 0.9})
    sim = carom.Simulation(scene)
    sim.run(until=2)
    frame = sim.to_gsd()
    frame.validate()
    assert isinstance(frame, hoomd.Frame)
    particles, sides = frame.particles, np.array(sim.box)
    assert particles.N == 7 + 150 and {"molecule", "rods"} <= set(particles.types)
    # Atoms of equal masses: their mean is the centre of mass.
    places = particles.position[:, :2] + sides / 2 + particles.image[:, :2] * sides
    atoms = np.array(particles.body)
    assert (atoms >= 0).all() and np.abs(particles.image).max() > 0
    for body in np.unique(atoms):
        centre = places[atoms == body].mean(axis=0)
        assert np.abs(centre - sim.unwrapped_positions[sim.ids == body]).max() < 1e-6
    copy = sim.to_ase()
    assert isinstance(copy, ase.Atoms) and len(copy) == particles.N
    assert np.allclose(copy.get_velocities()[:, :2], particles.velocity[:, :2], rtol=1e-6)
    box, points = sim.to_freud()
    assert isinstance(box, freud.box.Box) and points.shape == (51, 3)


SIDED = [
    carom.Molecule.capsule(2, size=0.02),
    carom.Molecule.square(0.04),
    carom.Molecule.rectangle(2.5, size=0.02),
    carom.Molecule.triangle(0.05, mass=2.0),
    carom.Molecule.regular_polygon(8, size=0.02, rounding=0.1),
    carom.Molecule.kite(1.0, 0.4, size=0.03),
    carom.Molecule.polygon([[0, 0], [0.04, 0], [0.04, 0.02], [0.02, 0.02], [0.02, 0.05], [0, 0.05]]),
    carom.Molecule([(0, 0, 0.01, 1), (0.04, 0, 0.01, 1), (0.04, 0.03, 0.01, 2)], edges=[[0, 1], (1, 2)], edge_radius=0.002),
    carom.Molecule([(0, 0, 0.002, 1), (0.1, 0, 0.002, 1), (0, 0.1, 0.002, 1)], edges=[(0, 1), (1, 2), (2, 0)],
                   hollow=True),
]


def test_molecules_with_sides_have_their_area_and_inertia():
    # Rounded by r: A + P r + pi r^2 for a convex polygon.
    octagon, side = SIDED[4], 0.02
    sharp, r = 2 * (1 + np.sqrt(2)) * side**2, 0.1 * side
    assert np.isclose(octagon.area, sharp + 8 * side * r + np.pi * r**2, rtol=1e-12)
    assert np.isclose(SIDED[1].moment_of_inertia, 0.04**2 / 6, rtol=1e-5)
    assert np.isclose(SIDED[2].area, 2.5 * 0.02**2, rtol=1e-5)
    assert np.isclose(SIDED[5].area, 0.5 * 1.4 * 0.03**2, rtol=1e-5)
    assert [len(molecule) for molecule in SIDED] == [2, 4, 4, 3, 8, 4, 6, 3, 3]
    assert [len(molecule.edges) for molecule in SIDED] == [1, 4, 4, 3, 8, 4, 6, 2, 3]
    # The ring without its interior, and with it.
    ring = SIDED[8]
    solid = carom.Molecule(ring.atoms.tolist(), edges=ring.edges.tolist())
    assert ring != solid and ring.area < 0.3 * solid.area
    shares = octagon.edge_shares(0.01)
    assert np.allclose(shares, shares[0]) and np.isclose(shares.sum() + octagon.atom_shares(0.01).sum(), 1)


def test_molecules_with_sides_move_in_simulations():
    sim = carom.Simulation(carom.Scene(box=[1, 1]))
    for index, molecule in enumerate(SIDED):
        again = pickle.loads(pickle.dumps(molecule))
        assert again == molecule and hash(again) == hash(molecule) and repr(again) == repr(molecule)
        at = [[0.1 * (index + 0.5), 0.25], [0.1 * (index + 0.5), 0.75]]
        sim.add(molecule, at, velocity=[[1, 0.5], [-0.3, 1]], angular_velocity=[3, -2], tags="sided")
    assert np.allclose(sim.masses, np.repeat([molecule.mass for molecule in SIDED], 2))
    before = sim.energies.sum()
    sim.run(until=2.0)
    assert sim.overlapping_pairs == 0 and np.isclose(sim.energies.sum(), before, rtol=1e-12)
    # The entry of a scene gives the same molecule.
    scene = carom.Scene(molecule=[SIDED[7].at(0.3, 0.5), SIDED[3].at(0.7, 0.5, angle=1.0)])
    assert np.allclose(carom.Simulation(scene).masses, [4.0, 2.0])


def test_a_corner_meets_a_face_at_a_planted_time():
    square, corner = carom.Molecule.square(1.0), np.sqrt(0.5)
    # B comes with its corner ahead: 3 - 1/2 - sqrt(1/2), and the roundings of 1e-6 on both.
    found = carom.first_contact(square, square, [3, 0], [-1, 0], angles=[0, np.pi / 4])
    assert abs(found.time - (2.5 - corner - 2e-6)) < 1e-12
    assert found.atoms[0] == -1 and found.atoms[1] in range(4)


@pytest.mark.parametrize("make, words", [
    (lambda: carom.Molecule.square(1.0, rounding=0), "`rounding` must be positive"),
    (lambda: carom.Molecule.square(1.0, rounding=1e-12), "at least 1e-10 of its size"),
    (lambda: carom.Molecule.square(-1.0), "the size of a shape must be positive"),
    (lambda: carom.Molecule.capsule(0, size=1.0), "capsule:L"),
    (lambda: carom.Molecule.regular_polygon(2, size=1.0), "3 to 1024 corners"),
    (lambda: carom.Molecule.kite(1, np.nan, size=1.0), "kite:A,B"),
    (lambda: carom.Molecule.polygon([[0, 0], [1, 1], [1, 0], [0, 1]]), "sides 0 and 2 that meet"),
    (lambda: carom.Molecule.polygon([0, 1]), "3 to 1024 corners"),
    (lambda: carom.Molecule([(0, 0, 1, 1)], edges=[(0, 1)]), "edge 0, between atoms 0 and 1"),
    (lambda: carom.Molecule([(0, 0, 1, 1), (3, 0, 1, 1)], edges=[(0,)]), "an edge is a pair"),
    (lambda: carom.Molecule([(0, 0, 1, 1), (3, 0, 1, 1)], edges=[(0, 1)], edge_radius=2), "edge 0"),
    (lambda: carom.Molecule([(0, 0, 1, 1)], hollow=True), "`hollow` go with `edges`"),
])
def test_other_molecules_with_sides_are_refused(make, words):
    with pytest.raises(carom.MoleculeError, match=words):
        make()


def test_a_sheared_box_keeps_its_tilt_in_other_programs():
    pytest.importorskip("gsd.hoomd")
    sim = carom.Simulation({"box": {"shear_rate": 0.35, "seed": 3}, "gas": [GAS]})
    sim.run(until=1)
    assert abs(sim.tilt - 0.35) < 1e-12
    booked = sim.booked_energy
    assert abs(booked["initial"] - booked["lost"] + booked["sheared"] - sim.energy) < 1e-11
    frame = sim.to_gsd()
    x, y, _, xy, _, _ = frame.configuration.box
    assert (x, y) == (1, 1) and abs(xy - sim.tilt) < 1e-6
    position, image = frame.particles.position[:, :2], frame.particles.image[:, :2]
    # In the parallelogram about the origin, and with the image where the body has come to.
    assert np.abs(position[:, 1]).max() < 0.5 + 1e-6
    assert np.abs(position[:, 0] - xy * position[:, 1]).max() < 0.5 + 1e-6
    come_to = position + image @ np.array([[1, 0], [xy, 1]])
    away = come_to - sim.unwrapped_positions
    assert np.abs(away - away[0]).max() < 1e-5
    try:
        box, points = sim.to_freud()
    except ImportError:
        return
    assert abs(box.xy - sim.tilt) < 1e-6
    apart = box.wrap(points[1:] - points[:-1])[:, :2]
    expected = box.wrap(np.column_stack([np.diff(sim.positions, axis=0), np.zeros(99)]))[:, :2]
    assert np.abs(apart - expected).max() < 1e-5


def test_bonds_are_made_cut_and_kept():
    disc = carom.Molecule.disc(0.02)
    sim = carom.Simulation({"molecule": [disc.at(0.3 + 0.1 * k, 0.5) for k in range(3)]})
    sim.bond([[0, 1], [2, 1]], max=0.15, min=0.05)
    pairs, lengths = sim.bonds
    assert pairs.tolist() == [[0, 1], [1, 2]] and np.allclose(lengths, 0.1)
    sim.set_velocity([[0.7, 0.1], [-0.2, 0.4], [0.3, -0.5]])
    energy, momentum = sim.energy, sim.velocities.sum(axis=0)
    for time in range(1, 20):
        sim.run(until=time)
        _, lengths = sim.bonds
        assert (lengths < 0.15 + 1e-13).all() and (lengths > 0.05 - 1e-13).all()
    assert abs(sim.energy / energy - 1) < 1e-13
    assert np.abs(sim.velocities.sum(axis=0) - momentum).max() < 1e-13
    # A bond that is too short for the two, and bodies that are not there.
    for pair, longest in (([0, 2], 1e-3), ([0, 9], 0.4), ([1, 1], 0.4)):
        with pytest.raises(carom.EditError):
            sim.bond([pair], max=longest)
    assert len(sim.bonds[1]) == 2
    sim.unbond([0])
    assert sim.bonds[0].tolist() == [[1, 2]]
    try:
        frame, copy = sim.to_gsd(), sim.to_ase()
    except ImportError:
        pass
    else:
        assert frame.bonds.group.tolist() == [[1, 2]] == copy.info["bonds"].tolist()
    # Chains of a scene.
    chains = {"radius": 0.01, "mass": 1, "energy": 1, "count": 12, "chain": {"members": 4, "tether": {"max": 0.04}}}
    sim = carom.Simulation({"gas": [chains]})
    assert sim.bonds[0].shape == (9, 2)


def test_thermostats_act_once_by_their_rules(tmp_path):
    sim = gas(count=2000, radius=0.004)
    sim.thermostat("gas", "maxwell", temperature=2.0)
    assert abs(sim.energy / 2000 / 2.0 - 1) < 0.1
    before = np.linalg.norm(sim.velocities, axis=1)
    directions = sim.velocities
    sim.thermostat("gas", "rotate")
    assert np.allclose(np.linalg.norm(sim.velocities, axis=1), before, rtol=1e-14)
    assert np.abs((sim.velocities * directions).sum(axis=1).mean()) < 0.1 * (before**2).mean()
    momentum = sim.momentum
    sim.thermostat("gas", "kick", momentum=[0.5, -0.25])
    assert np.allclose(sim.momentum - momentum, [1000.0, -500.0])
    sim.thermostat("gas", "rescale", temperature=0.5)
    assert abs(sim.temperature - 0.5) < 1e-12
    sim.thermostat("gas", energy=3.0)
    assert np.allclose(sim.energies, 3.0)
    sim.thermostat("gas", "active", every=0.1, speed=2.0, rotational_diffusion=0.0)
    first = sim.velocities
    assert np.allclose(np.linalg.norm(first, axis=1), 2.0)
    # Without diffusion the axes of the discs stay, and contacts do not change them.
    sim.run(until=0.1)
    sim.thermostat("gas", "active", every=0.1, speed=2.0, rotational_diffusion=0.0)
    assert np.allclose(sim.velocities, first)
    booked = sim.booked_energy
    assert abs(booked["initial"] + booked["put_in"] - sim.energy) < 1e-9 * sim.energy
    # A copy and a loaded simulation draw the same numbers, and the next action others.
    sim.save(tmp_path / "checkpoint")
    twins = [sim, sim.copy(), carom.load(tmp_path)]
    for twin in twins:
        twin.thermostat("gas", "langevin", every=0.1, friction=5.0, temperature=1.0)
    assert all((twin.velocities == sim.velocities).all() for twin in twins)
    drawn = []
    for _ in range(2):
        sim.thermostat("gas", "maxwell", temperature=1.0)
        drawn.append(sim.velocities)
    assert (drawn[0] != drawn[1]).any(axis=1).all()


def test_thermostats_are_refused_by_name():
    sim = gas()
    before = state(sim)
    for error, words, call in (
        (TypeError, "every", lambda: sim.thermostat("gas", "active", speed=1.0, rotational_diffusion=1.0)),
        (ValueError, "every", lambda: sim.thermostat("gas", "rotate", every=0.0)),
        (carom.EditError, "no body carries", lambda: sim.thermostat("nobody", "rotate")),
        (carom.EditError, "friction", lambda: sim.thermostat("gas", "langevin", every=0.1, temperature=1.0)),
        (carom.EditError, "speed", lambda: sim.thermostat("gas", "rotate", speed=1.0)),
        (carom.EditError, "either", lambda: sim.thermostat("gas", "maxwell")),
        (ValueError, "momentum", lambda: sim.thermostat("gas", "kick", momentum=[1.0, 2.0, 3.0])),
        (carom.SceneError, "nose-hoover", lambda: sim.thermostat("gas", "nose-hoover")),
    ):
        with pytest.raises(error, match=words):
            call()
    assert (state(sim) == before).all()


def test_pairs_become_transparent_and_visible_again():
    sim = gas()
    sim.set_transparent(["gas"])
    sim.run(until=1)
    assert sim.collision_count == 0 and sim.overlapping_pairs == 0
    # Some overlap by then.
    with pytest.raises(carom.EditError, match="overlap"):
        sim.set_transparent([])
    sim.reverse()
    sim.run(until=2)
    sim.set_transparent([])
    sim.run(until=3)
    assert sim.collision_count > 0
    with pytest.raises(TypeError, match="list"):
        sim.set_transparent("gas")


def test_wells_hold_energy_and_can_be_replaced():
    gas = {"tags": ["a"], "radius": 0.03, "mass": 1, "temperature": 1, "count": 60}
    scene = {"gas": [gas], "well": [{"between": ["a"], "steps": [[1.5, -1.0], [2.0, 0.25]]}]}
    sim = carom.Simulation(scene)
    total = sim.energy + sim.energy_of_wells
    kinds = set()
    for _ in range(200):
        kinds.add(sim.step().kind)
    assert kinds == {0, 2}
    assert abs(sim.energy + sim.energy_of_wells - total) < 1e-11
    booked = sim.booked_energy
    assert abs(booked["initial"] + booked["wells"] - sim.energy) < 1e-11
    pairs, steps, energies = sim.pairs_in_wells
    assert pairs.shape == (len(steps), 2) and set(steps.tolist()) <= {0, 1}
    assert np.allclose(energies, np.array([-1.0, 0.25])[steps])
    positions = sim.positions
    apart = positions[pairs[:, 0]] - positions[pairs[:, 1]]
    distances = np.linalg.norm(apart - np.round(apart), axis=1) / 0.06
    assert (distances[steps == 0] < 1.5 + 1e-9).all() and (distances[steps == 1] < 2.0 + 1e-9).all()
    kinetic = sim.energy
    sim.set_wells([])
    assert sim.energy == kinetic and sim.energy_of_wells == 0.0
    with pytest.raises(carom.EditError):
        sim.set_wells([{"between": ["a"], "steps": [[0.5, 1.0]]}])
