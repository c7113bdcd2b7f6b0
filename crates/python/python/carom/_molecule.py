"""Molecules: rigid unions of discs and of straight edges between them."""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np

from . import _carom
from ._errors import MoleculeError
from ._plain import number, plain, vectors, whole

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["ExposedArc", "ExposedSide", "Molecule"]

# As in `molecule.rs`.
_MOST_ATOMS = 65_536


@dataclass(frozen=True)
class ExposedArc:
    """An arc of directions in which a round probe can touch one atom of a molecule.

    Attributes
    ----------
    atom : int
        Index of the atom.
    start, end : float
        Directions of the contact normal in the molecule's frame, counter-clockwise (radians).
    radius : float
        Radius of the atom plus that of the probe (length).
    centre : tuple of float
        Centre of the atom from the centre of mass (length).

    Examples
    --------
    Examples of the members continue from this one.

    >>> import carom
    >>> arcs = carom.Molecule.dumbbell(0.5).exposed_arcs(probe=0.5)
    >>> [round(arc.angle, 6) for arc in arcs]  # 240 degrees each
    [4.18879, 4.18879]
    """

    __module__ = "carom"

    atom: int
    start: float
    end: float
    radius: float
    centre: tuple[float, float]

    @property
    def angle(self) -> float:
        """Angle of the arc (radians).

        Examples
        --------
        >>> round(arcs[0].angle, 6)
        4.18879
        """
        return self.end - self.start

    @property
    def length(self) -> float:
        """Length of the path of the probe's centre (length).

        Examples
        --------
        >>> arcs[0].length == arcs[0].radius * arcs[0].angle
        True
        """
        return self.radius * self.angle


@dataclass(frozen=True)
class ExposedSide:
    """A straight line of places of a round probe at which it touches an edge of a molecule.

    Attributes
    ----------
    edge : int
        Index of the edge.
    start, end : tuple of float
        First and last place of the probe's centre, from the centre of mass (length); the molecule
        is on the left.
    normal : float
        Direction of the contact normal in the molecule's frame, counter-clockwise (radians).
    radius : float
        Distance from the middle of the edge: its radius plus that of the probe (length).

    Examples
    --------
    Examples of the members continue from this one.

    >>> import carom
    >>> sides = carom.Molecule.square(1.0).exposed_sides(probe=0.5)
    >>> [round(side.length, 6) for side in sides]
    [1.0, 1.0, 1.0, 1.0]
    """

    __module__ = "carom"

    edge: int
    start: tuple[float, float]
    end: tuple[float, float]
    normal: float
    radius: float

    @property
    def length(self) -> float:
        """Length of the path of the probe's centre (length).

        Examples
        --------
        >>> round(sides[0].length, 6)
        1.0
        """
        return math.dist(self.start, self.end)


class Molecule:
    """A rigid union of discs, called atoms, and of straight edges between them.

    All numbers are in the frame of its centre of mass.

    Parameters
    ----------
    atoms : iterable
        For each atom, ``(x, y, radius, mass)``, or a mapping with ``at``, ``radius`` and ``mass``.
        Lengths and masses are positive, from 1e-60 to 1e60. Atoms may overlap; each adds its own
        mass.
    edges : iterable
        Pairs of indices of atoms that a straight edge joins. Edges have no mass.
    edge_radius : float, optional
        Half the thickness of all edges (length), at most the radius of the atoms at their ends.
        Default: the smaller radius of the two.
    hollow : bool
        Whether other bodies may be inside a closed line of edges. Default: its interior belongs to
        the molecule.

    Raises
    ------
    MoleculeError
        A number is out of range, there is no atom, two atoms have one centre, or an edge joins
        atoms that are not there.

    Examples
    --------
    Examples of the members continue from this one.

    >>> import carom
    >>> bent = carom.Molecule([(0, 0, 0.5, 1), (1, 0, 0.5, 1), (1, 1, 0.5, 1)])
    >>> bent.mass, round(bent.moment_of_inertia, 6)
    (3.0, 1.708333)
    """

    __module__ = "carom"
    __slots__ = ("_core", "_keys")

    def __init__(
        self,
        atoms: Iterable[Sequence[float] | Mapping[str, Any]],
        *,
        edges: Iterable[Sequence[int]] = (),
        edge_radius: float | None = None,
        hollow: bool = False,
    ) -> None:
        # As given: atoms moved to their centre of mass twice would differ by roundings.
        given = [_atom(atom) for atom in _listed("atoms", atoms)]
        keys: dict[str, Any] = {
            "atoms": [{"at": [x, y], "radius": r, "mass": m} for x, y, r, m in given]
        }
        joined = [_ends(pair) for pair in _listed("edges", edges)]
        if joined:
            keys["edges"] = joined
        if edge_radius is not None:
            keys["edge_radius"] = number("edge_radius", edge_radius)
        if hollow:
            keys["hollow"] = True
        # The keys of a scene that give its shape, size and mass.
        self._keys = keys
        self._core = _core_of(keys)

    @classmethod
    def _of(cls, keys: dict[str, Any]) -> Molecule:
        molecule = cls.__new__(cls)
        molecule._keys = keys
        molecule._core = _core_of(keys)
        return molecule

    @classmethod
    def _named(cls, shape: str, radius: float, mass: float) -> Molecule:
        radius, mass = number("radius", radius), number("mass", mass)
        return cls._of({"shape": shape, "atom_radius": radius, "atom_mass": mass})

    @classmethod
    def _sided(cls, shape: str, size: float, mass: float, rounding: float | None = None) -> Molecule:
        size, mass = number("size", size), number("mass", mass)
        return cls._of({"shape": shape, "size": size, "mass": mass, **_rounding(rounding)})

    @classmethod
    def disc(cls, radius: float, *, mass: float = 1.0) -> Molecule:
        """One disc.

        Parameters
        ----------
        radius : float
            Radius (length).
        mass : float
            Mass.

        Examples
        --------
        >>> import carom
        >>> carom.Molecule.disc(0.5).moment_of_inertia
        0.125
        """
        return cls._named("disc", radius, mass)

    @classmethod
    def dumbbell(cls, radius: float, *, mass: float = 1.0) -> Molecule:
        """Two touching atoms along x, each of this radius (length) and mass.

        Examples
        --------
        >>> import carom
        >>> len(carom.Molecule.dumbbell(0.5))
        2
        """
        return cls._named("dumbbell", radius, mass)

    @classmethod
    def rod(cls, count: int, *, radius: float, mass: float = 1.0) -> Molecule:
        """``count`` touching atoms in a row along x, each of this radius (length) and mass.

        Examples
        --------
        >>> import carom
        >>> rod = carom.Molecule.rod(8, radius=0.5)
        >>> round(rod.bounding_radius, 12)
        4.0
        """
        return cls._named(f"rod:{_count(count)}", radius, mass)

    @classmethod
    def ring(cls, count: int, *, radius: float, mass: float = 1.0) -> Molecule:
        """``count`` atoms on a circle, each touching the next.

        Examples
        --------
        >>> import carom
        >>> round(carom.Molecule.ring(6, radius=0.5).bounding_radius, 12)
        1.5
        """
        return cls._named(f"ring:{_count(count)}", radius, mass)

    @classmethod
    def cross(cls, radius: float, *, mass: float = 1.0) -> Molecule:
        """Five atoms, one at the centre and one on each side.

        Examples
        --------
        >>> import carom
        >>> carom.Molecule.cross(0.5).mass
        5.0
        """
        return cls._named("cross", radius, mass)

    @classmethod
    def tee(cls, radius: float, *, mass: float = 1.0) -> Molecule:
        """Five atoms: a bar of three along x, and two below its centre (Montanari 2017).

        Examples
        --------
        >>> import carom
        >>> carom.Molecule.tee(0.005, mass=2.0).mass
        10.0
        """
        return cls._named("tee", radius, mass)

    @classmethod
    def capsule(cls, length: float, *, size: float, mass: float = 1.0) -> Molecule:
        """All points within half the ``size`` of a straight line along x.

        Parameters
        ----------
        length : float
            Length of that line over the size.
        size : float
            Diameter (length).
        mass : float
            Mass, spread evenly over the area.

        Examples
        --------
        >>> import carom, math
        >>> capsule = carom.Molecule.capsule(2, size=0.5)
        >>> math.isclose(capsule.area, 0.5 + math.pi / 16)
        True
        """
        return cls._sided(f"capsule:{number('length', length)!r}", size, mass)

    @classmethod
    def square(cls, size: float, *, mass: float = 1.0, rounding: float | None = None) -> Molecule:
        """Four equal sides.

        Parameters
        ----------
        size : float
            Length of a side.
        mass : float
            Mass, spread evenly over the area.
        rounding : float, optional
            Radius of the corners over the size, from 1e-10. All points within this radius of the
            sharp polygon belong to the molecule. Default: 1e-6, as for all polygons.

        Examples
        --------
        >>> import carom
        >>> square = carom.Molecule.square(1.0, mass=6.0)
        >>> round(square.moment_of_inertia, 4), square.edges.tolist()
        (1.0, [[0, 1], [1, 2], [2, 3], [3, 0]])
        """
        return cls._sided("square", size, mass, rounding)

    @classmethod
    def rectangle(
        cls, aspect: float, *, size: float, mass: float = 1.0, rounding: float | None = None
    ) -> Molecule:
        """Sides of ``aspect`` sizes along x and of one ``size`` (length) along y.

        Examples
        --------
        >>> import carom
        >>> round(carom.Molecule.rectangle(3, size=0.5).area, 4)
        0.75
        """
        return cls._sided(f"rectangle:{number('aspect', aspect)!r}", size, mass, rounding)

    @classmethod
    def triangle(cls, size: float, *, mass: float = 1.0, rounding: float | None = None) -> Molecule:
        """Three equal sides of this length.

        Examples
        --------
        >>> import carom
        >>> round(carom.Molecule.triangle(2.0).area, 4)
        1.7321
        """
        return cls._sided("triangle", size, mass, rounding)

    @classmethod
    def regular_polygon(
        cls, count: int, *, size: float, mass: float = 1.0, rounding: float | None = None
    ) -> Molecule:
        """``count`` equal sides of length ``size``, from 3 to 1024; the lowest one lies along x.

        Examples
        --------
        >>> import carom
        >>> round(carom.Molecule.regular_polygon(6, size=1.0).bounding_radius, 4)
        1.0
        """
        return cls._sided(f"polygon:{_count(count)}", size, mass, rounding)

    @classmethod
    def kite(
        cls,
        ahead: float,
        behind: float,
        *,
        size: float,
        mass: float = 1.0,
        rounding: float | None = None,
    ) -> Molecule:
        """Four corners, symmetric about x.

        Parameters
        ----------
        ahead, behind : float
            Distances of the tips on the x axis from the cross diagonal, over the size.
        size : float
            Length of the cross diagonal.
        mass, rounding : float
            As those of :meth:`square`.

        Examples
        --------
        >>> import carom
        >>> round(carom.Molecule.kite(1.0, 0.5, size=2.0).area, 4)
        3.0
        """
        tips = f"{number('ahead', ahead)!r},{number('behind', behind)!r}"
        return cls._sided(f"kite:{tips}", size, mass, rounding)

    @classmethod
    def ellipse(cls, ratio: float, *, size: float, mass: float = 1.0) -> Molecule:
        """An ellipse whose longer axis lies along x.

        Parameters
        ----------
        ratio : float
            The longer axis over the shorter one, from 1 to 10000.
        size : float
            Length of the longer axis.
        mass : float
            Mass, spread evenly over the area.

        Examples
        --------
        >>> import carom
        >>> round(carom.Molecule.ellipse(2.0, size=2.0).area, 4)
        1.5708
        """
        return cls._sided(f"ellipse:{number('ratio', ratio)!r}", size, mass, None)

    @classmethod
    def polygon(
        cls, corners: ArrayLike, *, mass: float = 1.0, rounding: float | None = None
    ) -> Molecule:
        """A polygon with these corners, convex or not, whose sides do not cross.

        Parameters
        ----------
        corners : array_like, shape (n, 2)
            The corners in their order, in any frame (length): 3 to 1024.
        mass : float
            Mass, spread evenly over the area.
        rounding : float, optional
            Radius of the corners over the largest distance of two of them, from 1e-10. Default:
            1e-6.

        Examples
        --------
        >>> import carom
        >>> ell = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]]
        >>> round(carom.Molecule.polygon(ell).area, 3)
        5.0
        """
        places = vectors("corners", corners).reshape(-1, 2).tolist()
        return cls._of({"polygon": places, "mass": number("mass", mass), **_rounding(rounding)})

    @property
    def edges(self) -> NDArray[np.int64]:
        """Indices of the two atoms that each edge joins: shape (n, 2).

        Examples
        --------
        >>> import carom
        >>> carom.Molecule.capsule(2, size=0.5).edges
        array([[0, 1]])
        """
        return self._core.edges()

    @property
    def atoms(self) -> NDArray[np.float64]:
        """x, y, radius (length) and mass of each atom, about the centre of mass: shape (n, 4).

        Examples
        --------
        >>> import carom
        >>> carom.Molecule.dumbbell(0.5).atoms[:, 0]
        array([-0.5,  0.5])
        """
        return self._core.atoms()

    @property
    def mass(self) -> float:
        """Total mass.

        Examples
        --------
        >>> bent.mass
        3.0
        """
        return self._core.mass()

    @property
    def moment_of_inertia(self) -> float:
        """Moment of inertia about the centre of mass (mass · length²).

        That of shapes with sides by name and of polygons is that of a uniform body; else Σ m (r²/2
        + d²), each atom a uniform disc.

        Examples
        --------
        >>> carom.Molecule.disc(2.0, mass=3.0).moment_of_inertia
        6.0
        """
        return self._core.moment_of_inertia()

    @property
    def area(self) -> float:
        """Area of the union of the atoms, the edges, and what they enclose unless that is hollow.

        Overlaps count once (length²).

        Examples
        --------
        >>> round(carom.Molecule.dumbbell(0.5).area, 6)  # π / 2
        1.570796
        """
        return self._core.area()

    @property
    def bounding_radius(self) -> float:
        """Radius of the smallest circle about the centre of mass that holds all atoms (length).

        Examples
        --------
        >>> round(bent.bounding_radius, 6)
        1.245356
        """
        return self._core.bounding_radius()

    def exposed_arcs(self, probe: float = 0.0) -> list[ExposedArc]:
        """The arcs that a round probe from outside can touch, by atom and then by angle.

        Parameters
        ----------
        probe : float
            Radius of the probe (length, 0 or more).

        Returns
        -------
        list of ExposedArc

        Examples
        --------
        >>> import carom, math
        >>> tee = carom.Molecule.tee(0.5)
        >>> sum(arc.length for arc in tee.exposed_arcs(0.5)) == tee.exposed_perimeter(0.5)
        True
        """
        arcs = self._core.arcs(number("probe", probe)).tolist()
        return [ExposedArc(int(a), start, end, r, (x, y)) for a, start, end, r, x, y in arcs]

    def exposed_sides(self, probe: float = 0.0) -> list[ExposedSide]:
        """The straight lines that a round probe from outside can touch, by edge.

        Parameters
        ----------
        probe : float
            Radius of the probe (length, 0 or more).

        Returns
        -------
        list of ExposedSide

        Examples
        --------
        >>> import carom
        >>> square = carom.Molecule.square(1.0)
        >>> lines = sum(side.length for side in square.exposed_sides(0.5))
        >>> arcs = sum(arc.length for arc in square.exposed_arcs(0.5))
        >>> abs(lines + arcs - square.exposed_perimeter(0.5)) < 1e-12
        True
        """
        rows = self._core.sides(number("probe", probe)).tolist()
        return [
            ExposedSide(int(edge), (x, y), (to_x, to_y), normal, radius)
            for edge, x, y, to_x, to_y, normal, radius in rows
        ]

    def exposed_perimeter(self, probe: float = 0.0) -> float:
        """Length of the outer boundary of the region that the probe's centre cannot enter.

        Examples
        --------
        >>> import carom, math
        >>> math.isclose(carom.Molecule.disc(0.5).exposed_perimeter(0.25), 1.5 * math.pi)
        True
        """
        return self._core.excluded(number("probe", probe))[0]

    def excluded_area(self, probe: float = 0.0) -> float:
        """Area of that region, with pockets that the probe cannot reach (length²).

        Examples
        --------
        >>> import carom, math
        >>> math.isclose(carom.Molecule.disc(0.5).excluded_area(0.5), math.pi)
        True
        """
        return self._core.excluded(number("probe", probe))[1]

    def atom_shares(self, probe: float = 0.0) -> NDArray[np.float64]:
        """Predicted share of each atom in the contacts with probes from all directions.

        It holds for a molecule in an ideal gas that is fixed or locked in its orientation.

        Examples
        --------
        >>> import carom
        >>> carom.Molecule.dumbbell(0.5).atom_shares(0.1)
        array([0.5, 0.5])
        """
        return self._core.atom_shares(number("probe", probe))

    def edge_shares(self, probe: float = 0.0) -> NDArray[np.float64]:
        """Predicted share of each edge in these contacts; those of the atoms make it 1.

        Examples
        --------
        >>> import carom
        >>> round(float(carom.Molecule.square(4.0).edge_shares(1.0).sum()), 5)
        0.71803
        """
        return self._core.edge_shares(number("probe", probe))

    def mean_free_path(self, area: float, probe: float = 0.0) -> float:
        """Predicted mean path of one probe between two contacts with this fixed molecule.

        π (A − A_excluded) / P on a periodic box of area A, with the exposed perimeter P: exact
        where the molecule does not overlap its own images.

        Parameters
        ----------
        area : float
            Area of the box for each molecule (length²), larger than the excluded area.
        probe : float
            Radius of the probe (length, 0 or more).

        Returns
        -------
        float
            The mean path (length).

        Examples
        --------
        >>> import carom
        >>> round(carom.Molecule.disc(0.1).mean_free_path(1.0, probe=0.1), 4)
        2.1858
        """
        area, probe = number("area", area), number("probe", probe)
        excluded = self.excluded_area(probe)
        if not (math.isfinite(area) and area > excluded):
            raise MoleculeError(
                f"`area` must be finite and larger than the excluded area {excluded:g}, but is {area:g}"
            )
        return self._core.mean_free_path(area, probe)

    def at(
        self,
        x: float,
        y: float,
        *,
        angle: float = 0.0,
        velocity: ArrayLike = (0.0, 0.0),
        angular_velocity: float = 0.0,
        tags: Sequence[str] | str = (),
        locked: bool = False,
        fixed: bool = False,
    ) -> dict[str, Any]:
        """This molecule at a place, as an entry ``molecule`` of a scene.

        Parameters
        ----------
        x, y : float
            Centre of mass (length).
        angle : float
            Orientation (radians).
        velocity : array_like
            Velocity (length / time).
        angular_velocity : float
            Angular velocity (radians / time).
        tags : str or sequence of str
            Tags.
        locked : bool
            Whether the orientation is locked.
        fixed : bool
            Whether the molecule never moves.

        Examples
        --------
        >>> import carom
        >>> scene = carom.Scene(molecule=carom.Molecule.tee(0.01).at(0.5, 0.5, tags="tee"))
        >>> carom.Simulation(scene).tags
        [('tee',)]
        """
        entry: dict[str, Any] = {
            **self._description(),
            "tags": [tags] if isinstance(tags, str) else list(tags),
            "at": [number("x", x), number("y", y)],
            "orientation": number("angle", angle),
            "velocity": vectors("velocity", velocity).tolist(),
            "angular_velocity": number("angular_velocity", angular_velocity),
            "fixed": bool(fixed),
        }
        if locked:
            entry["rotation"] = "locked"
        return entry

    def _description(self) -> dict[str, Any]:
        """The keys of a scene that give its shape, size and mass."""
        return copy.deepcopy(self._keys)

    def svg(self, probe: float = 0.0) -> str:
        """A picture of the molecule with the outline that the probe can touch.

        Examples
        --------
        >>> import carom
        >>> carom.Molecule.tee(0.5).svg(0.1).startswith("<svg")
        True
        """
        return self._core.svg(number("probe", probe))

    def __len__(self) -> int:
        return len(self._core.atoms())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Molecule) and self._core.equals(other._core)

    def __hash__(self) -> int:
        return hash(self.atoms.tobytes())

    def __reduce_ex__(self, protocol: SupportsIndex) -> tuple[Any, ...]:
        return (Molecule._of, (self._keys,))

    def __repr__(self) -> str:
        shape = self._keys.get("shape")
        if shape is None:
            edges = f" and {len(self.edges)} edges" if len(self.edges) else ""
            return f"<carom.Molecule of {len(self)} atoms{edges}, mass {self.mass:g}>"
        if "size" in self._keys:
            size = self._keys["size"]
            return f"<carom.Molecule {shape}, of size {size:g} and mass {self.mass:g}>"
        radius, mass = self._keys["atom_radius"], self._keys["atom_mass"]
        return f"<carom.Molecule {shape}, atoms of radius {radius:g} and mass {mass:g}>"

    def _repr_html_(self) -> str:
        return self.svg()


def _core_of(keys: dict[str, Any]) -> _carom.MoleculeCore:
    """The molecule that these keys of a scene describe."""
    if "atom_radius" in keys:
        return _carom.MoleculeCore.named(keys["shape"], keys["atom_radius"], keys["atom_mass"])
    if keys.keys() == {"atoms"}:
        rows = [[*atom["at"], atom["radius"], atom["mass"]] for atom in keys["atoms"]]
        return _carom.MoleculeCore(rows)
    return _carom.MoleculeCore.described(keys)


def _rounding(rounding: object) -> dict[str, float]:
    """The key of the radius of corners, if it is given."""
    return {} if rounding is None else {"rounding": number("rounding", rounding)}


def _count(count: object) -> int:
    if isinstance(count, (bool, np.bool_)) or not isinstance(count, (int, np.integer)):
        raise TypeError(f"the number of atoms or sides must be an integer, but is {count!r:.60}")
    return int(count)


def _listed(name: str, entries: Any) -> list[Any]:
    try:
        # One more than the compiled part accepts: an endless iterable is refused as well.
        return list(itertools.islice(entries, _MOST_ATOMS + 1))
    except TypeError:
        raise TypeError(f"`{name}` must be a sequence of {name}, but is {entries!r:.60}") from None


def _ends(pair: Any) -> list[int]:
    entry = plain(pair)
    if not isinstance(entry, list) or len(entry) != 2:
        raise MoleculeError(f"an edge is a pair of indices of atoms, but one is {entry!r:.60}")
    return [whole("index of an atom", end, 0, 2**32 - 1) for end in entry]


def _atom(atom: Any) -> list[float]:
    entry = plain(atom)
    if isinstance(entry, dict):
        unknown = sorted(str(key) for key in entry.keys() - {"at", "radius", "mass"})
        if unknown or not {"at", "radius", "mass"} <= entry.keys():
            raise MoleculeError(f"an atom has the keys at, radius and mass, not {_words(entry)}")
        at = entry["at"]
        entry = [*(at if isinstance(at, list) else [at]), entry["radius"], entry["mass"]]
    if not isinstance(entry, list) or len(entry) != 4:
        raise MoleculeError(f"an atom is (x, y, radius, mass), but one is {entry!r:.60}")
    return [number(name, value) for name, value in zip(("x", "y", "radius", "mass"), entry)]


def _words(entry: Mapping[Any, Any]) -> str:
    """The keys of a mapping as words."""
    return ", ".join(str(key) for key in entry) or "none"


