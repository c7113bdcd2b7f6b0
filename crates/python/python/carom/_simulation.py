"""Simulations: a system of molecules at some time, and what is measured while it moves."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar, Union

import numpy as np

from . import _carom
from ._collisions import Collision, of_bytes
from ._errors import MeasureError
from ._exports import to_ase, to_freud, to_gsd
from ._html import Html, frame
from ._molecule import Molecule
from ._plain import array, ids, is_mask, masked, number, pixels, plain, read_only, vectors, word
from ._progress import Progress
from ._results import Figure, Results, Table
from ._scene import Scene

__all__ = ["Measure", "Simulation", "load"]

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]
    Ids = NDArray[np.uint64]
    Which = Union[str, ArrayLike, None]
Callback = TypeVar("Callback", bound=Callable[[Collision], object])


class Measure:
    """A measure of a simulation; its results can be read at any time.

    Examples
    --------
    Examples of the members continue from this one.

    >>> import carom
    >>> scene = carom.Scene(gas={"radius": 0.02, "mass": 1, "energy": 1, "count": 50})
    >>> sim = carom.Simulation(scene)
    >>> pressure = sim.measure("pressure", every=0.1)
    >>> sim.run(until=2)
    >>> pressure.figures["pressure"].unit
    'mass/time²'
    """

    __module__ = "carom"
    __slots__ = ("_core", "_index", "kind")

    def __init__(self, core: _carom.Core, index: int, kind: str) -> None:
        self._core, self._index = core, index
        self.kind = kind

    @property
    def results(self) -> Results:
        """Tables and figures so far; ``+`` merges those of several replicas.

        Examples
        --------
        >>> list(pressure.results.figures)[0]
        'pressure'
        """
        return Results(self._core.results(self._index))

    @property
    def tables(self) -> dict[str, Table]:
        """Tables so far, by name.

        Examples
        --------
        >>> list(pressure.tables)
        ['pressure']
        """
        return self.results.tables

    @property
    def table(self) -> Table:
        """The first table.

        Examples
        --------
        >>> pressure.table.abscissa
        'time'
        """
        tables = self.tables
        if not tables:
            raise MeasureError(f"the measure '{self.kind}' has no table so far")
        return next(iter(tables.values()))

    @property
    def figures(self) -> dict[str, Figure]:
        """Figures so far, by name.

        Examples
        --------
        >>> pressure.figures["pressure"].value > 0
        True
        """
        return self.results.figures

    def stop(self) -> None:
        """Ends the measure; it keeps its results.

        Examples
        --------
        >>> pressure.stop()
        >>> sim.run(until=3)
        >>> float(pressure.table["time"].max())
        2.0
        """
        self._core.end_measure(self._index)

    def __repr__(self) -> str:
        return f"<carom.Measure {self.kind}>"

    def _repr_html_(self) -> str:
        return self.results._repr_html_()


class Simulation:
    """A system of rigid molecules in a periodic box, at some time.

    Bodies are in the order of their insertion in all arrays: single molecules, bumpers and walls
    of the scene, then its gases, then bodies added later. Arrays are new copies at the present
    time, which cannot be written to: assigning to them would not change the simulation
    (``np.array(sim.positions)`` is a copy that can). A body keeps its number (``ids``) when others
    are removed.

    Two bodies that touch at several points at one instant get one joint impulse. Contacts of one
    body with several others at one instant are resolved one after the other, in the order of the
    numbers of their bodies.

    Parameters
    ----------
    scene : Scene or mapping or str or path
        The scene, or what :class:`Scene` accepts.
    detector : {"exact", "golden-secant", "fixed-step", "bounding-circles"}, optional
        How contacts are found, instead of the scene's ``[method]``.
    scheduler : {"cells", "heap"}, optional
        How events are ordered, instead of the scene's ``[method]``.
    threads : int, optional
        Threads of a run. Used where the box is divided into tiles: ``tiles`` in the table
        ``method`` of a scene says from which size on. Results do not depend on it to the bit.
        Default: 1, since :func:`replicas` runs one system on each core.

    Raises
    ------
    SceneError
        The scene cannot be built.

    Examples
    --------
    Examples of the members continue from this one.

    >>> import carom
    >>> import numpy as np
    >>> scene = carom.Scene(gas={"radius": 0.01, "mass": 1, "energy": 1, "count": 100, "tags": ["gas"]})
    >>> sim = carom.Simulation(scene)
    >>> sim.run(until=1.0)
    >>> sim.time, sim.positions.shape
    (1.0, (100, 2))
    """

    __module__ = "carom"

    def __init__(
        self,
        scene: Scene | Mapping[str, Any] | str | os.PathLike[str],
        *,
        detector: str | None = None,
        scheduler: str | None = None,
        threads: int | None = None,
    ) -> None:
        if threads is not None and not 1 <= operator.index(threads) <= 65535:
            raise ValueError(f"`threads` must be from 1 to 65535, but is {threads!r}")
        if not isinstance(scene, Scene):
            scene = Scene(scene)
        if detector is not None or scheduler is not None:
            given = {"detector": detector, "scheduler": scheduler}
            old = scene.tables.get("method", {})
            scene = scene.replaced(method={**old, **{k: v for k, v in given.items() if v is not None}})
        core = _carom.Core(scene._text, scene._snapshot)
        if threads is not None:
            core.set_threads(operator.index(threads))
        self._begin(core)

    def _begin(self, core: _carom.Core) -> None:
        self._core = core
        self._callbacks: list[tuple[list[str], Callable[[Collision], object]]] = []
        self._measures: list[Measure] = []

    @classmethod
    def _of(cls, core: _carom.Core) -> Simulation:
        simulation = cls.__new__(cls)
        simulation._begin(core)
        return simulation

    # ------------------------------------------------------------------ state

    @property
    def time(self) -> float:
        """The present time.

        Examples
        --------
        >>> sim.time
        1.0
        """
        return self._core.time()

    @property
    def scene(self) -> Scene:
        """The scene, with the elasticity in force; its bodies are those at the start.

        Examples
        --------
        >>> sim.scene.tables["box"]["sides"]
        [1.0, 1.0]
        """
        return Scene._of(self._core.scene(), None)

    @property
    def box(self) -> tuple[float, float]:
        """Sides of the periodic box (length).

        Examples
        --------
        >>> sim.box
        (1.0, 1.0)
        """
        x, y = self._core.sides()
        return x, y

    def __len__(self) -> int:
        return self._core.len()

    @property
    def positions(self) -> Floats:
        """Centres of mass in the box (length), shape (n, 2).

        Examples
        --------
        >>> x, y = sim.positions.T
        >>> bool((0 <= x).all() and (x < 1).all())
        True
        """
        return self._array("positions")

    @property
    def unwrapped_positions(self) -> Floats:
        """Centres of mass without periodic jumps since the start (length), shape (n, 2).

        Examples
        --------
        >>> bool((sim.unwrapped_positions % 1 - sim.positions < 1e-12).all())
        True
        """
        return self._array("unwrapped_positions")

    @property
    def velocities(self) -> Floats:
        """Velocities of the centres of mass (length / time), shape (n, 2).

        Examples
        --------
        >>> sim.velocities.shape
        (100, 2)
        """
        return self._array("velocities")

    @property
    def angles(self) -> Floats:
        """Orientations, from −π to π (radians), shape (n,).

        Examples
        --------
        >>> bool((abs(sim.angles) <= np.pi).all())
        True
        """
        return self._array("angles")

    @property
    def angular_velocities(self) -> Floats:
        """Angular velocities (radians / time), shape (n,).

        Examples
        --------
        >>> sim.angular_velocities.shape
        (100,)
        """
        return self._array("angular_velocities")

    @property
    def radii(self) -> Floats:
        """Radii of the bounding circles; for a wall, half its thickness (length), shape (n,).

        Examples
        --------
        >>> sim.radii[:2]
        array([0.01, 0.01])
        """
        return self._array("radii")

    @property
    def masses(self) -> Floats:
        """Masses of the bodies, of a fixed molecule too; infinite for walls, shape (n,).

        Examples
        --------
        >>> sim.masses[:2]
        array([1., 1.])
        """
        return self._array("masses")

    @property
    def energies(self) -> Floats:
        """Kinetic energies (mass · length² / time²), shape (n,).

        Examples
        --------
        >>> bool(abs(sim.energies.sum() - sim.energy) < 1e-10)
        True
        """
        return self._array("energies")

    @property
    def fixed(self) -> NDArray[np.bool_]:
        """Whether each body is fixed, shape (n,).

        Examples
        --------
        >>> bool(sim.fixed.any())
        False
        """
        fixed: NDArray[np.bool_] = self._core.array("fixed")
        return fixed

    @property
    def locked(self) -> NDArray[np.bool_]:
        """Whether each body does not turn, shape (n,).

        Examples
        --------
        >>> bool(sim.locked.any())
        False
        """
        locked: NDArray[np.bool_] = self._core.array("locked")
        return locked

    @property
    def ids(self) -> Ids:
        """Numbers of the bodies, ascending; never reused, shape (n,).

        Examples
        --------
        >>> sim.ids[:3]
        array([0, 1, 2], dtype=uint64)
        """
        numbers: Ids = self._core.array("ids")
        return numbers

    @property
    def tags(self) -> list[tuple[str, ...]]:
        """Tags of each body.

        Examples
        --------
        >>> sim.tags[0]
        ('gas',)
        """
        return self._core.tags()

    def mask(self, tag: str) -> NDArray[np.bool_]:
        """Whether each body carries a tag, for indexing the arrays.

        Examples
        --------
        >>> import carom
        >>> scene = carom.Scene(
        ...     molecule=carom.Molecule.tee(0.01).at(0.5, 0.5, tags="tee"),
        ...     gas={"radius": 0.01, "mass": 1, "energy": 1, "count": 9},
        ... )
        >>> sim = carom.Simulation(scene)
        >>> sim.positions[sim.mask("tee")]
        array([[0.5, 0.5]])
        """
        return np.isin(self.ids, self._core.ids_of(word("tag", tag)), assume_unique=True)

    @property
    def energy(self) -> float:
        """Kinetic energy of all bodies (mass · length² / time²).

        Examples
        --------
        >>> round(sim.energy, 9)
        100.0
        """
        return self._core.totals()[0]

    @property
    def booked_energy(self) -> dict[str, float]:
        """The kinetic energy by its sources (mass · length² / time²): ``initial`` − ``lost`` in contacts
        + ``put_in`` by edits + ``heat`` and ``work`` of walls + ``fallen``, the work of gravity +
        ``sheared``, that of a shear + ``wells``, gained at the steps of wells − ``dragged``.

        Examples
        --------
        >>> booked = sim.booked_energy
        >>> round(booked["initial"] - booked["lost"] + booked["put_in"], 9)
        100.0
        """
        names = ("initial", "lost", "put_in", "heat", "work", "fallen", "sheared", "wells", "dragged")
        return dict(zip(names, self._core.totals()[4]))

    @property
    def momentum(self) -> Floats:
        """Total momentum (mass · length / time), shape (2,).

        Examples
        --------
        >>> sim.momentum.shape
        (2,)
        """
        return read_only(self._core.totals()[1])

    @property
    def temperature(self) -> float | None:
        """kT relative to the centre of mass (mass · length² / time²); None without motion.

        Examples
        --------
        >>> 0 < sim.temperature < 1.1
        True
        """
        return self._core.totals()[2]

    @property
    def collision_count(self) -> int:
        """Number of collisions so far.

        Examples
        --------
        >>> sim.collision_count > 0
        True
        """
        return self._core.totals()[3]

    @property
    def overlapping_pairs(self) -> int:
        """Number of pairs that overlap by more than rounding; 0 with the exact detector.

        Examples
        --------
        >>> sim.overlapping_pairs
        0
        """
        return self._core.overlaps()

    def _array(self, name: str) -> Floats:
        values: Floats = self._core.array(name)
        return values

    # -------------------------------------------------------------------- run

    def run(self, until: float, *, progress: bool = False) -> None:
        """Runs to a time.

        Other Python threads run meanwhile; Ctrl-C stops the run between two events, and it can be
        continued.

        Parameters
        ----------
        until : float
            End of the run (time), from the present to 1e300.
        progress : bool
            Whether to draw a bar, in a terminal or notebook.

        Raises
        ------
        RunError
            ``until`` is past or not finite, or the run cannot continue; the simulation remains at
            the time at which it stopped.
        BusyError
            The simulation is already running, in another thread or below a callback.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> sim.run(until=0.5)
        >>> sim.time
        0.5
        """
        end = number("until", until)
        callbacks = [(between, _receiver(callback)) for between, callback in self._callbacks]
        if not progress:
            self._core.run(end, None, callbacks)
            return
        bar = Progress(self.time, end)
        try:
            self._core.run(end, bar, callbacks)
        finally:
            bar.close(self.time, self.collision_count)

    def sample(
        self, function: Callable[[Simulation], object], *, every: float, until: float
    ) -> NDArray[Any]:
        """Runs to a time, and calls a function of the simulation at equal intervals.

        Parameters
        ----------
        function : callable
            Gets the simulation, and returns a number, or an array of the same shape each time; it may
            edit the simulation, but not run it.
        every : float
            Time between two calls; the first is one interval from now.
        until : float
            End of the run (time).

        Returns
        -------
        numpy.ndarray
            What the function has returned, one row a call; :func:`estimate` gives its mean.

        Raises
        ------
        RunError
            See :meth:`run`.
        ValueError
            ``every`` is not positive, or there would be more than 10⁸ calls.

        Examples
        --------
        >>> import carom
        >>> import numpy as np
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> series = sim.sample(lambda sim: np.abs(sim.velocities[:, 0]).mean(), every=0.1, until=2.0)
        >>> len(series), carom.estimate(series).standard_error > 0
        (20, True)
        """
        start, spacing, end = self.time, number("every", every), number("until", until)
        if not spacing > 0:
            raise ValueError(f"`every` must be positive, but is {spacing}")
        calls = (end - start) / spacing * (1 + 1e-12)
        if calls > 1e8:
            raise ValueError(f"`every`: there would be {calls:.3g} calls; at most 1e8 are allowed")
        found: list[NDArray[Any]] = []
        for call in range(1, int(max(calls, 0.0)) + 1):
            self.run(min(start + call * spacing, end))
            value = np.asarray(function(self))
            if found and value.shape != found[0].shape:
                raise ValueError(f"`function` has returned shape {value.shape} after {found[0].shape}")
            found.append(value)
        self.run(end)
        return np.asarray(found)

    def step(self, until: float | None = None) -> Collision | None:
        """Runs through the next collision.

        Parameters
        ----------
        until : float, optional
            Latest time. Default: the time in which the fastest body crosses the box 1000 times.

        Returns
        -------
        Collision or None
            Its report; None if there is none before ``until``, which is then the present time.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> hit = sim.step()
        >>> hit.time == sim.time and len(hit.ids) == 2
        True
        """
        if until is None:
            fastest = float(np.linalg.norm(self.velocities, axis=1).max(initial=0.0))
            until = self.time + (1000 * max(self.box) / fastest if fastest > 0 else 0.0)
        report = self._core.step(number("until", until))
        return None if report is None else Collision(of_bytes(report)[0])

    def collisions(self, until: float, *, between: str | Sequence[str] = ()) -> NDArray[np.void]:
        """Runs to a time and returns all collisions.

        Parameters
        ----------
        until : float
            End of the run (time).
        between : str or sequence of str, optional
            One tag: collisions with bodies of this tag; two tags: those between them.

        Returns
        -------
        numpy.ndarray
            A structured array with the fields ``time``; ``ids`` and ``atoms`` of the two bodies (−1
            for the face of a wall); ``image`` of the second body (boxes); ``point`` of contact in
            the image of the first body, ``normal`` from the first to the second, ``impulse`` on
            the second; ``elasticity``; and for each body ``positions``, ``angles`` (radians),
            ``velocities_before`` and ``_after``, ``angular_velocities_before`` and ``_after``. A
            row has 240 bytes.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> hits = sim.collisions(until=1.0)
        >>> len(hits) == sim.collision_count
        True
        """
        return of_bytes(self._core.collisions(number("until", until), _between(between)))

    def on_collision(self, *, between: str | Sequence[str] = ()) -> Callable[[Callback], Callback]:
        """Decorates a function that is called after each collision of a run.

        The function may read and edit the simulation, but not run it. An exception in it ends the
        run at this collision. Such a run is slower; :meth:`collisions` is for all collisions.

        Parameters
        ----------
        between : str or sequence of str, optional
            One tag: collisions with bodies of this tag; two tags: those between them.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> times = []
        >>> @sim.on_collision()
        ... def log(hit):
        ...     times.append(hit.time)
        >>> sim.run(until=0.5)
        >>> len(times) == sim.collision_count
        True
        >>> sim.off_collision(log)
        """
        tags = _between(between)

        def add(callback: Callback) -> Callback:
            if not callable(callback):
                raise TypeError(f"a function is expected, not {callback!r:.60}")
            self._callbacks.append((tags, callback))
            return callback

        return add

    def off_collision(self, callback: Callable[[Collision], object]) -> None:
        """Removes a function that :meth:`on_collision` has decorated.

        Examples
        --------
        >>> log = sim.on_collision(between="gas")(print)
        >>> sim.off_collision(log)
        >>> sim.run(until=1.1)  # prints nothing
        """
        self._callbacks = [entry for entry in self._callbacks if entry[1] is not callback]

    # --------------------------------------------------------------- measures

    def measure(
        self,
        kind: str,
        of: str | Sequence[str] | None = None,
        *,
        every: float | None = None,
        name: str | None = None,
        **parameters: float | str | Sequence[float],
    ) -> Measure:
        """Measures a quantity from now on.

        Parameters
        ----------
        kind : str
            A name that :func:`measures` lists, such as ``"velocities"`` or ``"correlation"``.
        of : str or sequence of str, optional
            Tag of the bodies, or two tags for a measure of pairs. Default: all bodies.
        every : float, optional
            Time between samples. Default: ``run.sample_interval`` of the scene.
        name : str, optional
            Name in tables and figures. Default: the tag.
        **parameters : float, str or sequence of float
            Parameters of the measure; a point is two numbers.

        Returns
        -------
        Measure

        Raises
        ------
        MeasureError
            The measure is unknown, a parameter is invalid, or no body carries the tag.

        Examples
        --------
        >>> import carom
        >>> scene = carom.Scene(gas={"radius": 0.02, "mass": 1, "energy": 1, "count": 60, "tags": ["gas"]})
        >>> sim = carom.Simulation(scene)
        >>> shells = sim.measure("pair-distribution", of="gas", every=0.05, bins=20)
        >>> sim.run(until=1.0)
        >>> shells.table.units["distance"]
        'length'
        """
        kind = word("kind", kind)
        if every is None:
            every = self.scene.tables["run"]["sample_interval"]
        for key in ("every", "interval"):
            if key in parameters:
                raise MeasureError(f"'{key}' is given as `every`, a time")
        given = [(key, _parameter(key, value)) for key, value in parameters.items()]
        tags = None if of is None else ",".join(_between(of))
        label = None if name is None else word("name", name)
        index = self._core.measure(kind, tags, label, number("every", every), given)
        measure = Measure(self._core, index, kind)
        self._measures.append(measure)
        return measure

    @property
    def measures(self) -> list[Measure]:
        """The measures so far, with those of a loaded checkpoint first.

        Examples
        --------
        >>> pressure = sim.measure("pressure", every=0.1)
        >>> sim.measures
        [<carom.Measure pressure>]
        """
        return list(self._measures)

    # ------------------------------------------------------------------ edits

    def _which(self, which: Which) -> Ids:
        if which is None:
            return self.ids[~self.fixed]
        if isinstance(which, str):
            return self._core.ids_of(which)
        if is_mask(which):
            return masked("which", which, self.ids)
        return ids("which", which)

    def add(
        self,
        molecule: Molecule,
        at: ArrayLike,
        *,
        angle: ArrayLike = 0.0,
        velocity: ArrayLike = (0.0, 0.0),
        angular_velocity: ArrayLike = 0.0,
        tags: str | Sequence[str] = (),
        locked: bool = False,
        fixed: bool = False,
    ) -> Ids:
        """Adds copies of a molecule, all or none.

        Parameters
        ----------
        molecule : Molecule
            The molecule.
        at : array_like, shape (2,) or (n, 2)
            Centres of mass (length).
        angle, angular_velocity : array_like, shape () or (n,)
            Orientations (radians) and angular velocities (radians / time).
        velocity : array_like, shape (2,) or (n, 2)
            Velocities (length / time).
        tags : str or sequence of str
            Tags of all copies.
        locked, fixed : bool
            Whether they do not turn, or never move.

        Returns
        -------
        numpy.ndarray
            Numbers of the new bodies.

        Raises
        ------
        EditError
            A copy overlaps a body, or a number is out of range; nothing has changed.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation(carom.Scene())
        >>> sim.add(carom.Molecule.disc(0.1), [[0.2, 0.2], [0.7, 0.7]], velocity=[1.0, 0.0])
        array([0, 1], dtype=uint64)
        """
        if not isinstance(molecule, Molecule):
            raise TypeError(f"`molecule` must be a Molecule, but is {molecule!r:.60}")
        places = vectors("at", at).reshape(-1, 2)
        count = len(places)
        rows = np.empty((count, 6))
        rows[:, :2] = places
        rows[:, 2] = _spread("angle", angle, (count,))
        rows[:, 3:5] = _spread("velocity", vectors("velocity", velocity), (count, 2))
        rows[:, 5] = _spread("angular_velocity", angular_velocity, (count,))
        entry = molecule.at(0.0, 0.0, tags=tags, locked=locked, fixed=fixed)
        text = _carom.scene_of({"molecule": [plain(entry)]})
        return self._core.add(text, rows.reshape(-1))

    def add_wall(
        self,
        *,
        x: float | None = None,
        y: float | None = None,
        ends: ArrayLike | None = None,
        radius: float = 0.0,
        temperature: float | None = None,
        motion: Mapping[str, Any] | None = None,
        tags: str | Sequence[str] = (),
    ) -> int:
        """Adds a straight wall: a line across the box at ``x`` or ``y``, or a segment.

        Parameters
        ----------
        x, y : float, optional
            The wall is the line of all points with this x or y (length).
        ends : array_like, shape (2, 2), optional
            End points of a segment (length).
        radius : float
            Half the thickness (length).
        temperature : float, optional
            kT of a wall from which bodies leave with random velocities (mass · length² / time²).
        motion : mapping, optional
            Motion of the wall: ``velocity`` (length / time), ``turn`` (radians / time) and
            ``about``, the pivot (length); or ``amplitude`` (length), ``frequency`` (radians / time)
            and ``phase`` (radians); or ``times`` and ``places``. At rest by default.
        tags : str or sequence of str
            Tags.

        Returns
        -------
        int
            Number of the wall.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation(carom.Scene())
        >>> sim.add_wall(x=0.0)
        0
        """
        entry: dict[str, Any] = {
            "x": None if x is None else number("x", x),
            "y": None if y is None else number("y", y),
            "radius": number("radius", radius),
            "temperature": None if temperature is None else number("temperature", temperature),
            "motion": None if motion is None else dict(motion),
            "tags": _between(tags),
        }
        if ends is not None:
            points = vectors("ends", ends)
            if points.shape != (2, 2):
                raise ValueError(f"`ends` must be two points [x, y], but is {points.tolist()!r:.60}")
            entry["from"], entry["to"] = points.tolist()
        return self._core.add_wall(_carom.scene_of({"wall": [entry]}))

    def move_wall(self, which: Which, motion: Mapping[str, Any] | None = None) -> None:
        """Replaces the motion of walls from now on.

        Parameters
        ----------
        which : str or array_like of int or bool
            A tag, numbers of walls (see :attr:`ids`), or a mask of all bodies.
        motion : mapping, optional
            As that of :meth:`add_wall`. At rest by default.

        Raises
        ------
        EditError
            A body is no wall, or the motion is out of range; nothing has changed.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"wall": [{"x": 0.25, "tags": ["piston"]}]})
        >>> sim.move_wall("piston", {"amplitude": [0.125, 0], "frequency": 2})
        >>> sim.run(until=0.25)
        >>> round(float(sim.positions[0, 0]), 6)
        0.309928
        >>> sim.move_wall("piston")
        >>> float(sim.velocities[0, 0])
        0.0
        """
        if which is None:
            raise TypeError("`which` must be a tag or numbers of walls")
        entry = {"x": 0.0, "motion": {} if motion is None else dict(motion)}
        self._core.move_walls(self._which(which), _carom.scene_of({"wall": [entry]}))

    def push_piston(self, which: Which, force: float) -> None:
        """Replaces the force on pistons from now on.

        Parameters
        ----------
        which : str or array_like of int or bool
            A tag, numbers of pistons (see :attr:`ids`), or a mask of all bodies.
        force : float
            Constant force along the axis, upwards if positive (mass × length / time²).

        Raises
        ------
        EditError
            A body is no piston, or the force is out of range.

        Examples
        --------
        >>> import carom
        >>> piston = {"x": 0.5, "mass": 2.0, "stops": [0.25, 0.75], "tags": ["piston"]}
        >>> sim = carom.Simulation({"piston": [piston]})
        >>> sim.push_piston("piston", -0.5)
        >>> sim.run(until=1.0)
        >>> float(sim.positions[0, 0]), float(sim.velocities[0, 0])
        (0.375, -0.25)
        """
        if which is None:
            raise TypeError("`which` must be a tag or numbers of pistons")
        self._core.push_pistons(self._which(which), force)

    def remove(self, which: Which) -> None:
        """Removes bodies.

        Parameters
        ----------
        which : str or array_like of int or bool
            A tag, numbers of bodies (see :attr:`ids`), or a mask of all bodies.

        Raises
        ------
        EditError
            A body is not in the system, or no body carries the tag; nothing has changed.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> sim.remove([0, 3, 4])
        >>> len(sim)
        17
        >>> sim.remove(sim.positions[:, 0] > 0.5)
        >>> bool(sim.positions[:, 0].max() <= 0.5)
        True
        """
        if which is None:
            raise TypeError("`which` must be a tag or numbers of bodies")
        self._core.remove(self._which(which))

    def set_energy(self, energy: ArrayLike, which: Which = None) -> None:
        """Scales the motion of bodies to kinetic energies.

        Parameters
        ----------
        energy : array_like, shape () or (n,)
            Energy of each body (mass · length² / time², positive).
        which : str or array_like of int or bool, optional
            A tag, numbers of bodies, or a mask. Default: all that move.

        Raises
        ------
        EditError
            A body is at rest, fixed, or not in the system; nothing has changed.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> sim.set_energy(3.0, [7])
        >>> float(round(sim.energies[7], 12))
        3.0
        """
        energies = array("energy", energy)
        chosen = self._which(which)
        self._core.set_energy(chosen, _spread("energy", energies, (len(chosen),)))

    def set_velocity(self, velocity: ArrayLike, which: Which = None) -> None:
        """Sets the velocities of bodies.

        Parameters
        ----------
        velocity : array_like, shape (2,) or (n, 2)
            Velocity of each body (length / time).
        which : str or array_like of int or bool, optional
            A tag, numbers of bodies, or a mask. Default: all that move.

        Raises
        ------
        EditError
            A body is fixed or not in the system, or a speed is out of range; nothing has changed.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> sim.set_velocity(-sim.velocities)
        >>> sim.set_velocity([1.0, 0.5], [7])
        >>> sim.velocities[7].tolist()
        [1.0, 0.5]
        """
        chosen = self._which(which)
        rows = _spread("velocity", vectors("velocity", velocity), (len(chosen), 2))
        self._core.set_velocity(chosen, rows.reshape(-1))

    def set_angular_velocity(self, angular_velocity: ArrayLike, which: Which = None) -> None:
        """Sets the angular velocities of molecules that can turn.

        Parameters
        ----------
        angular_velocity : array_like, shape () or (n,)
            Angular velocity of each body (radians / time, counter-clockwise).
        which : str or array_like of int or bool, optional
            A tag, numbers of bodies, or a mask. Default: all that move.

        Raises
        ------
        EditError
            A body is fixed, locked, a single disc or not in the system; nothing has changed.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation(carom.Scene(molecule=carom.Molecule.tee(0.01).at(0.5, 0.5)))
        >>> sim.set_angular_velocity(2.0)
        >>> sim.angular_velocities.tolist()
        [2.0]
        """
        chosen = self._which(which)
        spins = _spread("angular_velocity", array("angular_velocity", angular_velocity), (len(chosen),))
        self._core.set_angular_velocity(chosen, spins)

    def set_elasticity(
        self,
        default: float = 1.0,
        *,
        contact_time: float | None = None,
        tangential: float = -1.0,
        friction: float | None = None,
        pairs: Mapping[str | tuple[str, ...], float | Mapping[str, Any]] | None = None,
    ) -> None:
        """Changes the coefficients of restitution and friction of all later contacts.

        Parameters
        ----------
        default : float
            Coefficient of contacts to which no rule applies, from 0 to 1e6; 1 is elastic.
        contact_time : float, optional
            Guard against inelastic collapse, see ``crates/book/src/keys.md``.
        tangential : float
            Tangential restitution of contacts to which no rule applies, from -1 (smooth) to 1.
        friction : float, optional
            Friction of contacts to which no rule applies, at least 0; by default they never slide.
        pairs : mapping, optional
            Coefficients by a tag, or by a tuple of two tags: a number, or the keys of
            ``elasticity.pair`` without ``between``.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> sim.set_elasticity(0.9)
        >>> sim.run(until=1)
        >>> sim.energy < 20
        True
        """
        rules = [
            {
                **(plain(value) if isinstance(value, Mapping) else {"coefficient": number("pairs", value)}),
                "between": _between(tags),
            }
            for tags, value in dict(pairs or {}).items()
        ]
        entry = {
            "default": number("default", default),
            "contact_time": None if contact_time is None else number("contact_time", contact_time),
            "tangential": number("tangential", tangential),
            "friction": None if friction is None else number("friction", friction),
            "pair": rules,
        }
        self._core.set_elasticity(_carom.scene_of({"elasticity": entry}))

    def set_reactions(self, reactions: Sequence[Mapping[str, Any]]) -> None:
        """Replaces the reactions of bodies that collide; an empty list ends them.

        Parameters
        ----------
        reactions : sequence of mappings
            The keys of ``reaction`` in a scene, see ``crates/book/src/reactions.md``.

        Raises
        ------
        EditError
            A rule is out of range, or cannot act on the bodies that it names; nothing has changed.

        Examples
        --------
        >>> import carom
        >>> gas = {"radius": 0.01, "mass": 1, "energy": 1, "count": 100, "tags": ["A"]}
        >>> sim = carom.Simulation({"gas": [gas]})
        >>> sim.set_reactions([{"between": ["A"], "becomes": ["nothing", "nothing"]}])
        >>> sim.run(until=0.5)
        >>> [rule] = sim.reactions
        >>> rule["reaction"], 100 - 2 * rule["reactions"] == len(sim.ids)
        ('A + A → nothing', True)
        """
        rules = [plain(rule) for rule in reactions]
        self._core.set_reactions(_carom.scene_of({"reaction": rules}))

    @property
    def reactions(self) -> list[dict[str, Any]]:
        """The reactions that are or have been in force, and what they have done: ``reaction`` in a
        line, ``is_in_force``, the number of ``contacts`` of bodies that it names, of ``reactions``,
        of those ``blocked`` since the product had no room, and the ``energy`` that they have put in
        (mass · length² / time²).

        Examples
        --------
        >>> import carom
        >>> gas = {"radius": 0.01, "mass": 1, "energy": 1, "count": 100}
        >>> carom.Simulation({"gas": [gas]}).reactions
        []
        """
        names = ("reaction", "is_in_force", "contacts", "reactions", "blocked", "energy")
        return [dict(zip(names, values)) for values in self._core.reactions()]

    def set_transparent(self, pairs: Sequence[str | Sequence[str]]) -> None:
        """Replaces the pairs of bodies that do not see each other; an empty list ends them.

        Diameters by pair, ``[[diameter]]`` of a scene, hold for the whole run.

        Parameters
        ----------
        pairs : sequence of str or of two str
            Two tags, or one for bodies of this tag with each other, as in ``[[transparent]]`` of a
            scene.

        Raises
        ------
        EditError
            Bodies overlap that would see each other; nothing has changed.

        Examples
        --------
        >>> import carom
        >>> gas = {"radius": 0.02, "mass": 1, "energy": 1, "count": 100, "tags": ["ideal"]}
        >>> sim = carom.Simulation({"gas": [gas]})
        >>> sim.set_transparent(["ideal"])
        >>> sim.run(until=1)
        >>> sim.collision_count
        0
        """
        if isinstance(pairs, str):
            raise TypeError("`pairs` must be a list of tags and of pairs of tags, but is one text")
        rules = [{"between": _between(tags)} for tags in pairs]
        self._core.set_transparent(_carom.scene_of({"transparent": rules}))

    def thermostat(
        self,
        tag: str,
        kind: str = "energy-reset",
        *,
        every: float | None = None,
        energy: float | None = None,
        temperature: float | None = None,
        speed: float | None = None,
        rotational_diffusion: float | None = None,
        translational_diffusion: float | None = None,
        friction: float | None = None,
        momentum: float | Sequence[float] | None = None,
    ) -> None:
        """Changes the velocities of all bodies of a tag once, by a rule.

        Call it before each run of a loop for a rule that acts at regular times; the entries
        ``thermostat`` of a stage do so in :func:`run`. Random numbers follow from seed, replica,
        body, and the number of actions before, which a saved simulation keeps.

        Parameters
        ----------
        tag : str
            The bodies.
        kind : str
            ``"energy-reset"``, ``"maxwell"``, ``"active"``, ``"langevin"``, ``"rotate"``,
            ``"kick"`` or ``"rescale"``, see ``crates/book/src/stages.md``. The first two leave out
            fixed bodies, the others refuse them.
        every : float, optional
            Time until the next action; ``active`` and ``langevin`` need it.
        energy, temperature : float, optional
            Kinetic energy of each body, or kT (mass · length² / time²). ``energy-reset`` and
            ``maxwell`` take one of them, ``langevin`` and ``rescale`` the temperature.
        speed, rotational_diffusion, translational_diffusion : float, optional
            Of ``active``: speed along the axis (length / time), D_r (radians² / time), and D_T
            (length² / time), 0 by default.
        friction : float, optional
            Of ``langevin``: γ (1 / time).
        momentum : float or two floats, optional
            Of ``kick``: a magnitude in random directions, or a vector (mass · length / time).

        Raises
        ------
        EditError
            No body carries the tag, a number is missing or out of range, or a body cannot have the
            motion; nothing has changed.
        SceneError
            The kind is unknown.

        Examples
        --------
        >>> import carom
        >>> gas = {"radius": 0.01, "mass": 1, "energy": 0.5, "count": 100, "tags": ["gas"]}
        >>> sim = carom.Simulation({"gas": [gas]})
        >>> sim.thermostat("gas", "kick", momentum=[2.0, 0.0])
        >>> float(round(sim.momentum[0], 9))
        200.0
        >>> for step in range(1, 11):
        ...     sim.thermostat("gas", "langevin", every=0.1, friction=2.0, temperature=1.0)
        ...     sim.run(until=0.1 * step)
        """
        entry: dict[str, Any] = {"tag": word("tag", tag), "kind": word("kind", kind)}
        if every is None and kind in ("active", "langevin"):
            raise TypeError(f"`every` is missing: {kind!r} needs the time until the next action")
        numbers = {
            "every": every,
            "energy": energy,
            "temperature": temperature,
            "speed": speed,
            "rotational_diffusion": rotational_diffusion,
            "translational_diffusion": translational_diffusion,
            "friction": friction,
        }
        for key, value in numbers.items():
            if value is not None:
                entry[key] = number(key, value)
        interval = entry.setdefault("every", 1.0)
        if not (interval > 0 and math.isfinite(interval)):
            raise ValueError(f"`every` must be above 0 and finite, but is {interval!r}")
        if momentum is not None:
            vector = array("momentum", momentum)
            if vector.shape not in ((), (2,)):
                raise ValueError(f"`momentum` must be a number or [x, y], but is {momentum!r:.60}")
            entry["momentum"] = vector.tolist()
        self._core.ids_of(tag)
        self._core.thermostat(_carom.scene_of({"stage": [{"until": 1.0, "thermostat": [entry]}]}))

    def set_drag(self, drag: float) -> None:
        """Changes the drag γ of all bodies: from now on v' = −γ v and ω' = −γ ω between contacts.

        Parameters
        ----------
        drag : float
            γ (1/time), from 0 to 1e60.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> sim.set_drag(0.5)
        >>> sim.run(until=2)
        >>> round(sim.energy, 6)
        2.706706
        """
        self._core.set_drag(number("drag", drag))

    def set_gravity(self, gravity: ArrayLike) -> None:
        """Changes the gravity: from now on all free bodies have this acceleration.

        Parameters
        ----------
        gravity : two floats
            Acceleration (length/time²). A wall across the box must stop bodies that fall.

        Examples
        --------
        >>> import carom
        >>> ball = {"shape": "disc", "atom_radius": 0.125, "atom_mass": 1, "at": [0.5, 0.75]}
        >>> sim = carom.Simulation({"wall": [{"y": 0.125}], "molecule": [ball]})
        >>> sim.set_gravity([0, -1])
        >>> sim.run(until=1)
        >>> round(float(sim.positions[0, 1]), 12)
        0.25
        """
        pair = array("gravity", gravity)
        if pair.shape != (2,):
            raise ValueError(f"`gravity` must be two numbers [x, y], but is {pair.tolist()!r:.60}")
        self._core.set_gravity(pair.tolist())

    def set_shear_rate(self, rate: float) -> None:
        """Changes the shear rate: from now on the images above and below move along x by ± ``rate`` times
        the height of the box. Velocities do not change.

        Parameters
        ----------
        rate : float
            Shear rate (1/time), 0 or of any sign; not with walls or fixed bodies.

        Examples
        --------
        >>> import carom
        >>> gas = {"radius": 0.02, "mass": 1, "energy": 1, "count": 100}
        >>> sim = carom.Simulation({"gas": [gas]})
        >>> sim.set_shear_rate(0.25)
        >>> sim.run(until=1)
        >>> sim.tilt
        0.25
        """
        self._core.set_shear_rate(number("rate", rate))

    @property
    def tilt(self) -> float:
        """Shift along x of the next box above (length): 0 but under shear.

        Examples
        --------
        >>> sim.tilt
        0.0
        """
        return self._core.tilt()

    def bond(
        self,
        pairs: ArrayLike,
        max: float,
        *,
        min: float = 0.0,
        points: ArrayLike | None = None,
        elasticity: float = 1.0,
    ) -> None:
        """Ties bodies, each pair by a tether between two points; bonds that there are remain.

        Parameters
        ----------
        pairs : array_like of shape (k, 2)
            Numbers of the two bodies of each bond.
        max, min : float
            Greatest and least distance of the two points (length). A ``min`` of 0 is no bound.
        points : array_like of shape (2, 2), optional
            The point on the first and on the second body, from its centre of mass and in its frame
            (length). Default: the centres of mass.
        elasticity : float
            Share of their speed that the points keep at a bound, from 0 to 1; below 1 a guard
            against inelastic collapse is needed, see ``set_elasticity``.

        Raises
        ------
        EditError
            A number is out of range, or a bond is beyond its bounds; nothing has changed.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"molecule": [carom.Molecule.disc(0.02).at(x, 0.5) for x in (0.4, 0.5)]})
        >>> sim.bond([[0, 1]], max=0.2)
        >>> sim.set_velocity([[1.0, 0.0], [0.0, 0.5]])
        >>> sim.run(until=10.0)
        >>> pairs, lengths = sim.bonds
        >>> pairs.tolist(), bool(lengths[0] <= 0.2 + 1e-12)
        ([[0, 1]], True)
        """
        tether = {
            "max": number("max", max),
            "min": number("min", min),
            "elasticity": number("elasticity", elasticity),
        }
        if points is not None:
            tether["points"] = np.asarray(points, dtype=float).tolist()
        entry = {"pairs": np.asarray(pairs, dtype=np.int64).tolist(), "tether": tether}
        self._core.bond(_carom.scene_of({"bond": [entry]}))

    def unbond(self, which: Which = None) -> None:
        """Removes all bonds of bodies.

        Examples
        --------
        >>> sim.unbond([0, 1])
        >>> len(sim.bonds[1])
        0
        """
        self._core.unbond(self._which(which))

    @property
    def bonds(self) -> tuple[Ids, NDArray[np.float64]]:
        """The bonds: numbers of the two bodies, shape (k, 2), and distances of the tied points
        (length), shape (k,).

        Examples
        --------
        >>> pairs, lengths = sim.bonds
        >>> pairs.shape, lengths.shape
        ((0, 2), (0,))
        """
        bonds = self._core.bonds()
        pairs = np.array([pair for pair, _ in bonds], dtype=np.uint64).reshape(-1, 2)
        return pairs, np.array([length for _, length in bonds])

    def set_wells(self, wells: Sequence[Mapping[str, Any]]) -> None:
        """Replaces the wells of discs; velocities do not change.

        Parameters
        ----------
        wells : list of dict
            Each with ``between``, one or two tags, and ``steps``, pairs of a range in distances at
            contact and an energy, as in ``[[well]]`` of a scene.

        Raises
        ------
        EditError
            A number is out of range, or a well does not fit the bodies; nothing has changed.

        Examples
        --------
        >>> import carom
        >>> gas = {"tags": ["a"], "radius": 0.03, "mass": 1.0, "temperature": 1.0, "count": 50}
        >>> sim = carom.Simulation({"gas": [gas]})
        >>> sim.set_wells([{"between": ["a"], "steps": [[1.5, -1.0]]}])
        >>> before = sim.energy + sim.energy_of_wells
        >>> sim.run(until=1.0)
        >>> bool(abs(sim.energy + sim.energy_of_wells - before) < 1e-10)
        True
        """
        self._core.set_wells(_carom.scene_of({"well": [dict(well) for well in wells]}))

    @property
    def pairs_in_wells(self) -> tuple[Ids, NDArray[np.int64], NDArray[np.float64]]:
        """The pairs of discs within the ranges of their wells: numbers of the two, shape (k, 2), the
        step of each pair from 0 inside, and its energy (mass · length² / time²), shape (k,).

        Examples
        --------
        >>> pairs, steps, energies = sim.pairs_in_wells
        >>> pairs.shape
        (0, 2)
        """
        found = self._core.pairs_in_wells()
        pairs = np.array([pair for pair, _, _ in found], dtype=np.uint64).reshape(-1, 2)
        steps = np.array([step for _, step, _ in found], dtype=np.int64)
        return pairs, steps, np.array([energy for _, _, energy in found], dtype=float)

    @property
    def energy_of_wells(self) -> float:
        """Potential energy of all wells (mass · length² / time²).

        Examples
        --------
        >>> sim.energy_of_wells
        0.0
        """
        return math.fsum(self.pairs_in_wells[2].tolist())

    def lock(self, which: Which = None) -> None:
        """Locks the present orientation of bodies; they stop turning.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation(carom.Scene(molecule=carom.Molecule.tee(0.01).at(0.5, 0.5)))
        >>> sim.lock()
        >>> bool(sim.locked[0])
        True
        """
        self._core.lock_rotation(self._which(which))

    def unlock(self, which: Which = None) -> None:
        """Frees the orientation of bodies.

        Examples
        --------
        >>> sim.lock([0, 1])
        >>> sim.unlock([0])
        >>> sim.locked[:3].tolist()
        [False, True, False]
        """
        self._core.unlock_rotation(self._which(which))

    def tag(self, which: Which, name: str) -> None:
        """Adds a tag to bodies.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 3}]})
        >>> sim.tag([1], "tracer")
        >>> sim.tags
        [(), ('tracer',), ()]
        """
        self._core.tag(self._which(which), word("name", name))

    def untag(self, which: Which, name: str) -> None:
        """Removes a tag from bodies; one that a body does not carry changes nothing.

        Examples
        --------
        >>> sim.untag([0], "gas")
        >>> int(sim.mask("gas").sum())
        99
        """
        self._core.untag(self._which(which), word("name", name))

    def reverse(self) -> None:
        """Reverses all velocities and angular velocities.

        Examples
        --------
        >>> velocities = sim.velocities
        >>> sim.reverse()
        >>> bool((sim.velocities == -velocities).all())
        True
        """
        self._core.reverse()

    # ------------------------------------------------------------------ files

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a checkpoint of the state and the measures.

        The format is that of the command: ``carom run SCENE --from DIR`` starts from a file
        ``DIR/checkpoint``. Saving moves the origin of time of all motions to the present, as an
        edit does: this simulation and the loaded one then continue with the same bits.

        Parameters
        ----------
        path : str or path
            The file; it is replaced as a whole.

        Examples
        --------
        >>> import carom, pathlib, tempfile
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> sim.run(until=1)
        >>> path = pathlib.Path(tempfile.mkdtemp()) / "checkpoint"
        >>> sim.save(path)
        >>> again = carom.load(path)
        >>> sim.run(until=2)
        >>> again.run(until=2)
        >>> bool((again.positions == sim.positions).all())
        True
        """
        self._core.save(path)

    def copy(self) -> Simulation:
        """A copy of the state, without measures and callbacks.

        Examples
        --------
        >>> other = sim.copy()
        >>> other.run(until=2)
        >>> other.time, sim.time
        (2.0, 1.0)
        """
        return Simulation._of(self._core.copy())

    def __copy__(self) -> Simulation:
        return self.copy()

    def __deepcopy__(self, memo: object) -> Simulation:
        return self.copy()

    def __reduce_ex__(self, protocol: object) -> str:
        raise TypeError(
            "a Simulation cannot be pickled: pickle its Scene, or use `save` and `carom.load` for its state"
        )

    # ----------------------------------------------------------- other programs

    def to_ase(self) -> Any:
        """The atoms as ``ase.Atoms``; needs ASE.

        Molecules are whole: an atom may lie outside the box. ``get_velocities()`` is in the units
        of the scene. Further arrays: ``radius``, ``angle``, ``molecule_id``, ``kind``. Walls have
        no atoms. ``info["bonds"]`` has the two atoms of each bond, if there are any.

        Examples
        --------
        >>> atoms = sim.to_ase()
        >>> len(atoms) == len(sim), bool(np.allclose(atoms.get_velocities()[:, :2], sim.velocities))
        (True, True)
        """
        return to_ase(self._core)

    def to_freud(self) -> tuple[Any, Any]:
        """The box, and the centres of mass of all but walls in a box about the origin; needs freud.

        freud's functions take the pair as a system. For its mean squared displacement, use
        ``unwrapped_positions``.

        Examples
        --------
        >>> import freud
        >>> rdf = freud.density.RDF(bins=20, r_max=0.2)
        >>> rdf.compute(sim.to_freud()).rdf.shape
        (20,)
        """
        return to_freud(self._core)

    def to_gsd(self) -> Any:
        """The atoms as ``gsd.hoomd.Frame``, to be appended to a file; needs gsd.

        Positions are in a box about the origin in single precision, image numbers count the boxes
        that the molecule has crossed, types bear the names of the tags, and ``log["time"]`` is the
        time. Bonds join the atoms that are nearest to their points.

        Examples
        --------
        >>> frame = sim.to_gsd()
        >>> frame.validate()
        >>> frame.particles.N == len(sim)
        True
        """
        return to_gsd(self._core)

    # --------------------------------------------------------------- pictures

    def show(self, *, height: int = 640) -> Html:
        """The motion of the next contacts, as in the report of a run.

        A copy runs ahead; the simulation does not change. Of a large system a part is shown. The
        picture is self-contained: it needs no network and no files.

        Parameters
        ----------
        height : int
            Height in the notebook (pixels, from 16 to 16384).

        Returns
        -------
        Html
            A moving picture that Jupyter displays.

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> len(str(sim.show())) > 10_000
        True
        """
        title = f"{len(self)} bodies from t = {self.time:g} on"
        caption = "The flights of the bodies between contacts."
        return Html(frame(self._core.page(title, caption), pixels("height", height)))

    def svg(self, size: int = 480) -> str:
        """A picture of the present state as SVG; of a large system, of a part.

        Parameters
        ----------
        size : int
            Longer side (pixels, from 16 to 16384).

        Examples
        --------
        >>> import carom
        >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
        >>> "<svg" in sim.svg()
        True
        """
        return self._core.picture(pixels("size", size))

    def __repr__(self) -> str:
        return f"<carom.Simulation of {len(self)} bodies at time {self.time:g}>"

    def _repr_html_(self) -> str:
        return f"{self.svg()}<p>{len(self)} bodies at time {self.time:g}</p>"


def load(path: str | os.PathLike[str]) -> Simulation:
    """The simulation in a checkpoint: of :meth:`Simulation.save`, or of ``carom run``.

    Parameters
    ----------
    path : str or path
        The file, or the folder of a run: then the end of the run, or its last checkpoint.

    Returns
    -------
    Simulation
        Its measures are those that have been saved with it; the stages of a run are not continued.

    Raises
    ------
    CheckpointError
        The file cannot be read, is damaged, or is no checkpoint of a scene.

    Examples
    --------
    >>> import carom
    >>> carom.load("no-such-file")
    Traceback (most recent call last):
        ...
    carom.CheckpointError: cannot load no-such-file: it cannot be read: No such file or directory (os error 2)
    """
    core = _carom.Core.load(path)
    simulation = Simulation._of(core)
    simulation._measures = [Measure(core, index, _kind(core, index)) for index in range(core.measures())]
    return simulation


def _kind(core: _carom.Core, index: int) -> str:
    measured: str = Results(core.results(index)).scene.tables["measure"][0]["kind"]
    return measured


def _receiver(callback: Callable[[Collision], object]) -> Callable[[bytes], None]:
    def receive(report: bytes) -> None:
        callback(Collision(of_bytes(report)[0]))

    return receive


def _parameter(name: str, value: object) -> float | str | list[float]:
    """The value of a parameter of a measure: a number, a word or a tag, or numbers."""
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple, np.ndarray)) and np.ndim(value) > 0:
        return [number(name, each) for each in value]
    return number(name, value)


def _between(tags: str | Sequence[str]) -> list[str]:
    return [tags] if isinstance(tags, str) else [word("a tag", tag) for tag in tags]


def _spread(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Floats:
    try:
        return np.ascontiguousarray(np.broadcast_to(array(name, value), shape))
    except ValueError as error:
        if "broadcast" not in str(error):
            raise
        raise ValueError(f"`{name}` must have the shape {shape} or fit it, but has {np.shape(value)}") from None
