"""Scenes from files of HOOMD and LAMMPS, which the tests write."""

import math
import os
import shlex
import shutil
import subprocess

import carom
import numpy as np
import pytest

DATA = """LAMMPS data file by hand

3 atoms
2 atom types
0 bonds

-1.0 3.0 xlo xhi
2.0 4.0 ylo yhi
-0.5 0.5 zlo zhi
0.0 0.0 0.0 xy xz yz

Masses

1 1.5
2 2.5 # heavy

Pair Coeffs # lj/cut

1 1.0 1.0
2 1.0 1.0

Atoms # atomic

3 2 2.5 3.5 0.0 0 0 0
1 1 -0.5 2.5 0.0 1 0 0
2 1 0.5 2.5 0.0 0 0 0

Velocities

1 0.25 -0.5 0.0
3 1.0 0.0 0.0
"""

DUMP = """ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
1
ITEM: BOX BOUNDS pp pp pp
0 2
0 1
-0.5 0.5
ITEM: ATOMS id type xs ys radius mass
7 1 0.25 0.5 0.1 3
ITEM: TIMESTEP
10
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS pp pp pp
-1 1
0 1
-0.5 0.5
ITEM: ATOMS id type x y z vx vy vz radius mass
9 2 0.5 0.5 0 1 2 0 0.2 4
7 1 -0.5 0.25 0 0 0 0 0.1 3
"""


def entries(scene):
    return scene.tables["molecule"]


def test_a_data_file_gives_places_velocities_and_masses(tmp_path):
    path = tmp_path / "a.data"
    path.write_text(DATA)
    scene = carom.from_lammps(path, radius={1: 0.1, "2": 0.2})
    assert scene.tables["box"]["sides"] == [4.0, 2.0]
    assert [one["at"] for one in entries(scene)] == [[0.5, 0.5], [1.5, 0.5], [3.5, 1.5]]
    assert [one["velocity"] for one in entries(scene)] == [[0.25, -0.5], [0.0, 0.0], [1.0, 0.0]]
    assert [one["atom_mass"] for one in entries(scene)] == [1.5, 1.5, 2.5]
    assert [one["atom_radius"] for one in entries(scene)] == [0.1, 0.1, 0.2]
    assert [one["tags"] for one in entries(scene)] == [["1"], ["1"], ["2"]]
    assert {one["atom_mass"] for one in entries(carom.from_lammps(path, radius=0.1, mass=7))} == {7.0}
    sim = carom.Simulation(scene.replaced(seed=1))
    sim.run(until=5.0)
    assert sim.overlapping_pairs == 0 and carom.Scene.from_toml(scene.to_toml()) == scene


def test_spheres_have_the_mass_of_their_density_and_labels_are_tags(tmp_path):
    path = tmp_path / "a.data"
    text = (
        "spheres\n\n2 atoms\n1 atom types\n0 2 xlo xhi\n0 2 ylo yhi\n\nAtom Type Labels\n\n1 grain\n\n"
        "Atoms # sphere\n\n1 1 0.5 3.0 0.5 0.5 0\n2 1 0.5 3.0 1.5 0.5 0\n"
    )
    path.write_text(text)
    for one in entries(carom.from_lammps(path)):
        assert one["atom_radius"] == 0.25 and one["tags"] == ["grain"]
        assert math.isclose(one["atom_mass"], 3.0 * 4 / 3 * math.pi * 0.25**3)
    path.write_text(text.replace("# sphere", ""))
    assert len(entries(carom.from_lammps(path, style="sphere"))) == 2
    with pytest.raises(carom.SceneError, match="line 12: the atom style is ''; give `style`, one of atomic"):
        carom.from_lammps(path)
    with pytest.raises(carom.SceneError, match="`style` must be one of atomic, .* but is 'edpd'"):
        carom.from_lammps(path, style="edpd")


def test_frames_of_a_dump(tmp_path):
    path = tmp_path / "a.lammpstrj"
    path.write_text(DUMP)
    first, last = carom.from_lammps(path, 0), carom.from_lammps(path)
    assert first.tables["box"]["sides"] == [2.0, 1.0] and entries(first)[0]["at"] == [0.5, 0.5]
    assert [one["at"] for one in entries(last)] == [[0.5, 0.25], [1.5, 0.5]]
    assert [one["velocity"] for one in entries(last)] == [[0.0, 0.0], [1.0, 2.0]]
    assert carom.from_lammps(path, 1) == last and carom.from_lammps(path, -2) == first
    for frame in (2, -3):
        with pytest.raises(carom.SceneError, match=f"frame {frame} is out of range: the file has 2 frames"):
            carom.from_lammps(path, frame)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("3 atoms", "4 atoms", "has 4 for 3"),
        ("0 bonds", "2 bonds", "line 5: 2 bonds are not read"),
        ("0.0 0.0 0.0 xy", "0.5 0.0 0.0 xy", r"line 10: the box is sheared \(0.5 0.0 0.0 xy xz yz\)"),
        ("2 1 0.5 2.5 0.0", "2 1 0.5 2.5 0.25", "line 26: z is 0.25, but must be 0"),
        ("2 1 0.5 2.5 0.0", "2 1 0.5 what 0.0", "line 26: a number is expected: .*'what'"),
        ("2 1 0.5 2.5 0.0", "1 1 0.5 2.5 0.0", "line 26: atom 1 occurs twice, first on line 25"),
        ("2 1 0.5 2.5 0.0", "x 1 0.5 2.5 0.0", "line 26: the number of an atom must be .* but is 'x'"),
        ("2 1 0.5 2.5 0.0 0 0 0", "2 1 0.5 2.5", "line 26: an atom of style atomic has 5 columns"),
        ("2 1 0.5 2.5 0.0", "2 1 0.5 nan 0.0", "line 26: place, velocity or orientation is not finite"),
        ("2 1 0.5 2.5 0.0", "2 5 0.5 2.5 0.0", "line 26: the file has no mass of type '5': give `mass`"),
        ("1 1.5", "1 -1.5", "line 25: the mass must be positive, but is -1.5"),
        ("3 1.0 0.0 0.0", "4 1.0 0.0 0.0", "line 31: a velocity of atom 4, which is not"),
        ("-1.0 3.0 xlo", "3.0 -1.0 xlo", "the side x of the box must be positive, but is -4"),
        ("ylo yhi", "", "neither a data file nor a dump of LAMMPS: no line `ylo yhi`"),
        ("# atomic", "# molecular", "line 24: .*has 6 columns"),
    ],
)
def test_a_data_file_that_carom_cannot_read_is_refused_with_the_line(tmp_path, old, new, words):
    path = tmp_path / "a.data"
    assert old in DATA
    path.write_text(DATA.replace(old, new, 1))
    with pytest.raises(carom.SceneError, match=words):
        carom.from_lammps(path, radius=0.1)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("pp pp pp\n-1", "pp ff pp\n-1", "line 15: the border y is 'ff', but must be 'pp'"),
        ("pp pp pp\n-1", "xy xz yz pp pp pp\n-1", "line 15: the box is sheared"),
        ("ITEM: NUMBER OF ATOMS\n2", "ITEM: NUMBER OF ATOMS\n3", "must have 3 atoms, but has 2"),
        ("id type x y z vx", "id type fx fy z vx", "no columns x y, xu yu, xs ys or xsu ysu, but id type fx fy"),
        ("id type x y z vx vy", "id type x y mol vx vy", "line 21: atom 7, and atom 9 of line 20, are of molecule 5"),
        ("0.2 4", "0.2", "line 20: 10 columns are expected, but 9 are there"),
        ("0.2 4", "0 4", "line 20: the file has no radius of type '2': give `radius`"),
    ],
)
def test_a_dump_that_carom_cannot_read_is_refused_with_the_line(tmp_path, old, new, words):
    path = tmp_path / "a.dump"
    assert old in DUMP
    text = DUMP.replace(old, new, 1)
    if "mol" in new:
        text = text.replace("0.5 0.5 0 1", "0.5 0.5 5 1").replace("0.25 0 0", "0.25 5 0")
    path.write_text(text)
    with pytest.raises(carom.SceneError, match=words):
        carom.from_lammps(path)


def test_arguments_and_files_that_are_wrong(tmp_path):
    path = tmp_path / "a.data"
    path.write_text(DATA)
    with pytest.raises(carom.SceneError, match="line 25: the file has no radius of type '1': give `radius`"):
        carom.from_lammps(path)
    with pytest.raises(carom.SceneError, match="`radius`: .* no particle of type 'A'; its types are 1, 2"):
        carom.from_lammps(path, radius={"A": 1})
    with pytest.raises(carom.SceneError, match="the radius must be positive, but is -1"):
        carom.from_lammps(path, radius=-1)
    with pytest.raises(TypeError, match="`radius` must be a number"):
        carom.from_lammps(path, radius="wide")
    with pytest.raises(carom.SceneError, match="cannot be read as text"):
        carom.from_lammps(tmp_path / "none")
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(carom.SceneError, match="cannot be read as text"):
        carom.from_lammps(path)
    path.write_text("")
    with pytest.raises(carom.SceneError, match="neither a data file nor a dump"):
        carom.from_lammps(path)


@pytest.mark.parametrize("text", [DATA, DUMP], ids=["data", "dump"])
def test_damaged_files_are_read_or_refused(tmp_path, text):
    path = tmp_path / "a.data"
    for at in range(0, len(text), 3):
        for changed in [text[:at], *(text[:at] + letter + text[at + 1 :] for letter in "\n9-x ")]:
            path.write_text(changed)
            try:
                carom.from_lammps(path, radius=0.1)
            except carom.SceneError as error:
                assert str(path) in str(error) or "molecule[" in str(error)


def test_cut_gsd_files_are_refused(tmp_path):
    path = written(tmp_path / "a.gsd", frame_of(**TWO))
    whole = path.read_bytes()
    for length in (0, 1, 200, len(whole) // 2):
        path.write_bytes(whole[:length])
        with pytest.raises(carom.SceneError, match="cannot be read as a GSD file of HOOMD"):
            carom.from_gsd(path)


def frame_of(**particles):
    hoomd = pytest.importorskip("gsd.hoomd")
    frame = hoomd.Frame()
    frame.configuration.box = [4, 2, 0, 0, 0, 0]
    frame.configuration.dimensions = 2
    frame.particles.N = len(particles["position"])
    for key, value in particles.items():
        setattr(frame.particles, key, value)
    return frame


def written(path, *frames):
    hoomd = pytest.importorskip("gsd.hoomd")
    with hoomd.open(path, "w") as file:
        for frame in frames:
            file.append(frame)
    return path


TWO = {"position": [[-1, 0, 0], [1, 0.5, 0]], "types": ["A", "B"], "typeid": [0, 1]}


def test_particles_of_a_gsd_file(tmp_path):
    first = frame_of(**TWO, velocity=[[1, 0, 0], [0, 2, 0]], mass=[2, 3], diameter=[0.5, 0.25])
    turned = [[1, 0, 0, 0], [math.cos(0.5), 0, 0, math.sin(0.5)]]
    second = frame_of(**TWO, orientation=turned, type_shapes=[{"type": "Sphere", "diameter": 0.75}, {}])
    path = written(tmp_path / "a.gsd", first, second)
    scene = carom.from_gsd(path, 0)
    assert scene.tables["box"]["sides"] == [4.0, 2.0]
    assert [one["at"] for one in entries(scene)] == [[1.0, 1.0], [3.0, 1.5]]
    assert [one["velocity"] for one in entries(scene)] == [[1.0, 0.0], [0.0, 2.0]]
    assert [(one["atom_radius"], one["atom_mass"], one["tags"]) for one in entries(scene)] == [
        (0.25, 2.0, ["A"]), (0.125, 3.0, ["B"])
    ]
    last = entries(carom.from_gsd(path, radius={"B": 0.1}))
    assert [one["atom_radius"] for one in last] == [0.375, 0.1]
    assert math.isclose(last[1]["orientation"], 1.0, rel_tol=1e-6)
    with pytest.raises(carom.SceneError, match="frame 2 is out of range: the file has 2 frames, numbered from 0"):
        carom.from_gsd(path, 2)


def test_shapes_of_a_gsd_file(tmp_path):
    # The origin of the corners is not the centre of mass, which lies at (1/3, 1/3).
    triangle = {"type": "Polygon", "vertices": [[0, 0], [1, 0], [0, 1]]}
    tall = {"type": "Ellipsoid", "a": 0.1, "b": 0.3}
    quarter = math.sqrt(0.5)
    turned = [[quarter, 0, 0, quarter], [1, 0, 0, 0]]
    path = written(tmp_path / "a.gsd", frame_of(**TWO, orientation=turned, type_shapes=[triangle, tall], mass=[3, 2]))
    scene = carom.from_gsd(path)
    sim = carom.Simulation(scene)
    assert np.allclose(sim.positions, [[1 - 1 / 3, 1 + 1 / 3], [3, 1.5]], atol=1e-5)
    assert np.allclose(sim.angles[1] % math.pi, math.pi / 2) and np.allclose(sim.masses, [3, 2])
    one, other = entries(scene)
    assert one["polygon"] == triangle["vertices"]
    assert other["shape"] == "ellipse:3" or other["shape"].startswith("ellipse:2.99") and other["size"] == 0.6
    rounded = {**triangle, "rounding_radius": 0.1}
    scene = carom.from_gsd(written(tmp_path / "b.gsd", frame_of(**TWO, type_shapes=[rounded, tall])))
    assert math.isclose(entries(scene)[0]["rounding"], 0.1 / math.sqrt(2))
    carom.Simulation(scene).run(until=1.0)
    with pytest.raises(carom.SceneError, match="`radius` is given for type 'A', whose shape has none"):
        carom.from_gsd(path, radius=0.1)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"position": [[-1, 0, 0], [1, 0.5, 0.25]]}, "particle 1: z is 0.25, but must be 0"),
        ({"body": [-1, 0]}, "particle 1: it belongs to the rigid body 0, which is not read"),
        ({"typeid": [0, 2]}, "particle 1: its type is 2, but there are 2 types"),
        ({"orientation": [[1, 0, 0, 0], [0, 1, 0, 0]]}, "particle 1: its orientation .* is no rotation in the plane"),
        ({"diameter": [1, -1]}, "particle 1: the radius must be positive, but is -0.5"),
        ({"mass": [0, 1]}, "particle 0: the mass must be positive, but is 0"),
        ({"type_shapes": [{"type": "Mesh"}, {}]}, "the shape 'Mesh' of type 'A' is not read; Sphere, Polygon and"),
        ({"type_shapes": [{"type": "Polygon", "vertices": [[0, 0]]}, {}]}, "the shape .* of type 'A'"),
        ({"type_shapes": [{"type": "Ellipsoid", "a": 1}, {}]}, "the shape .* of type 'A': 'b'"),
        ({"velocity": [[math.inf, 0, 0], [0, 0, 0]]}, "particle 0: place, velocity or orientation is not finite"),
    ],
)
def test_particles_that_carom_cannot_read_are_refused_by_their_number(tmp_path, change, words):
    path = written(tmp_path / "a.gsd", frame_of(**{**TWO, **change}))
    with pytest.raises(carom.SceneError, match=words):
        carom.from_gsd(path)


def test_gsd_files_that_carom_cannot_read(tmp_path):
    sheared, tied = frame_of(**TWO), frame_of(**TWO)
    sheared.configuration.box = [4, 2, 0, 0.5, 0, 0]
    with pytest.raises(carom.SceneError, match=r"the box is sheared \(xy = 0.5\)"):
        carom.from_gsd(written(tmp_path / "a.gsd", sheared))
    tied.bonds.N, tied.bonds.group, tied.bonds.types, tied.bonds.typeid = 1, [[0, 1]], ["b"], [0]
    with pytest.raises(carom.SceneError, match="frame 0 has 1 bonds, which are not read"):
        carom.from_gsd(written(tmp_path / "b.gsd", tied))
    (tmp_path / "c.gsd").write_text("no GSD file")
    for name in ("c.gsd", "none.gsd"):
        with pytest.raises(carom.SceneError, match="cannot be read as a GSD file of HOOMD"):
            carom.from_gsd(tmp_path / name)


def test_files_of_the_command_begin_the_same_state(tmp_path):
    found = os.environ.get("CAROM_COMMAND") or shutil.which("carom")
    if not found:
        pytest.skip("the command `carom` is not installed, and CAROM_COMMAND does not name it")
    words = shlex.split(found)
    gases = [{"radius": r, "mass": m, "temperature": 1.0, "count": n, "tags": [tag]}
             for r, m, n, tag in ((0.05, 1.0, 20, "A"), (0.1, 2.0, 10, "B"))]
    run = {"until": 0.5, "sample_interval": 0.1, "snapshots": "extxyz"}
    (tmp_path / "s.toml").write_text(carom.Scene(box=(3, 2), gas=gases, run=run, seed=4).to_toml())
    subprocess.run([*words, "run", str(tmp_path / "s.toml"), "--out", str(tmp_path / "o")], check=True,
                   capture_output=True)
    ended = carom.load(tmp_path / "o")
    for ending, tolerance in (("lammpstrj", 1e-15), ("data", 1e-15), ("gsd", 1e-6)):
        if ending == "gsd":
            pytest.importorskip("gsd.hoomd")
        path = tmp_path / f"a.{ending}"
        subprocess.run([*words, "convert", str(tmp_path / "o" / "trajectory.extxyz"), str(path)], check=True,
                       capture_output=True)
        read = carom.from_gsd(path) if ending == "gsd" else carom.from_lammps(
            path, radius={1: 0.05, 2: 0.1} if ending == "data" else None)
        sim = carom.Simulation(read)
        away = sim.positions - ended.positions
        assert np.abs(away - np.round(away / [3, 2]) * [3, 2]).max() <= tolerance
        assert np.abs(sim.velocities - ended.velocities).max() <= tolerance
