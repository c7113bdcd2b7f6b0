"""A progress bar, in a terminal or a notebook."""

from __future__ import annotations

import importlib
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["Progress", "counted"]

# Wall time between two drawings (seconds), and the width of the bar (characters).
_PAUSE = 0.1
_WIDTH = 30


class Progress:
    """Draws the share of a run that is done, its collisions and its speed."""

    def __init__(self, start: float, until: float) -> None:
        self._start, self._until = start, until
        self._begun = self._drawn = time.monotonic()
        self._first: int | None = None
        self._display: Any = None
        if "ipykernel" in sys.modules:
            notebook = importlib.import_module("IPython.display")
            self._display = notebook.display({"text/plain": ""}, raw=True, display_id=True)

    def __call__(self, now: float, collisions: int) -> None:
        wall = time.monotonic()
        if self._first is None:
            self._first = collisions
        if wall - self._drawn >= _PAUSE:
            self._drawn = wall
            self._draw(now, collisions, wall - self._begun)

    def _draw(self, now: float, collisions: int, wall: float) -> None:
        span = self._until - self._start
        share = min(max((now - self._start) / span, 0.0), 1.0) if span > 0 else 1.0
        full = round(share * _WIDTH)
        speed = (collisions - (self._first or 0)) / wall if wall > 0 else 0.0
        bar = "#" * full + "-" * (_WIDTH - full)
        line = f"t = {now:.6g} of {self._until:g} [{bar}] {collisions} collisions, {speed:.3g} per second"
        if self._display is not None:
            self._display.update({"text/plain": line}, raw=True)
        else:
            sys.stderr.write(f"\r{line}")
            sys.stderr.flush()

    def close(self, now: float, collisions: int) -> None:
        """Draws the end."""
        self._draw(now, collisions, time.monotonic() - self._begun)
        if self._display is None:
            sys.stderr.write("\n")


@contextmanager
def counted(total: int, unit: str) -> Iterator[Callable[[int], object]]:
    """Shows how many of ``total`` are done: by tqdm where it is installed, else by a line.

    The function that it gives takes the number of those that have ended since its last call.
    """
    try:
        bar = importlib.import_module("tqdm.auto").tqdm(total=total, unit=unit)
    except ImportError:
        bar = None
    if bar is not None:
        with bar:
            yield bar.update
        return
    ended = 0

    def update(count: int) -> None:
        nonlocal ended
        ended += count
        sys.stderr.write(f"\r{ended} of {total} {unit}s")
        sys.stderr.flush()

    try:
        yield update
    finally:
        if ended:
            sys.stderr.write("\n")
