"""Studies: a scene at many points of its parameters, with replicas, on any executor."""

from __future__ import annotations

import itertools
import os
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Union

from . import _carom
from ._errors import SceneError
from ._plain import plain, whole
from ._progress import counted
from ._replicas import Wanted, merged, prepare, run_all
from ._results import Results
from ._scene import Scene

if TYPE_CHECKING:
    from concurrent.futures import Executor

__all__ = ["Point", "Study"]

Keys = Union[str, "tuple[str, ...]"]


@dataclass(frozen=True)
class Point:
    """A point of a :class:`Study`: its values, and the merged results of its replicas.

    Attributes
    ----------
    values : dict of str to value
        The value of each varied key.
    results : Results
        Tables and figures of all replicas together.

    Examples
    --------
    >>> import carom
    >>> scene = carom.Scene(gas={"radius": 0.02, "mass": 1, "energy": 1, "count": 20}, run={"until": 1})
    >>> [point] = carom.Study(scene, {"gas.0.count": [30]}).run()
    >>> point.values, point.results.scene.tables["gas"][0]["count"]
    ({'gas.0.count': 30}, 30)
    """

    __module__ = "carom"

    values: dict[str, Any]
    results: Results


class Study:
    """A scene at all combinations of values of some keys, with replicas.

    The random numbers of a point depend on the seed of the scene and on the values of the point,
    as in ``carom sweep``: numbers, words, booleans and lists give the digits of the command. They
    depend neither on the other points nor on where and in which order the replicas run.

    Parameters
    ----------
    scene : Scene or mapping or str or path
        The scene, or what :class:`Scene` accepts.
    vary : mapping of str or tuple of str to sequence
        Values of each key. A key is a path in the scene, such as ``"gas.0.area_fraction"``; entries
        of lists are numbers from 0. A tuple of keys varies together: its values are tuples.
    replicas : int
        Number of replicas of each point, numbered from 1.
    until : float, optional
        End of each run (time), instead of ``run.until``.
    measures : sequence of str or mapping, optional
        Measures besides those of the scene; see :func:`run`.

    Raises
    ------
    SceneError
        A path leads nowhere, or the scene of a point is invalid. The message names the point.
    ValueError
        A key has no values, a tuple of values has another length than its keys, two points are
        equal, or ``box.seed`` or ``box.replica`` varies.

    Examples
    --------
    Examples of the members continue from this one.

    >>> import carom
    >>> scene = carom.Scene(gas={"radius": 0.02, "mass": 1, "temperature": 1, "count": 50})
    >>> scene = scene.replaced(run={"until": 2, "sample_interval": 0.1})
    >>> study = carom.Study(scene, {"gas.0.count": [50, 200]}, replicas=2, measures=["pressure"])
    >>> for point in study.run():
    ...     print(point.values["gas.0.count"], point.results.figures["pressure"].value > 0)
    50 True
    200 True
    """

    __module__ = "carom"
    __slots__ = ("_points", "_replicas")

    def __init__(
        self,
        scene: Scene | Mapping[str, Any] | str | os.PathLike[str],
        vary: Mapping[Keys, Sequence[Any]],
        *,
        replicas: int = 1,
        until: float | None = None,
        measures: Wanted = (),
    ) -> None:
        self._replicas = whole("replicas", replicas, 1)
        base = prepare(scene, until, measures)
        axes = [_axis(keys, values) for keys, values in vary.items()]
        self._points: list[tuple[dict[str, Any], str, Scene]] = []
        seen: set[str] = set()
        base_seed = base.tables["box"]["seed"]
        for choice in itertools.product(*axes):
            values = dict(itertools.chain.from_iterable(choice))
            if len(values) < sum(map(len, choice)):
                raise ValueError(f"`vary` has a key twice: {', '.join(k for part in choice for k, _ in part)}")
            label, seed = _carom.study_point(base_seed, values)
            if label in seen:
                raise ValueError(f"point {label} occurs twice: `replicas` gives more runs of a point")
            seen.add(label)
            self._points.append((values, label, _scene_of(base, values, label, seed)))

    @property
    def points(self) -> list[dict[str, Any]]:
        """The values of all points; the last key changes fastest.

        Examples
        --------
        >>> study.points
        [{'gas.0.count': 50}, {'gas.0.count': 200}]
        """
        return [dict(values) for values, _, _ in self._points]

    @property
    def scenes(self) -> list[Scene]:
        """The scenes of all runs: by point, and then by replica.

        Examples
        --------
        >>> [scene.tables["box"]["replica"] for scene in study.scenes]
        [1, 2, 1, 2]
        """
        numbers = range(1, self._replicas + 1)
        return [scene.replaced(replica=number) for _, _, scene in self._points for number in numbers]

    def run(
        self, *, executor: Executor | None = None, processes: int | None = None, progress: bool = False
    ) -> list[Point]:
        """Runs all replicas of all points.

        Parameters
        ----------
        executor : concurrent.futures.Executor, optional
            Where to run: a ``ProcessPoolExecutor``, ``mpi4py.futures.MPIPoolExecutor()``,
            ``dask.distributed.Client.get_executor()`` and the like. Default: threads of this
            process, which use all cores.
        processes : int, optional
            Number of runs at once without an executor. Default: all cores.
        progress : bool
            Whether to show the number of runs that have ended: by tqdm where it is installed, else
            by a line on the standard error.

        Returns
        -------
        list of Point
            The points in the order of :attr:`points`; the digits are the same with any executor.

        Raises
        ------
        CaromError
            A run fails. The message names the point and the replica; runs not begun are cancelled.

        Examples
        --------
        >>> from concurrent.futures import ThreadPoolExecutor
        >>> with ThreadPoolExecutor(2) as pool:
        ...     points = study.run(executor=pool)
        >>> points == study.run(processes=1)
        True
        """
        n = self._replicas
        labels = [f"point {label}, replica {index}" for _, label, _ in self._points for index in range(1, n + 1)]
        with counted(len(labels), "run") if progress else nullcontext() as report:
            found = run_all(self.scenes, processes, executor, labels=labels, report=report)
        return [
            Point(dict(values), merged(found[index * n : (index + 1) * n]))
            for index, (values, _, _) in enumerate(self._points)
        ]

    def __repr__(self) -> str:
        return f"<carom.Study: {len(self._points)} points, {self._replicas} replicas each>"


def _axis(keys: Keys, values: Sequence[Any]) -> list[tuple[tuple[str, Any], ...]]:
    """The choices of some keys that vary together, each as pairs of a key and its value."""
    names = (keys,) if isinstance(keys, str) else tuple(keys)
    listed = [] if isinstance(values, (str, bytes, Mapping)) else list(values)
    if not listed:
        raise ValueError(f"`vary`: {', '.join(names)} needs a sequence of at least one value, not {values!r:.60}")
    rows = [(plain(value),) if isinstance(keys, str) else tuple(plain(value)) for value in listed]
    for name, row in itertools.product(names, rows):
        if name in ("box.seed", "box.replica"):
            raise ValueError(f"`{name}` cannot vary: `replicas` gives runs with different random numbers")
        if len(row) != len(names):
            raise ValueError(f"`vary`: {', '.join(names)} needs {len(names)} values at each point, not {row!r:.60}")
    return [tuple(zip(names, row)) for row in rows]


def _scene_of(base: Scene, values: Mapping[str, Any], label: str, seed: int) -> Scene:
    tables = base.tables
    for path, value in values.items():
        _put(tables, path, value)
    tables["box"]["seed"] = seed
    try:
        scene = Scene(tables)
    except SceneError as error:
        raise SceneError(f"point {label}: {error}") from error
    scene._snapshot = base._snapshot
    return scene


def _put(tables: dict[str, Any], path: str, value: Any) -> None:
    """Changes the entry at a path, and creates missing tables."""
    place: Any = tables
    *above, last = path.split(".")
    for key in above:
        if isinstance(place, dict):
            place = place.setdefault(key, {})
        else:
            place = place[_index(place, key, path)]
    if isinstance(place, dict):
        place[last] = value
    else:
        place[_index(place, last, path)] = value


def _index(place: Any, key: str, path: str) -> int:
    if not isinstance(place, list):
        raise SceneError(f"`{path}`: {key!r} is looked for in {place!r:.40}, which has no entries")
    if not key.isdecimal() or int(key) >= len(place):
        raise SceneError(f"`{path}`: {key!r} is no entry of a list of {len(place)} entries, numbered from 0")
    return int(key)
