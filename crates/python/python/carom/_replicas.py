"""Whole runs in memory, and many replicas of them on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

from . import _carom
from ._errors import CaromError, NotStationaryWarning
from ._plain import number, whole
from ._results import Results
from ._scene import Scene

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future

__all__ = ["measures", "merged", "prepare", "replicas", "run", "run_all"]

# Time between two looks for Ctrl-C (seconds).
_PAUSE = 0.1

Wanted = Sequence[Union[str, Mapping[str, Any]]]


def measures() -> dict[str, str]:
    """Names of all measures and what they measure, with their parameters.

    Examples
    --------
    >>> import carom
    >>> "pressure" in carom.measures()
    True
    """
    found = {}
    for name, summary, bodies, parameters in _carom.measure_kinds():
        of = "" if bodies == "system" else f" Of: {bodies}."
        listed = "; ".join(f"{key}: {about}" for key, about in parameters if key not in ("every", "interval"))
        found[name] = summary + "." + of + (f" Parameters: {listed}." if listed else "")
    return found


def run(
    scene: Scene | Mapping[str, Any] | str | os.PathLike[str],
    *,
    until: float | None = None,
    measures: Wanted = (),
) -> Results:
    """Runs a scene with its stages and measures in memory, as ``carom run`` does with files.

    Parameters
    ----------
    scene : Scene or mapping or str or path
        The scene, or what :class:`Scene` accepts.
    until : float, optional
        End of the run (time), instead of ``run.until`` of a scene without stages.
    measures : sequence of str or mapping, optional
        Measures besides those of the scene: names as in ``run.observe`` (``"velocities:gas"``), or
        entries ``[[measure]]``.

    Returns
    -------
    Results
        Tables and figures of all measures, with the errors of blocks of time.

    Raises
    ------
    RunError
        An entry of the scene is invalid, or the run cannot continue.

    Warns
    -----
    NotStationaryWarning
        A mean changed during its measurement.

    Examples
    --------
    >>> import carom
    >>> scene = carom.Scene(gas={"radius": 0.02, "mass": 1, "energy": 1, "count": 50})
    >>> found = carom.run(scene.replaced(run={"sample_interval": 0.1}), until=2, measures=["pressure"])
    >>> found.figures["pressure"].prediction is not None
    True
    """
    return _judged(_run(prepare(scene, until, measures), None))


def replicas(
    scene: Scene | Mapping[str, Any] | str | os.PathLike[str],
    n: int,
    *,
    until: float | None = None,
    measures: Wanted = (),
    first: int = 0,
    processes: int | None = None,
    executor: Executor | None = None,
) -> Results:
    """Runs replicas of a scene, which differ in their random numbers, and merges them.

    Parameters
    ----------
    scene, until, measures
        See :func:`run`.
    n : int
        Number of replicas.
    first : int
        Number of the first replica.
    processes : int, optional
        Number of replicas that run at once. Default: all cores. They run in threads of this
        process, which the interpreter does not delay: scripts need no ``__main__`` guard.
    executor : concurrent.futures.Executor, optional
        Where to run instead: a ``ProcessPoolExecutor``, ``dask.distributed.Client.get_executor()``,
        ``mpi4py.futures.MPIPoolExecutor()`` and the like. Scenes and results pickle.

    Returns
    -------
    Results
        The merged results; no order of the replicas changes a digit.

    Examples
    --------
    >>> import carom
    >>> scene = carom.Scene(gas={"radius": 0.02, "mass": 1, "energy": 1, "count": 50})
    >>> scene = scene.replaced(run={"sample_interval": 0.1, "until": 1})
    >>> carom.replicas(scene, 3, measures=["pressure"]).runs
    [(0, 0), (0, 1), (0, 2)]
    """
    count, begin = whole("n", n, 1), whole("first", first, 0)
    prepared = prepare(scene, until, measures)
    scenes = [prepared.replaced(replica=begin + index) for index in range(count)]
    return _judged(merged(run_all(scenes, processes, executor)))


def run_all(
    scenes: Sequence[Scene],
    processes: int | None,
    executor: Executor | None,
    *,
    labels: Sequence[str] = (),
    report: Callable[[int], object] | None = None,
) -> list[Results]:
    """Runs all scenes, and returns their results in the order of the scenes.

    ``report`` receives the number of runs that have ended since its last call. The error of a run
    begins with its label.
    """
    from concurrent.futures import ThreadPoolExecutor
    from threading import Event

    workers = os.cpu_count() or 1 if processes is None else whole("processes", processes, 1)
    if executor is not None:
        return _results([executor.submit(_run, one, None) for one in scenes], labels, report)
    stop = Event()
    with ThreadPoolExecutor(min(workers, len(scenes)), "carom") as pool:
        try:
            return _results([pool.submit(_run, one, stop.is_set) for one in scenes], labels, report)
        except BaseException:
            # Also Ctrl-C: the runs in progress end soon, the others do not begin.
            stop.set()
            raise


def _results(
    futures: list[Future[Results]], labels: Sequence[str], report: Callable[[int], object] | None
) -> list[Results]:
    from concurrent.futures import FIRST_EXCEPTION, wait

    try:
        waiting = set(futures)
        while waiting:
            # In short waits, so that Ctrl-C is not deferred.
            done, waiting = wait(waiting, _PAUSE, FIRST_EXCEPTION)
            if report is not None and done:
                report(len(done))
            if any(future.exception() for future in done):
                break
        # With an error, only the runs that have ended: one of them raises it.
        return [_result(future, labels[index : index + 1]) for index, future in enumerate(futures)
                if future not in waiting]
    except BaseException:
        for future in futures:
            future.cancel()
        raise


def _result(future: Future[Results], label: Sequence[str]) -> Results:
    try:
        return future.result()
    except CaromError as error:
        if not label:
            raise
        raise type(error)(f"{label[0]}: {error}") from error


def merged(results: Sequence[Results]) -> Results:
    """The merged results of at least one run."""
    found = results[0]
    for other in results[1:]:
        found = found + other
    return found


def _run(scene: Scene, stop: Callable[[], bool] | None) -> Results:
    return Results(_carom.run_scene(scene._text, scene._snapshot, stop))


def _judged(results: Results) -> Results:
    """Warns of what changed during its measurement."""
    changing = [figure.name for figure in results.figures.values() if figure.stationary is False]
    if changing:
        import warnings

        warnings.warn(
            f"not stationary: {', '.join(changing)} changed during the measurement; measure from later "
            'on (run.measure_from = "auto"), or longer',
            NotStationaryWarning,
            stacklevel=3,
        )
    return results


def prepare(scene: Any, until: float | None, measures: Wanted) -> Scene:
    """The scene with this end and with these measures besides its own."""
    base = scene if isinstance(scene, Scene) else Scene(scene)
    if isinstance(measures, (str, Mapping)):
        measures = [measures]
    tables = base.tables
    changes = dict(tables["run"])
    if until is not None:
        changes["until"] = number("until", until)
    names = [entry for entry in measures if isinstance(entry, str)]
    entries = [dict(entry) for entry in measures if not isinstance(entry, str)]
    changes["observe"] = [*changes["observe"], *names]
    return base.replaced(run=changes, measure=[*tables.get("measure", []), *entries])
