"""Molecules: rigid unions of discs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np

from . import _carom
from ._errors import MoleculeError
from ._plain import number, plain, vectors

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["ExposedArc", "Molecule"]

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


class Molecule:
    """A rigid union of discs, called atoms, in the frame of its centre of mass.

    Parameters
    ----------
    atoms : iterable
        For each atom, ``(x, y, radius, mass)``, or a mapping with ``at``, ``radius`` and ``mass``.
        Lengths and masses are positive, from 1e-60 to 1e60. Atoms may overlap; each adds its own
        mass.

    Raises
    ------
    MoleculeError
        A number is out of range, there is no atom, or two atoms have one centre.

    Examples
    --------
    Examples of the members continue from this one.

    >>> import carom
    >>> bent = carom.Molecule([(0, 0, 0.5, 1), (1, 0, 0.5, 1), (1, 1, 0.5, 1)])
    >>> bent.mass, round(bent.moment_of_inertia, 6)
    (3.0, 1.708333)
    """

    __module__ = "carom"
    __slots__ = ("_core", "_given", "_name")

    def __init__(self, atoms: Iterable[Sequence[float] | Mapping[str, Any]]) -> None:
        # As given: atoms moved to their centre of mass twice would differ by roundings.
        self._given = [_atom(atom) for atom in _listed(atoms)]
        self._core = _carom.MoleculeCore(self._given)
        self._name: tuple[str, float, float] | None = None

    @classmethod
    def _named(cls, shape: str, radius: float, mass: float) -> Molecule:
        molecule = cls.__new__(cls)
        radius, mass = number("radius", radius), number("mass", mass)
        molecule._core = _carom.MoleculeCore.named(shape, radius, mass)
        molecule._given = []
        molecule._name = (shape, radius, mass)
        return molecule

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
        """Σ m (r²/2 + d²) about the centre of mass, each atom a uniform disc (mass · length²).

        Examples
        --------
        >>> carom.Molecule.disc(2.0, mass=3.0).moment_of_inertia
        6.0
        """
        return self._core.moment_of_inertia()

    @property
    def area(self) -> float:
        """Area of the union of the atoms; overlaps count once (length²).

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
        """The keys of a scene that give its shape."""
        if self._name is not None:
            shape, radius, mass = self._name
            return {"shape": shape, "atom_radius": radius, "atom_mass": mass}
        return {"atoms": [{"at": [x, y], "radius": r, "mass": m} for x, y, r, m in self._given]}

    def svg(self, probe: float = 0.0) -> str:
        """A picture of the atoms with the outline that the probe can touch.

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
        return isinstance(other, Molecule) and np.array_equal(self.atoms, other.atoms)

    def __hash__(self) -> int:
        return hash(self.atoms.tobytes())

    def __reduce_ex__(self, protocol: SupportsIndex) -> tuple[Any, ...]:
        if self._name is not None:
            return (Molecule._named, self._name)
        return (Molecule, (self._given,))

    def __repr__(self) -> str:
        if self._name is not None:
            shape, radius, mass = self._name
            return f"<carom.Molecule {shape}, atoms of radius {radius:g} and mass {mass:g}>"
        return f"<carom.Molecule of {len(self)} atoms, mass {self.mass:g}>"

    def _repr_html_(self) -> str:
        return self.svg()


def _count(count: object) -> int:
    if isinstance(count, (bool, np.bool_)) or not isinstance(count, (int, np.integer)):
        raise TypeError(f"the number of atoms must be an integer, but is {count!r:.60}")
    return int(count)


def _listed(atoms: Any) -> list[Any]:
    try:
        # One more than the compiled part accepts: an endless iterable is refused as well.
        return list(itertools.islice(atoms, _MOST_ATOMS + 1))
    except TypeError:
        raise TypeError(f"`atoms` must be a sequence of atoms, but is {atoms!r:.60}") from None


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


