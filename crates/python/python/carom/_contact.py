"""Detection alone: when do two molecules in free flight first touch?"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from . import _carom
from ._molecule import Molecule
from ._plain import array, word

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["FirstContact", "first_contact"]

_UNDECIDED, _OUT_OF_RANGE = 2, 3


class FirstContact(NamedTuple):
    """First contacts of pairs of molecules; see :func:`first_contact`.

    Attributes
    ----------
    time : numpy.ndarray
        Time of the first contact; infinite if there is none.
    atoms : numpy.ndarray
        Indices of the atoms of A and B that touch, in the last axis; −1 without a contact, and for
        the body of which an edge is touched.
    is_decided : numpy.ndarray
        False where the search has been given up; ``time`` is then the time up to which there is
        no contact. The detector ``"exact"`` is always decided in practice.

    Examples
    --------
    >>> import carom
    >>> rod, disc = carom.Molecule.rod(3, radius=0.5), carom.Molecule.disc(0.5)
    >>> time, atoms, is_decided = carom.first_contact(rod, disc, [4.0, 0.0], [-1.0, 0.0])
    >>> round(float(time), 9), atoms.tolist(), bool(is_decided)
    (2.0, [2, 0], True)
    """

    time: NDArray[np.float64]
    atoms: NDArray[np.int64]
    is_decided: NDArray[np.bool_]


FirstContact.__module__ = "carom"


def first_contact(
    a: Molecule,
    b: Molecule,
    separation: ArrayLike,
    velocity: ArrayLike,
    *,
    angles: ArrayLike = (0.0, 0.0),
    angular_velocities: ArrayLike = (0.0, 0.0),
    until: ArrayLike = np.inf,
    detector: str = "exact",
) -> FirstContact:
    """The first contacts of two molecules in free flight, for many pairs at once.

    There is no periodic box. All arrays are broadcast over the pairs, without their last axis
    where it is 2.

    Parameters
    ----------
    a, b : Molecule
        The molecules.
    separation : array_like, shape (..., 2)
        From the centre of mass of A to that of B at time 0 (length).
    velocity : array_like, shape (..., 2)
        Velocity of B relative to A (length / time).
    angles : array_like, shape (..., 2)
        Orientations of A and B at time 0 (radians).
    angular_velocities : array_like, shape (..., 2)
        Angular velocities of A and B (radians / time).
    until : array_like, shape (...)
        End of the search (time, positive; may be infinite).
    detector : {"exact", "golden-secant", "fixed-step", "bounding-circles"}
        How contacts are found.

    Returns
    -------
    FirstContact

    Raises
    ------
    ValueError
        A number is not finite or out of range, or the shapes do not fit.

    Examples
    --------
    >>> import carom, numpy as np
    >>> disc = carom.Molecule.disc(0.5)
    >>> found = carom.first_contact(disc, disc, [[3.0, 0.0], [3.0, 2.0]], [-1.0, 0.0])
    >>> found.time
    array([ 2., inf])
    """
    for name, molecule in (("a", a), ("b", b)):
        if not isinstance(molecule, Molecule):
            raise TypeError(f"`{name}` must be a Molecule, but is {molecule!r:.60}")
    vectors = [
        _pairs("separation", separation),
        _pairs("velocity", velocity),
        _pairs("angles", angles),
        _pairs("angular_velocities", angular_velocities),
    ]
    limits = array("until", until, finite=False)
    if not (limits > 0).all():
        raise ValueError("`until` must be positive")
    try:
        shape = np.broadcast_shapes(*(vector.shape[:-1] for vector in vectors), limits.shape)
    except ValueError:
        shapes = [vector.shape for vector in vectors]
        raise ValueError(f"the shapes {shapes} and {limits.shape} of `until` do not fit") from None
    rows = [np.broadcast_to(vector, (*shape, 2)).reshape(-1, 2) for vector in vectors]
    motions = np.ascontiguousarray(np.concatenate(rows, axis=1))
    ends = np.ascontiguousarray(np.broadcast_to(limits, shape).reshape(-1))
    times, atoms, outcomes = _carom.first_contact(
        a._core, b._core, motions, ends, word("detector", detector)
    )
    if (outcomes == _OUT_OF_RANGE).any():
        index = int(np.flatnonzero(outcomes == _OUT_OF_RANGE)[0])
        raise ValueError(
            f"pair {index}: lengths and speeds must be at most 1e70, and speeds 0 or at least 1e-150"
        )
    decided = outcomes != _UNDECIDED
    return FirstContact(times.reshape(shape), atoms.reshape(*shape, 2), decided.reshape(shape))


def _pairs(name: str, value: ArrayLike) -> NDArray[np.float64]:
    pairs = array(name, value)
    if pairs.ndim == 0 or pairs.shape[-1] != 2:
        raise ValueError(f"`{name}` must have 2 as its last axis, but its shape is {pairs.shape}")
    return pairs
