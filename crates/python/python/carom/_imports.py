"""Scenes from files of other programs: GSD (HOOMD), and data files and dumps of LAMMPS.

Configurations of DynamO have a module of their own.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Union

from ._errors import MoleculeError, SceneError
from ._exports import package
from ._molecule import Molecule
from ._plain import number, whole
from ._scene import Scene

__all__ = ["from_gsd", "from_lammps"]

Path = Union[str, "os.PathLike[str]"]
Sizes = Union[float, "Mapping[str, float]", "Mapping[int, float]", None]

# Columns of the section Atoms, by atom style; three image flags may follow.
_STYLES = {
    "atomic": "id type x y z",
    "charge": "id type q x y z",
    "bond": "id mol type x y z",
    "angle": "id mol type x y z",
    "molecular": "id mol type x y z",
    "full": "id mol type q x y z",
    "sphere": "id type diameter density x y z",
}
# Entries of a data file that tie atoms to each other, or describe bodies of other shapes.
_REFUSED = ("bonds", "angles", "dihedrals", "impropers", "ellipsoids", "lines", "triangles", "bodies")


@dataclass
class _Particle:
    """A particle of a file; what the file lacks is None."""

    where: str
    kind: str
    place: tuple[float, float]
    velocity: tuple[float, float] = (0.0, 0.0)
    radius: float | None = None
    mass: float | None = None
    angle: float = 0.0
    spin: float = 0.0
    shape: Molecule | None = None


def from_gsd(path: Path, frame: int = -1, *, radius: Sizes = None, mass: Sizes = None) -> Scene:
    """A scene with the particles of a frame of a GSD file of HOOMD, which needs the package gsd.

    Each particle is an entry ``molecule`` with its place, orientation and velocity, and its type as
    tag. The lower left corner of the box becomes the origin. Of ``particles/type_shapes`` the
    kinds ``Sphere``, ``Polygon`` and ``Ellipsoid`` are read; a type without a shape is a disc of
    ``particles/diameter``. Angular momenta, moments of inertia, charges and images are not read:
    all angular velocities are 0. Places in single precision may overlap by rounding; a slightly
    smaller ``radius`` prevents it.

    Parameters
    ----------
    path : str or path
        The file.
    frame : int
        Number of the frame from 0, or from the end if it is negative. Default: the last.
    radius : float or mapping of str to float, optional
        Radius of all discs, or by type (length), instead of that of the file.
    mass : float or mapping of str to float, optional
        Mass of all particles, or by type, instead of that of the file.

    Returns
    -------
    Scene
        Its ``replaced`` adds the run, measures and rules.

    Raises
    ------
    SceneError
        The file cannot be read, has no such frame, or has an entry that carom lacks: a sheared box,
        a third dimension, bonds, constraints, rigid bodies of several particles, another shape. The
        message names the entry. Rigid bodies can start by ``start.from`` of a scene file.
    ImportError
        The package gsd is not installed.

    Examples
    --------
    >>> import carom, gsd.hoomd, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "two.gsd"
    >>> sim = carom.Simulation(carom.Scene(gas={"radius": 0.02, "mass": 1, "energy": 1, "count": 9}))
    >>> with gsd.hoomd.open(path, "w") as file:
    ...     file.append(sim.to_gsd())
    >>> again = carom.Simulation(carom.from_gsd(path))
    >>> len(again), bool(abs(again.positions - sim.positions).max() < 1e-6)
    (9, True)
    """
    hoomd = package("gsd.hoomd", "gsd")
    name = os.fspath(path)
    try:
        with hoomd.open(name, "r") as file:
            count = len(file)
            index = _frame(name, frame, count)
            found = file[index]
    except SceneError:
        raise
    except Exception as error:
        # gsd raises OSError, RuntimeError, KeyError and others for damaged files.
        raise SceneError(f"{name}: cannot be read as a GSD file of HOOMD: {error}") from error
    for kind in ("bonds", "constraints"):
        if getattr(found, kind).N:
            raise SceneError(f"{name}: frame {index} has {getattr(found, kind).N} {kind}, which are not read")
    if found.configuration.box is None:
        raise SceneError(f"{name}: frame {index} has no box")
    x, y, _, xy, _, _ = (float(edge) for edge in found.configuration.box)
    if xy:
        raise SceneError(f"{name}: the box is sheared (xy = {xy:g}), but carom's is a rectangle")
    return _scene(name, (x, y), _gsd_particles(name, found, (x, y)), radius, mass)


def _gsd_particles(name: str, frame: Any, sides: tuple[float, float]) -> list[_Particle]:
    rows, kinds = frame.particles, frame.particles.types or ["A"]
    shapes = list(rows.type_shapes or [])
    shapes += [{}] * (len(kinds) - len(shapes))
    found: list[_Particle] = []
    made: dict[tuple[int, float], Molecule] = {}
    columns: list[Any] = [
        entry.tolist()
        for entry in (rows.position, rows.orientation, rows.velocity, rows.typeid, rows.mass, rows.diameter, rows.body)
    ]
    for index, (place, turn, velocity, kind, mass, diameter, body) in enumerate(zip(*columns)):
        where = f"{name}: particle {index}"
        if not 0 <= kind < len(kinds):
            raise SceneError(f"{where}: its type is {kind}, but there are {len(kinds)} types, numbered from 0")
        if place[2]:
            raise SceneError(f"{where}: z is {place[2]:g}, but must be 0: carom has two dimensions")
        if turn[1] or turn[2]:
            raise SceneError(f"{where}: its orientation {turn} is no rotation in the plane")
        if body not in (-1, 2**32 - 1):
            raise SceneError(
                f"{where}: it belongs to the rigid body {body}, which is not read; "
                "`start.from` of a scene that describes the bodies can read it"
            )
        one = _Particle(where, kinds[kind], (place[0] + sides[0] / 2, place[1] + sides[1] / 2),
                        (velocity[0], velocity[1]), None, mass, 2 * math.atan2(turn[3], turn[0]))
        shape = shapes[kind]
        word = shape.get("type")
        if word in (None, "Sphere"):
            one.radius = float(shape.get("diameter", diameter)) / 2
        elif word in ("Polygon", "Ellipsoid"):
            try:
                if (kind, mass) not in made:
                    made[kind, mass] = _polygon(shape, mass) if word == "Polygon" else _ellipse(shape, mass)
            except (KeyError, TypeError, ValueError, MoleculeError) as error:
                raise SceneError(f"{name}: the shape {shape!r:.100} of type {kinds[kind]!r}: {error}") from error
            one.shape = made[kind, mass]
            if word == "Polygon":
                _to_centre(one, shape["vertices"])
            elif shape["b"] > shape["a"]:
                one.angle += math.pi / 2
        else:
            raise SceneError(
                f"{name}: the shape {word!r} of type {kinds[kind]!r} is not read; "
                "Sphere, Polygon and Ellipsoid are"
            )
        found.append(one)
    return found


def _polygon(shape: Mapping[str, Any], mass: float) -> Molecule:
    corners = [(float(x), float(y)) for x, y, *_ in shape["vertices"]]
    size = max((math.dist(one, other) for one in corners for other in corners), default=0.0)
    radius = float(shape.get("rounding_radius", 0.0))
    return Molecule.polygon(corners, mass=mass, rounding=radius / size if radius else None)


def _ellipse(shape: Mapping[str, Any], mass: float) -> Molecule:
    a, b = sorted((float(shape["a"]), float(shape["b"])))
    return Molecule.ellipse(b / a, size=2 * b, mass=mass)


def _to_centre(one: _Particle, corners: Sequence[Sequence[float]]) -> None:
    """Moves the place of a polygon from the origin of its corners to its centre of mass."""
    assert one.shape is not None
    x, y = (
        sum(corner[axis] for corner in corners) / len(corners) - float(one.shape.atoms[:, axis].mean())
        for axis in (0, 1)
    )
    cos, sin = math.cos(one.angle), math.sin(one.angle)
    one.place = (one.place[0] + cos * x - sin * y, one.place[1] + sin * x + cos * y)


def from_lammps(
    path: Path, frame: int = -1, *, radius: Sizes = None, mass: Sizes = None, style: str | None = None
) -> Scene:
    """A scene with the atoms of a LAMMPS data file, or of a frame of a text dump.

    Each atom is a disc, an entry ``molecule`` with its place and velocity, and its type (or the
    label of its type) as tag; atoms are sorted by their numbers. The lower left corner of the box
    becomes the origin. A data file has the styles atomic, charge, bond, angle, molecular, full or
    sphere. Of a dump the columns ``x y`` (or ``xs ys``, ``xu yu``, ``xsu ysu``), ``id``, ``type``,
    ``mol``, ``vx vy``, ``radius``, ``diameter``, ``mass``, ``angle`` and ``omegaz`` are read.
    Charges, images and coefficients are not.

    Parameters
    ----------
    path : str or path
        The file.
    frame : int
        Number of the frame of a dump from 0, or from the end if it is negative. Default: the last.
    radius : float or mapping of type to float, optional
        Radius of all atoms, or by type (length). Needed if the file has neither radii nor
        diameters.
    mass : float or mapping of type to float, optional
        Mass of all atoms, or by type. Needed if the file has none.
    style : str, optional
        Atom style of a data file, if the line ``Atoms`` does not end with it.

    Returns
    -------
    Scene
        Its ``replaced`` adds the run, measures and rules.

    Raises
    ------
    SceneError
        The file cannot be read, or has an entry that carom lacks: a sheared box, a border that is
        not periodic, a third dimension, bonds, molecules of several atoms, bodies of other shapes.
        The message names the line, the value and what is allowed.

    Examples
    --------
    >>> import carom, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "two.data"
    >>> _ = path.write_text(
    ...     "Two atoms\\n\\n2 atoms\\n1 atom types\\n0 2 xlo xhi\\n0 1 ylo yhi\\n\\n"
    ...     "Masses\\n\\n1 3.0\\n\\nAtoms # atomic\\n\\n1 1 0.5 0.5 0\\n2 1 1.5 0.5 0\\n"
    ... )
    >>> scene = carom.from_lammps(path, radius=0.1)
    >>> [entry["at"] for entry in scene.tables["molecule"]], scene.tables["box"]["sides"]
    ([[0.5, 0.5], [1.5, 0.5]], [2.0, 1.0])
    """
    name = os.fspath(path)
    if style is not None and style not in _STYLES:
        raise SceneError(f"`style` must be one of {', '.join(_STYLES)}, but is {style!r:.60}")
    try:
        with open(name, encoding="utf-8") as file:
            lines = file.read().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{name}: cannot be read as text: {error}") from error
    if any(line.startswith("ITEM:") for line in lines[:1]):
        sides, particles = _dump(name, lines, frame)
    else:
        sides, particles = _data(name, lines, style)
    return _scene(name, sides, particles, radius, mass)


def _dump(name: str, lines: list[str], frame: int) -> tuple[tuple[float, float], list[_Particle]]:
    starts = [index for index, line in enumerate(lines) if line.startswith("ITEM: TIMESTEP")]
    chosen = _frame(name, frame, len(starts))
    end = starts[chosen + 1] if chosen + 1 < len(starts) else len(lines)
    count, bounds, at = None, [], starts[chosen]
    while at < end:
        line, where = lines[at].strip(), f"{name}, line {at + 1}"
        if line == "ITEM: NUMBER OF ATOMS" and at + 1 < end:
            count = _whole(f"{name}, line {at + 2}", "the number of atoms", lines[at + 1].strip())
        elif line.startswith("ITEM: BOX BOUNDS"):
            flags = line.split()[3:]
            if "xy" in flags or "abc" in flags:
                raise SceneError(f"{where}: the box is sheared ({' '.join(flags)}), but carom's is a rectangle")
            for axis, flag in zip("xy", flags):
                if flag != "pp":
                    raise SceneError(f"{where}: the border {axis} is {flag!r}, but must be 'pp': carom's is periodic")
            bounds = [_numbers(f"{name}, line {k + 1}", lines[k].split()[:2]) for k in range(at + 1, min(at + 3, end))]
        elif line.startswith("ITEM: ATOMS"):
            if count is None or len(bounds) != 2 or any(len(pair) != 2 for pair in bounds):
                raise SceneError(f"{where}: the number of atoms or the box is missing before the atoms")
            names = line.split()[2:]
            rows = [(k + 1, lines[k].split()) for k in range(at + 1, min(at + 1 + count, end))]
            if len(rows) < count:
                raise SceneError(f"{where}: the frame must have {count} atoms, but has {len(rows)}")
            (left, right), (low, high) = bounds
            return (right - left, high - low), _atoms(name, rows, names, (left, low), (right - left, high - low))
        at += 1
    raise SceneError(f"{name}: frame {chosen} has no atoms")


def _data(name: str, lines: list[str], style: str | None) -> tuple[tuple[float, float], list[_Particle]]:
    bounds: dict[str, list[float]] = {}
    sections: dict[str, list[tuple[int, list[str]]]] = {}
    section, hint, counted, at_atoms = None, "", None, 0
    # The first line is a title.
    for index, whole_line in enumerate(lines[1:], 2):
        line, _, comment = whole_line.partition("#")
        words, where = line.split(), f"{name}, line {index}"
        if not words:
            continue
        if words[0][0].isalpha() and not any(letter.isdigit() for letter in line):
            section = " ".join(words)
            sections[section] = []
            if section == "Atoms":
                hint, at_atoms = comment.strip(), index
        elif section is not None:
            sections[section].append((index, words))
        elif words[-2:] in (["xlo", "xhi"], ["ylo", "yhi"]):
            bounds[words[-2][0]] = _numbers(where, words[:2])
        elif words[-3:] == ["xy", "xz", "yz"]:
            if any(_numbers(where, words[:3])):
                raise SceneError(f"{where}: the box is sheared ({line.strip()}), but carom's is a rectangle")
        elif words[-1] in _REFUSED and len(words) == 2 and words[0] != "0":
            raise SceneError(f"{where}: {words[0]} {words[-1]} are not read: the file must have single atoms alone")
        elif words[1:] == ["atoms"]:
            counted = _whole(where, "the number of atoms", words[0])
    for axis in "xy":
        if len(bounds.get(axis, [])) != 2:
            raise SceneError(f"{name}: it is neither a data file nor a dump of LAMMPS: no line `{axis}lo {axis}hi`")
    if counted is None or len(sections.get("Atoms", [])) != counted:
        raise SceneError(
            f"{name}: the head must have the number of lines of the section Atoms, "
            f"but has {counted} for {len(sections.get('Atoms', []))}"
        )
    style = style or hint
    if style not in _STYLES:
        raise SceneError(
            f"{name}, line {at_atoms}: the atom style is {style!r}; "
            f"give `style`, one of {', '.join(_STYLES)}"
        )
    (left, right), (low, high) = bounds["x"], bounds["y"]
    sides = (right - left, high - low)
    names = _STYLES[style].split()
    rows = sections["Atoms"]
    for index, words in rows:
        if len(words) not in (len(names), len(names) + 3):
            raise SceneError(
                f"{name}, line {index}: an atom of style {style} has {len(names)} columns ({' '.join(names)}) "
                f"and perhaps three images, but {len(words)} are there"
            )
    velocities = {}
    for index, words in sections.get("Velocities", []):
        numbers = _numbers(f"{name}, line {index}", words[1:3])
        if len(numbers) != 2:
            raise SceneError(f"{name}, line {index}: a velocity has an atom and 3 numbers, not {' '.join(words)!r:.60}")
        velocities[words[0]] = (index, numbers)
    joined = []
    for index, words in rows:
        _, velocity = velocities.pop(words[0], (0, [0.0, 0.0]))
        joined.append((index, [*words[: len(names)], *map(repr, velocity)]))
    for atom, (index, _) in velocities.items():
        raise SceneError(f"{name}, line {index}: a velocity of atom {atom}, which is not in the section Atoms")
    particles = _atoms(name, joined, [*names, "vx", "vy"], (left, low), sides)
    labels = {words[0]: words[1] for _, words in sections.get("Atom Type Labels", []) if len(words) == 2}
    masses = {}
    for index, words in sections.get("Masses", []):
        numbers = _numbers(f"{name}, line {index}", words[1:2])
        if len(numbers) != 1:
            raise SceneError(f"{name}, line {index}: a type and its mass are expected, not {' '.join(words)!r:.60}")
        masses[labels.get(words[0], words[0])] = numbers[0]
    for one in particles:
        one.kind = labels.get(one.kind, one.kind)
        one.mass = masses.get(one.kind) if one.mass is None else one.mass
    return sides, particles


def _atoms(
    name: str,
    rows: Iterable[tuple[int, list[str]]],
    names: Sequence[str],
    corner: tuple[float, float],
    sides: tuple[float, float],
) -> list[_Particle]:
    """The atoms of numbered lines with these columns, in the order of their numbers."""
    column = {key: index for index, key in enumerate(names)}
    suffix = next((end for end in ("", "u", "s", "su") if f"x{end}" in column and f"y{end}" in column), None)
    if suffix is None:
        raise SceneError(f"{name}: no columns x y, xu yu, xs ys or xsu ysu, but {' '.join(names)}")
    found: list[tuple[int, _Particle]] = []
    seen: dict[int, int] = {}
    molecules: dict[str, list[tuple[int, int]]] = {}
    for index, words in rows:
        where = f"{name}, line {index}"
        if len(words) < len(names):
            raise SceneError(f"{where}: {len(names)} columns are expected, but {len(words)} are there")

        def of(key: str, words: list[str] = words, where: str = where) -> float | None:
            return _numbers(where, [words[column[key]]])[0] if key in column else None

        atom = _whole(where, "the number of an atom", words[column["id"]]) if "id" in column else index
        if atom in seen:
            raise SceneError(f"{where}: atom {atom} occurs twice, first on line {seen[atom]}")
        seen[atom] = index
        if "mol" in column:
            molecules.setdefault(words[column["mol"]], []).append((index, atom))
        for z in (of("z"), of("zu")):
            if z:
                raise SceneError(f"{where}: z is {z:g}, but must be 0: carom has two dimensions")
        x, y = of(f"x{suffix}") or 0.0, of(f"y{suffix}") or 0.0
        place = (x * sides[0], y * sides[1]) if "s" in suffix else (x - corner[0], y - corner[1])
        diameter, density, mass = of("diameter"), of("density"), of("mass")
        radius = of("radius") if diameter is None else diameter / 2
        if density is not None and radius is not None:
            # LAMMPS has spheres also in two dimensions; the density of a point is its mass.
            mass = density * 4 / 3 * math.pi * radius**3 if radius else density
        kind = words[column["type"]] if "type" in column else "1"
        one = _Particle(where, kind, place, (of("vx") or 0.0, of("vy") or 0.0), radius or None, mass,
                        of("angle") or 0.0, of("omegaz") or 0.0)
        found.append((atom, one))
    for molecule, atoms in molecules.items() if molecules.keys() != {"0"} else ():
        if len(atoms) > 1:
            (first, atom), (index, other) = atoms[:2]
            raise SceneError(
                f"{name}, line {index}: atom {other}, and atom {atom} of line {first}, are of molecule {molecule}; "
                "molecules of several atoms are not read: single atoms have different numbers, or all have 0"
            )
    return [one for _, one in sorted(found, key=lambda entry: entry[0])]


def _scene(
    name: str, sides: tuple[float, float], particles: list[_Particle], radius: Sizes, mass: Sizes
) -> Scene:
    for axis, side in zip("xy", sides):
        if not (math.isfinite(side) and side > 0):
            raise SceneError(f"{name}: the side {axis} of the box must be positive, but is {side:g}")
    if not particles:
        raise SceneError(f"{name}: there are no particles")
    kinds = sorted({one.kind for one in particles})
    radii, masses = _sizes(name, "radius", radius, kinds), _sizes(name, "mass", mass, kinds)
    entries = []
    for one in particles:
        entry: dict[str, Any]
        weight = _size(one, "mass", masses(one.kind), one.mass)
        if one.shape is None:
            size = _size(one, "radius", radii(one.kind), one.radius)
            entry = {"shape": "disc", "atom_radius": size, "atom_mass": weight}
        elif radii(one.kind) is not None:
            raise SceneError(f"{name}: `radius` is given for type {one.kind!r}, whose shape has none")
        else:
            entry = {**one.shape._description(), "mass": weight}
        motion = (*one.place, *one.velocity, one.angle, one.spin)
        if not all(map(math.isfinite, motion)):
            raise SceneError(f"{one.where}: place, velocity or orientation is not finite: {motion}")
        entry |= {"tags": [one.kind], "at": list(one.place), "velocity": list(one.velocity)}
        entry |= {"orientation": one.angle, "angular_velocity": one.spin}
        entries.append(entry)
    return Scene(box=sides, molecule=entries)


def _sizes(name: str, key: str, given: Sizes, kinds: Sequence[str]) -> Callable[[str], float | None]:
    """The values of an argument by type."""
    if not isinstance(given, Mapping):
        same = None if given is None else number(key, given)
        return lambda _: same
    by_kind = {str(kind): number(f"{key}[{kind!r}]", value) for kind, value in given.items()}
    for kind in by_kind:
        if kind not in kinds:
            raise SceneError(f"`{key}`: {name} has no particle of type {kind!r}; its types are {', '.join(kinds)}")
    return by_kind.get


def _size(one: _Particle, key: str, given: float | None, read: float | None) -> float:
    value = read if given is None else given
    if value is None:
        raise SceneError(f"{one.where}: the file has no {key} of type {one.kind!r}: give `{key}`")
    if not (math.isfinite(value) and value > 0):
        raise SceneError(f"{one.where}: the {key} must be positive, but is {value:g}")
    return value


def _frame(name: str, frame: int, count: int) -> int:
    index = whole("frame", frame, -(2**63))
    if not -count <= index < count:
        raise SceneError(f"{name}: frame {index} is out of range: the file has {count} frames, numbered from 0")
    return index % count


def _numbers(where: str, words: Iterable[str]) -> list[float]:
    try:
        return [float(word) for word in words]
    except ValueError as error:
        raise SceneError(f"{where}: a number is expected: {error}") from None


def _whole(where: str, what: str, word: str) -> int:
    if not word.isdecimal():
        raise SceneError(f"{where}: {what} must be a whole number from 0 on, but is {word!r:.40}")
    return int(word)
