"""A picture in a notebook that follows a simulation."""

from __future__ import annotations

import math
import time
from typing import Any

from ._exports import package
from ._plain import number, pixels
from ._simulation import Simulation

__all__ = ["LiveView", "live"]

# Pictures of a run without `every`.
_PICTURES = 200
_MOST_PICTURES = 10**6


def live(simulation: Simulation, *, size: int = 480) -> LiveView:
    """Shows a simulation in a notebook, by a picture that follows it.

    The picture stands below the cell that calls this function, and is redrawn in place by
    :meth:`LiveView.run` and :meth:`LiveView.update`. Outside of a notebook nothing is drawn.

    Parameters
    ----------
    simulation : Simulation
        The simulation. Of a large one a part is drawn.
    size : int
        Longer side of the picture (pixels, from 16 to 16384).

    Returns
    -------
    LiveView

    Raises
    ------
    ImportError
        IPython is not installed.

    Examples
    --------
    >>> import carom
    >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
    >>> view = carom.live(sim)
    >>> view.run(until=0.5, every=0.1, rate=100)
    >>> sim.time
    0.5
    """
    return LiveView(simulation, pixels("size", size))


class LiveView:
    """A picture in a notebook that follows a simulation; :func:`live` makes it.

    Examples
    --------
    Examples of the members continue from this one.

    >>> import carom
    >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
    >>> view = carom.live(sim)
    >>> view
    <carom.LiveView of 20 bodies at time 0>
    """

    __module__ = "carom"
    __slots__ = ("_handle", "_simulation", "_size")

    def __init__(self, simulation: Simulation, size: int) -> None:
        if not isinstance(simulation, Simulation):
            raise TypeError(f"a simulation is expected, not {simulation!r:.60}")
        self._simulation, self._size = simulation, size
        self._handle: Any = None
        # Without a session, `display` prints and returns no handle.
        if package("IPython", "ipython").get_ipython() is not None:
            display = package("IPython.display", "ipython").display
            self._handle = display(self._picture(), raw=True, display_id=True)

    def run(self, until: float, *, every: float | None = None, rate: float = 20.0) -> None:
        """Runs the simulation to a time, and redraws the picture at equal intervals.

        Ctrl-C, or the stop button of the notebook, ends the run between two events; the picture
        then shows the time at which it ended, and both can be continued.

        Parameters
        ----------
        until : float
            End of the run (time).
        every : float, optional
            Time of the simulation between two pictures. Default: a two-hundredth of the run.
        rate : float
            Largest number of pictures in a second of wall time: a run that is faster waits.

        Raises
        ------
        RunError
            See :meth:`Simulation.run`.
        ValueError
            ``every`` or ``rate`` is not positive, or there would be more than 10⁶ pictures.

        Examples
        --------
        >>> view.run(until=1.0, every=0.25, rate=100)
        >>> view
        <carom.LiveView of 20 bodies at time 1>
        """
        start, end, most = self._simulation.time, number("until", until), number("rate", rate)
        spacing = (end - start) / _PICTURES if every is None else number("every", every)
        for name, value in (("every", spacing), ("rate", most)):
            if not value > 0 and (name == "rate" or every is not None):
                raise ValueError(f"`{name}` must be positive, but is {value:g}")
        pictures = (end - start) / spacing if start < end < math.inf else 0.0
        if pictures > _MOST_PICTURES:
            raise ValueError(f"`every`: there would be {pictures:.3g} pictures; at most 1e6 are allowed")
        drawn = -math.inf
        try:
            for picture in range(1, math.ceil(pictures * (1 - 1e-12))):
                self._simulation.run(start + picture * spacing)
                time.sleep(max(drawn + 1 / most - time.monotonic(), 0.0))
                self.update()
                drawn = time.monotonic()
            self._simulation.run(end)
        finally:
            self.update()

    def update(self) -> None:
        """Draws the present state, after :meth:`Simulation.run` or an edit of the simulation.

        Examples
        --------
        >>> sim.run(until=2.0)
        >>> view.update()
        """
        if self._handle is not None:
            self._handle.update(self._picture(), raw=True)

    def _picture(self) -> dict[str, str]:
        simulation = self._simulation
        words = f"{len(simulation)} bodies at time {simulation.time:.6g}, {simulation.collision_count} collisions"
        return {"text/html": f"{simulation.svg(self._size)}<p>{words}</p>", "text/plain": words}

    def __repr__(self) -> str:
        return f"<carom.LiveView of {len(self._simulation)} bodies at time {self._simulation.time:g}>"
