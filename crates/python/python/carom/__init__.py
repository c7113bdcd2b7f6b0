"""Exact event-driven simulation of two-dimensional gases of rigid molecules.

A molecule is a rigid union of discs, straight edges and ellipses. Between contacts it flies freely;
contacts are instantaneous, smooth or rough. There is no time step, and nothing passes through
anything.

>>> import carom
>>> gas = {"radius": 0.01, "mass": 1, "temperature": 1, "count": 1000, "tags": ["gas"]}
>>> sim = carom.Simulation(carom.Scene(gas=gas, seed=1))
>>> sim.run(until=0.2)
>>> shells = sim.measure("pair-distribution", of="gas", every=0.02, max=0.06)
>>> sim.run(until=1.0)
>>> bool(shells.table["g"].max() > 1)
True

Lengths, masses and times are in the units of the scene; angles are in radians.
"""

from ._carom import __version__
from ._collisions import COLLISION, Collision
from ._contact import FirstContact, first_contact
from ._dynamo import from_dynamo
from ._errors import (
    BusyError,
    CaromError,
    CheckpointError,
    EditError,
    MeasureError,
    MoleculeError,
    NotStationaryWarning,
    RunError,
    SceneError,
)
from ._html import Html
from ._imports import from_gsd, from_lammps
from ._live import LiveView, live
from ._molecule import ExposedArc, ExposedSide, Molecule
from ._replicas import measures, replicas, run
from ._results import Column, Figure, Results, Table, estimate, open_run
from ._scene import Scene
from ._simulation import Measure, Simulation, load
from ._study import Point, Study

__all__ = [
    "COLLISION",
    "BusyError",
    "CaromError",
    "CheckpointError",
    "Collision",
    "Column",
    "EditError",
    "ExposedArc",
    "ExposedSide",
    "Figure",
    "FirstContact",
    "Html",
    "LiveView",
    "Measure",
    "MeasureError",
    "Molecule",
    "MoleculeError",
    "NotStationaryWarning",
    "Point",
    "Results",
    "RunError",
    "Scene",
    "SceneError",
    "Simulation",
    "Study",
    "Table",
    "__version__",
    "estimate",
    "first_contact",
    "from_dynamo",
    "from_gsd",
    "from_lammps",
    "live",
    "load",
    "measures",
    "open_run",
    "replicas",
    "run",
]
