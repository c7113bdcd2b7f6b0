"""Scenes from configurations of DynamO."""

from __future__ import annotations

import bz2
import math
import os
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Union
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from ._errors import SceneError
from ._scene import Scene

__all__ = ["from_dynamo"]

Path = Union[str, "os.PathLike[str]"]
# A set of particles, by their numbers.
Ids = Container[int]
# An interaction, its pairs (one particle of the first set and one of the second), and the sets of
# particles that it pairs with themselves.
Interaction = tuple[Element, tuple[list[tuple[Ids, Ids]], list[Ids]]]

_VERSION = "1.5.0"
# Neighbour lists, and an event that keeps periodic images apart: they do not change the motion.
_BOOKKEEPING = ("Cells", "PBCSentinel")
# More groups of particles with interactions of their own are a rule for each pair.
_MOST_GROUPS = 64
# A larger relative difference from the sum of two radii is an entry [[diameter]].
_ROUNDING = 1e-12


@dataclass
class _Rule:
    """What happens between two particles: nothing, or hard discs, perhaps with a well.

    The diameter is a number, or the name of a property of each particle.
    """

    name: str
    diameter: float | str | None
    elasticity: float = 1.0
    well: tuple[float, float] | None = None


@dataclass
class _Group:
    """Particles of a species that all interactions treat alike."""

    species: str
    tag: str
    members: list[int]
    # A number, or the name of a property of each particle, of which it is the half.
    radius: float | str | None = None


def from_dynamo(path: Path) -> Scene:
    """A scene with the particles and interactions of a configuration of DynamO in the plane.

    Each particle is an entry ``molecule`` with its place and velocity; its species is a tag. All z
    must be equal, and all velocities along z must be 0: the motion is then that of discs. The lower
    left corner of the box becomes the origin. Interactions ``HardSphere`` become radii, and factors
    ``[[diameter]]`` where a diameter is not the sum of two radii; ``SquareWell`` becomes
    ``[[well]]``, ``Null`` becomes ``[[transparent]]``, and elasticities become ``[elasticity]``.
    Where interactions divide a species, its particles have a second tag, such as ``Bulk-2``.
    Diameters and masses may be properties of each particle, and particles of the species
    ``FixedCollider`` are fixed.

    Scheduler, ensemble, topology, neighbour lists, capture maps and the side z of the box are not
    read. What else would change the motion is refused.

    Parameters
    ----------
    path : str or path
        The file, of version 1.5.0; also one compressed by bzip2.

    Returns
    -------
    Scene
        Its ``replaced`` adds the run, measures and rules.

    Raises
    ------
    SceneError
        The file cannot be read, is not in the plane, or has an entry that carom lacks: another
        boundary, dynamics or interaction, bonds, locals, globals and system events. The message
        names the entry.

    Examples
    --------
    >>> import carom, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "two.xml"
    >>> _ = path.write_text('''<DynamOconfig version="1.5.0"><Simulation>
    ...   <SimulationSize x="10" y="10" z="10"/><BC Type="PBC"/><Dynamics Type="Newtonian"/>
    ...   <Genus><Species Mass="1" Name="Bulk" Type="Point"><IDRange Type="All"/></Species></Genus>
    ...   <Interactions>
    ...     <Interaction Type="SquareWell" Diameter="1" Lambda="1.5" WellDepth="1" Name="Bulk">
    ...       <IDPairRange Type="All"/>
    ...     </Interaction>
    ...   </Interactions>
    ... </Simulation><ParticleData>
    ...   <Pt ID="0"><P x="-2" y="0" z="0"/><V x="1" y="0" z="0"/></Pt>
    ...   <Pt ID="1"><P x="2" y="0" z="0"/><V x="-1" y="0" z="0"/></Pt>
    ... </ParticleData></DynamOconfig>''')
    >>> scene = carom.from_dynamo(path)
    >>> [one["at"] for one in scene.tables["molecule"]], scene.tables["well"][0]["steps"]
    ([[3.0, 5.0], [7.0, 5.0]], [[1.5, -1.0]])
    """
    name = os.fspath(path)
    root = _root(name)
    simulation = _child(name, root, "Simulation")
    _check(name, simulation)
    size = _child(name, simulation, "SimulationSize")
    sides = [_number(f"{name}: SimulationSize", size, axis) for axis in "xy"]
    for axis, side in zip("xy", sides):
        if not (math.isfinite(side) and side > 0):
            raise SceneError(f"{name}: SimulationSize: {axis} must be positive, but is {side:g}")
    particles = list(_child(name, root, "ParticleData").iter("Pt"))
    if not particles:
        raise SceneError(f"{name}: ParticleData has no particles")
    properties = {entry.get("Name") for entry in root.iterfind("Properties/Property")}
    species = list(_child(name, simulation, "Genus").iter("Species"))
    interactions = [
        (entry, _pairs(f"{name}: interaction {entry.get('Name')!r}", entry.find("IDPairRange"), len(particles)))
        for entry in _child(name, simulation, "Interactions").iter("Interaction")
    ]
    kinds = _kinds(name, species, len(particles))
    groups = _groups([entry.get("Name") or str(index) for index, entry in enumerate(species)], kinds, interactions)
    if len(groups) > _MOST_GROUPS:
        raise SceneError(
            f"{name}: the interactions divide the particles into {len(groups)} groups; at most {_MOST_GROUPS} are read"
        )
    rules = _rules(name, groups, interactions, properties)
    entries = []
    group_of = {member: group for group in groups for member in group.members}
    z = _vector(f"{name}: particle 0", particles[0], "P")[2]
    for index, particle in enumerate(particles):
        where, group = f"{name}: particle {index}", group_of[index]
        (x, y, height), (vx, vy, vz) = (_vector(where, particle, tag) for tag in "PV")
        if height != z or vz:
            raise SceneError(
                f"{where}: z is {height:g} and its velocity {vz:g}, but must be {z:g}, that of particle 0, and 0: "
                "carom has two dimensions"
            )
        if particle.get("Static") is not None:
            raise SceneError(f"{where}: static particles are not read")
        radius = group.radius
        assert radius is not None
        if isinstance(radius, str):
            radius = _number(where, particle, radius) / 2
        kind = species[kinds[index]]
        fixed = kind.get("Type") == "FixedCollider"
        if fixed and (vx or vy):
            raise SceneError(f"{where}: a fixed particle must have the velocity 0, but has ({vx:g}, {vy:g})")
        mass = 1.0 if fixed else _property(f"{name}: species {kind.get('Name')!r}", kind, "Mass", properties)
        if isinstance(mass, str):
            mass = _number(where, particle, mass)
        for what, value in (("radius", radius), ("mass", mass)):
            if not (math.isfinite(value) and value > 0):
                raise SceneError(f"{where}: the {what} must be positive, but is {value:g}")
        entry: dict[str, Any] = {"shape": "disc", "atom_radius": radius, "atom_mass": mass}
        entry |= {"tags": [*dict.fromkeys((group.species, group.tag))], "at": [x + sides[0] / 2, y + sides[1] / 2]}
        entry |= {"fixed": True} if fixed else {"velocity": [vx, vy]}
        entries.append(entry)
    return Scene({"box": {"sides": sides}, "molecule": entries, **rules})


def _root(name: str) -> Element:
    try:
        with open(name, "rb") as file:
            content = file.read()
        root = ElementTree.fromstring(bz2.decompress(content) if content.startswith(b"BZh") else content)
    except (OSError, ValueError, EOFError, ElementTree.ParseError) as error:
        raise SceneError(f"{name}: cannot be read as XML: {error}") from error
    if root.tag != "DynamOconfig":
        raise SceneError(f"{name}: it is no configuration of DynamO: its first element is {root.tag!r:.40}")
    if root.get("version") != _VERSION:
        raise SceneError(
            f"{name}: version {_VERSION} is read, but the file has {root.get('version')!r:.20}; "
            "a newer dynamod converts it"
        )
    return root


def _check(name: str, simulation: Element) -> None:
    """Refuses what changes the motion and is not read."""
    for tag, expected in (("BC", "PBC"), ("Dynamics", "Newtonian")):
        found = _child(name, simulation, tag).get("Type")
        if found != expected:
            raise SceneError(f"{name}: {tag} of type {found!r} is not read, {expected!r} is")
    for place in ("Locals", "Globals", "SystemEvents"):
        for entry in simulation.iterfind(f"{place}/*"):
            if place != "Globals" or entry.get("Type") not in _BOOKKEEPING:
                raise SceneError(
                    f"{name}: {place}: {entry.tag} of type {entry.get('Type')!r} is not read; without it in the file, "
                    "walls, gravity and thermostats are entries of the scene"
                )


def _kinds(name: str, species: Sequence[Element], count: int) -> list[int]:
    """The number of the species of each particle."""
    names = [entry.get("Name") for entry in species]
    if len(set(names)) < len(names):
        raise SceneError(f"{name}: two species have one name: {', '.join(map(str, names))}")
    ranges = []
    for entry in species:
        where = f"{name}: species {entry.get('Name')!r}"
        if entry.get("Type") not in ("Point", "SphericalTop", "FixedCollider"):
            raise SceneError(
                f"{where}: the type {entry.get('Type')!r} is not read; Point, SphericalTop and FixedCollider are"
            )
        ranges.append(_ids(where, entry.find("IDRange"), count))
    found = []
    for index in range(count):
        of = [kind for kind, ids in enumerate(ranges) if index in ids]
        if len(of) != 1:
            raise SceneError(f"{name}: particle {index} must have one species, but has {len(of)}")
        found.append(of[0])
    return found


def _groups(
    names: Sequence[str], kinds: Sequence[int], interactions: Sequence[Interaction]
) -> list[_Group]:
    """Particles of one species that are in the same sets of all interactions."""
    sets = [ids for _, (pairs, _) in interactions for pair in pairs for ids in pair]
    sets += [ids for _, (_, selves) in interactions for ids in selves]
    members: dict[tuple[Any, ...], list[int]] = {}
    for index, kind in enumerate(kinds):
        members.setdefault((kind, *(index in ids for ids in sets)), []).append(index)
    groups: list[_Group] = []
    for (kind, *_), each in members.items():
        before = sum(group.species == names[kind] for group in groups)
        groups.append(_Group(names[kind], f"{names[kind]}-{before + 1}", each))
    for group in groups:
        if sum(other.species == group.species for other in groups) == 1:
            group.tag = group.species
    return groups


def _rules(
    name: str, groups: Sequence[_Group], interactions: Sequence[Interaction], properties: set[str | None]
) -> dict[str, Any]:
    """Tables of the rules of pairs; sets the radii of the groups."""
    pairs: dict[tuple[int, int], _Rule] = {}
    for a, one in enumerate(groups):
        for b, other in enumerate(groups[: a + 1]):
            if a != b or len(one.members) > 1:
                # A pair of different particles.
                pairs[b, a] = _rule(name, other.members[0], one.members[-1], interactions, properties)
        alike = pairs.get((a, a)) or _rule(name, one.members[0], one.members[0], interactions, properties)
        one.radius = alike.diameter / 2 if isinstance(alike.diameter, float) else alike.diameter
    for group in groups:
        if group.radius is None:
            group.radius = _radius(name, groups, pairs, group)
    tables: dict[str, list[dict[str, Any]]] = {"diameter": [], "well": [], "transparent": []}
    for (b, a), rule in pairs.items():
        one, other = groups[b], groups[a]
        between = [one.tag] if a == b else [one.tag, other.tag]
        if rule.diameter is None:
            tables["transparent"].append({"between": between})
            continue
        factor = _factor(name, rule, one, other)
        if abs(factor - 1) > _ROUNDING:
            tables["diameter"].append({"between": between, "factor": factor})
        if rule.well is not None:
            tables["well"].append({"between": between, "steps": [list(rule.well)]})
    found: dict[str, Any] = {key: entries for key, entries in tables.items() if entries}
    elasticities = {pair: rule.elasticity for pair, rule in pairs.items() if rule.diameter is not None}
    if elasticities:
        usual = next(iter(elasticities.values()))
        others = [
            {"between": [groups[b].tag, groups[a].tag], "coefficient": value}
            for (b, a), value in elasticities.items()
            if value != usual
        ]
        if usual != 1 or others:
            found["elasticity"] = {"default": usual, **({"pair": others} if others else {})}
    return found


def _radius(
    name: str, groups: Sequence[_Group], pairs: Mapping[tuple[int, int], _Rule], group: _Group
) -> float:
    """The radius of particles that do not collide with their like: what others leave of a diameter."""
    for (b, a), rule in pairs.items():
        other = groups[a] if groups[b] is group else groups[b]
        if (groups[a] is group) == (groups[b] is group) or not isinstance(rule.diameter, float):
            continue
        if isinstance(other.radius, float) and rule.diameter > other.radius:
            return rule.diameter - other.radius
        return rule.diameter / 2
    raise SceneError(f"{name}: no interaction gives a diameter of the species {group.species!r}")


def _factor(name: str, rule: _Rule, one: _Group, other: _Group) -> float:
    """The diameter of an interaction in units of the sum of the two radii."""
    assert one.radius is not None and other.radius is not None
    if isinstance(rule.diameter, float) and isinstance(one.radius, float) and isinstance(other.radius, float):
        return rule.diameter / (one.radius + other.radius)
    if rule.diameter == one.radius == other.radius:
        # The mean of the diameters of the two.
        return 1.0
    raise SceneError(
        f"{name}: interaction {rule.name!r}: particles of the species {one.species!r} and {other.species!r} have "
        "diameters of each particle in one interaction and others in another one, which is not read"
    )


def _rule(
    name: str, one: int, other: int, interactions: Sequence[Interaction], properties: set[str | None]
) -> _Rule:
    """The first interaction to which two particles belong."""
    for entry, (pairs, selves) in interactions:
        of_pair = any((one in a and other in b) or (one in b and other in a) for a, b in pairs)
        if of_pair or (one == other and any(one in ids for ids in selves)):
            return _interaction(f"{name}: interaction {entry.get('Name')!r}", entry, properties)
    raise SceneError(f"{name}: the particles {one} and {other} have no interaction")


def _interaction(where: str, entry: Element, properties: set[str | None]) -> _Rule:
    kind, name = entry.get("Type"), entry.get("Name") or ""
    if kind == "Null":
        return _Rule(name, None)
    if kind not in ("HardSphere", "SquareWell"):
        raise SceneError(f"{where}: the type {kind!r} is not read; HardSphere, SquareWell and Null are")
    if entry.get("TangentialElasticity") is not None and _number(where, entry, "TangentialElasticity") != 1:
        raise SceneError(
            f"{where}: TangentialElasticity is {entry.get('TangentialElasticity')}, but must be 1: spheres and discs "
            "have other moments of inertia; `elasticity.tangential` of the scene makes contacts rough"
        )
    elasticity = _number(where, entry, "Elasticity") if entry.get("Elasticity") is not None else 1.0
    diameter = _property(where, entry, "Diameter", properties)
    if isinstance(diameter, float) and not (math.isfinite(diameter) and diameter > 0):
        raise SceneError(f"{where}: Diameter must be positive, but is {diameter:g}")
    rule = _Rule(name, diameter, elasticity)
    if kind == "SquareWell":
        reach, depth = _number(where, entry, "Lambda"), _number(where, entry, "WellDepth")
        if reach <= 1:
            raise SceneError(f"{where}: Lambda must be above 1, but is {reach:g}")
        rule.well = (reach, -depth) if depth else None
    return rule


def _pairs(where: str, entry: Element | None, count: int) -> tuple[list[tuple[Ids, Ids]], list[Ids]]:
    """Pairs of an ``IDPairRange``, and sets of particles that are paired with themselves."""
    kind = None if entry is None else entry.get("Type")
    if entry is None or kind not in ("All", "None", "Single", "Pair", "Self", "Union"):
        raise SceneError(
            f"{where}: IDPairRange of type {kind!r} is not read; All, None, Single, Pair, Self and Union are"
        )
    if kind == "Union":
        parts = [_pairs(where, part, count) for part in entry.iterfind("IDPairRange")]
        return [pair for pairs, _ in parts for pair in pairs], [ids for _, selves in parts for ids in selves]
    sets = [_ids(where, part, count) for part in entry.iterfind("IDRange")]
    expected = {"All": 0, "None": 0, "Single": 1, "Pair": 2, "Self": 1}[kind]
    if len(sets) != expected:
        raise SceneError(f"{where}: IDPairRange of type {kind} must have {expected} IDRange, but has {len(sets)}")
    if kind == "Self":
        return [], list(sets)
    if kind == "None":
        return [], []
    first, last = (sets[0], sets[-1]) if sets else (range(count), range(count))
    return [(first, last)], []


def _ids(where: str, entry: Element | None, count: int) -> Ids:
    """The particles of an ``IDRange``."""
    kind = None if entry is None else entry.get("Type")
    if entry is not None and kind == "All":
        return range(count)
    if entry is not None and kind == "None":
        return range(0)
    if entry is not None and kind == "Ranged":
        return range(_whole(where, entry, "Start"), _whole(where, entry, "End") + 1)
    if entry is not None and kind in ("List", "Union"):
        return frozenset(_listed(where, entry, count))
    raise SceneError(f"{where}: IDRange of type {kind!r} is not read; All, None, Ranged, List and Union are")


def _listed(where: str, entry: Element, count: int) -> Iterator[int]:
    for part in entry.iterfind("ID"):
        yield _whole(where, part, "val")
    for part in entry.iterfind("IDRange"):
        ids = _ids(where, part, count)
        yield from (index for index in range(count) if index in ids)


def _child(name: str, parent: Element, tag: str) -> Element:
    found = parent.find(tag)
    if found is None:
        raise SceneError(f"{name}: {parent.tag} has no {tag}")
    return found


def _vector(where: str, particle: Element, tag: str) -> tuple[float, float, float]:
    found = particle.find(tag)
    if found is None:
        raise SceneError(f"{where}: it has no {tag}")
    x, y, z = (_number(f"{where}: {tag}", found, axis) for axis in "xyz")
    if not all(map(math.isfinite, (x, y, z))):
        raise SceneError(f"{where}: {tag} is not finite: {(x, y, z)}")
    return x, y, z


def _property(where: str, entry: Element, key: str, properties: set[str | None]) -> float | str:
    """A number, or the name of a property of each particle."""
    found = entry.get(key)
    return found if found is not None and found in properties else _number(where, entry, key)


def _number(where: str, entry: Element, key: str) -> float:
    found = entry.get(key)
    if found is None:
        raise SceneError(f"{where}: {entry.tag} has no {key}")
    try:
        return float(found)
    except ValueError:
        raise SceneError(f"{where}: {key} must be a number, but is {found!r:.40}") from None


def _whole(where: str, entry: Element, key: str) -> int:
    found = entry.get(key) or ""
    if not (found.isascii() and found.isdecimal()):
        raise SceneError(f"{where}: {key} must be the number of a particle from 0 on, but is {found!r:.40}")
    return int(found)
