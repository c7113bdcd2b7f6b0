"""Exceptions of the package. Their words are those of the command ``carom``."""

from __future__ import annotations

__all__ = [
    "BusyError",
    "CaromError",
    "CheckpointError",
    "EditError",
    "MeasureError",
    "MoleculeError",
    "RunError",
    "SceneError",
]


class CaromError(Exception):
    """Base class of all exceptions of this package.

    Examples
    --------
    >>> import carom
    >>> try:
    ...     carom.Scene(gas={"raduis": 0.01})
    ... except carom.CaromError as error:
    ...     print("did you mean" in str(error))
    True
    """

    __module__ = "carom"


class SceneError(CaromError, ValueError):
    """A scene is invalid: the message names the entry, the value and the allowed range.

    Examples
    --------
    >>> import carom
    >>> carom.Simulation(carom.Scene(gas={"radius": -1.0, "mass": 1.0, "energy": 1.0, "count": 5}))
    Traceback (most recent call last):
        ...
    carom.SceneError: gas[0]: the radius of an atom must be positive, finite and between 1e-60 and 1e60, but is -1.0
    """

    __module__ = "carom"


class MoleculeError(CaromError, ValueError):
    """A molecule is invalid: a number is out of range, or two atoms coincide."""

    __module__ = "carom"


class MeasureError(CaromError, ValueError):
    """A measure is unknown, has invalid parameters or bodies, or results cannot be merged."""

    __module__ = "carom"


class EditError(CaromError, ValueError):
    """An edit is refused; it has changed nothing."""

    __module__ = "carom"


class CheckpointError(CaromError, ValueError):
    """A file or folder is no checkpoint or run, is damaged, or cannot be read or written."""

    __module__ = "carom"


class RunError(CaromError, RuntimeError):
    """A run cannot continue; the simulation remains at the time at which it stopped."""

    __module__ = "carom"


class BusyError(RunError):
    """Another thread, or a callback, uses a simulation that is running."""

    __module__ = "carom"
