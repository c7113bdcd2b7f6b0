"""Reports of collisions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["COLLISION", "Collision", "of_bytes"]

# The fields of a report, in the order in which the compiled part writes them.
COLLISION = np.dtype(
    [
        ("time", "f8"),
        ("ids", "u8", 2),
        ("atoms", "i4", 2),
        ("image", "i4", 2),
        ("point", "f8", 2),
        ("normal", "f8", 2),
        ("impulse", "f8", 2),
        ("elasticity", "f8"),
        ("positions", "f8", (2, 2)),
        ("velocities_before", "f8", (2, 2)),
        ("velocities_after", "f8", (2, 2)),
        ("angles", "f8", 2),
        ("angular_velocities_before", "f8", 2),
        ("angular_velocities_after", "f8", 2),
        ("kind", "i8"),
    ]
)


def of_bytes(data: bytes | NDArray[np.uint8]) -> NDArray[np.void]:
    """Reports as a structured array."""
    if isinstance(data, bytes):
        return np.frombuffer(data, dtype=COLLISION)
    return data.view(COLLISION)


class Collision:
    """The report of one collision of two bodies, the one inserted earlier first.

    Attributes have one entry for each body, except for ``time``, ``point``, ``normal``,
    ``impulse``, ``image``, ``elasticity`` and ``kind``. The fields are those of
    :meth:`Simulation.collisions`.

    Examples
    --------
    Examples of the members continue from this one.

    >>> import carom
    >>> import numpy as np
    >>> scene = carom.Scene(gas={"radius": 0.05, "mass": 1, "energy": 1, "count": 20})
    >>> sim = carom.Simulation(scene)
    >>> hit = sim.step()
    >>> hit.time == sim.time
    True
    >>> bool(abs(hit.normal @ hit.impulse) > 0)
    True
    """

    __module__ = "carom"
    __slots__ = ("_row",)

    def __init__(self, row: NDArray[np.void]) -> None:
        self._row = row

    @property
    def time(self) -> float:
        """Time of the collision.

        Examples
        --------
        >>> hit.time > 0
        True
        """
        return float(self._row["time"])

    @property
    def ids(self) -> tuple[int, int]:
        """Numbers of the bodies.

        Examples
        --------
        >>> first, second = hit.ids
        >>> first < second < len(sim)
        True
        """
        first, second = self._row["ids"].tolist()
        return first, second

    @property
    def atoms(self) -> tuple[int, int]:
        """Indices of the atoms that touched; −1 for the face of a wall, and where none touch.

        Examples
        --------
        >>> hit.atoms
        (0, 0)
        """
        first, second = self._row["atoms"].tolist()
        return first, second

    @property
    def kind(self) -> int:
        """0 for a contact, 1 where a bond reaches a bound, 2 where two discs reach a step of their
        well.

        Examples
        --------
        >>> hit.kind
        0
        """
        return int(self._row["kind"])

    @property
    def impulse(self) -> NDArray[np.float64]:
        """Impulse on the second body; the first receives its opposite (mass · length / time).

        Examples
        --------
        >>> hit.impulse.shape
        (2,)
        """
        return self._numbers("impulse")

    @property
    def point(self) -> NDArray[np.float64]:
        """Point of contact, in the image of the first body (length).

        Examples
        --------
        >>> radius = sim.radii[hit.ids[0]]
        >>> distance = np.linalg.norm(hit.point - hit.positions[0])
        >>> bool(abs(distance - radius) < 1e-12)
        True
        """
        return self._numbers("point")

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit vector from the first body to the second at the point of contact.

        Examples
        --------
        >>> bool(abs(np.linalg.norm(hit.normal) - 1) < 1e-12)
        True
        """
        return self._numbers("normal")

    @property
    def elasticity(self) -> float:
        """Coefficient of restitution of the contact.

        Examples
        --------
        >>> hit.elasticity
        1.0
        """
        return float(self._row["elasticity"])

    @property
    def image(self) -> tuple[int, int]:
        """Box of the second body, relative to that of the first (boxes).

        Examples
        --------
        >>> all(box in (-1, 0, 1) for box in hit.image)
        True
        """
        x, y = self._row["image"].tolist()
        return x, y

    @property
    def positions(self) -> NDArray[np.float64]:
        """Centres of mass (length), shape (2, 2).

        Examples
        --------
        >>> hit.positions.shape
        (2, 2)
        """
        return self._numbers("positions")

    @property
    def angles(self) -> NDArray[np.float64]:
        """Orientations, from −π to π (radians), shape (2,).

        Examples
        --------
        >>> hit.angles.shape
        (2,)
        """
        return self._numbers("angles")

    @property
    def velocities_before(self) -> NDArray[np.float64]:
        """Velocities before the collision (length / time), shape (2, 2).

        Examples
        --------
        >>> approach = hit.velocities_before[0] - hit.velocities_before[1]
        >>> bool(approach @ hit.normal > 0)
        True
        """
        return self._numbers("velocities_before")

    @property
    def velocities_after(self) -> NDArray[np.float64]:
        """Velocities after the collision (length / time), shape (2, 2).

        Examples
        --------
        >>> change = hit.velocities_after[1] - hit.velocities_before[1]
        >>> bool(np.allclose(change, hit.impulse))  # The mass is 1.
        True
        """
        return self._numbers("velocities_after")

    @property
    def angular_velocities_before(self) -> NDArray[np.float64]:
        """Angular velocities before the collision (radians / time), shape (2,).

        Examples
        --------
        >>> hit.angular_velocities_before.shape
        (2,)
        """
        return self._numbers("angular_velocities_before")

    @property
    def angular_velocities_after(self) -> NDArray[np.float64]:
        """Angular velocities after the collision (radians / time), shape (2,).

        Examples
        --------
        >>> hit.angular_velocities_after.shape
        (2,)
        """
        return self._numbers("angular_velocities_after")

    def _numbers(self, name: str) -> NDArray[np.float64]:
        return np.array(self._row[name], dtype=np.float64)

    def __repr__(self) -> str:
        first, second = self.ids
        return f"<carom.Collision of bodies {first} and {second} at time {self.time:g}>"
