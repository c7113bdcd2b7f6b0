"""Exceptions of the package. Their words are those of the command ``carom``."""

from __future__ import annotations

__all__ = [
    "BusyError",
    "CaromError",
    "CheckpointError",
    "EditError",
    "MeasureError",
    "MoleculeError",
    "NotStationaryWarning",
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
    """A molecule is invalid: a number is out of range, or two atoms coincide.

    Examples
    --------
    >>> import carom
    >>> carom.Molecule([(0, 0, 1, 1), (0, 0, 2, 1)])
    Traceback (most recent call last):
        ...
    carom.MoleculeError: atoms 0 and 1 of the molecule have the same centre
    """

    __module__ = "carom"


class MeasureError(CaromError, ValueError):
    """A measure is unknown, has invalid parameters or bodies, or results cannot be merged.

    Examples
    --------
    >>> import carom
    >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
    >>> try:
    ...     sim.measure("presure", every=0.1)
    ... except carom.MeasureError as error:
    ...     print("did you mean `pressure`?" in str(error))
    True
    """

    __module__ = "carom"


class EditError(CaromError, ValueError):
    """An edit is refused; it has changed nothing.

    Examples
    --------
    >>> import carom
    >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
    >>> sim.remove([20])
    Traceback (most recent call last):
        ...
    carom.EditError: body 20 is not, or no longer, in the system
    """

    __module__ = "carom"


class CheckpointError(CaromError, ValueError):
    """A file or folder is no checkpoint or run, is damaged, or cannot be read or written.

    Examples
    --------
    >>> import carom, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "checkpoint"
    >>> _ = path.write_bytes(b"nothing of ours")
    >>> try:
    ...     carom.load(path)
    ... except carom.CheckpointError as error:
    ...     print("cannot load" in str(error))
    True
    """

    __module__ = "carom"


class RunError(CaromError, RuntimeError):
    """A run cannot continue; the simulation remains at the time at which it stopped.

    Examples
    --------
    >>> import carom
    >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
    >>> sim.run(until=float("inf"))
    Traceback (most recent call last):
        ...
    carom.RunError: a run must end at a finite time of at most 1e300, not at inf
    """

    __module__ = "carom"


class BusyError(RunError):
    """Another thread, or a callback, uses a simulation that is running.

    Examples
    --------
    >>> import carom
    >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
    >>> @sim.on_collision()
    ... def run_again(hit):
    ...     sim.run(until=2)
    >>> sim.run(until=1)
    Traceback (most recent call last):
        ...
    carom.BusyError: the simulation is running: wait until `run` returns, or use `copy()` before it
    """

    __module__ = "carom"


class NotStationaryWarning(UserWarning):
    """A mean changed during its measurement, so that its error is not that of a mean at rest.

    Examples
    --------
    >>> import carom
    >>> import warnings
    >>> warnings.simplefilter("ignore", carom.NotStationaryWarning)  # of a gas that is to cool
    """

    __module__ = "carom"
