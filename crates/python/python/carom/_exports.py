"""The present state as an object of another program: ASE, freud or GSD."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from . import _carom

__all__ = ["package", "to_ase", "to_freud", "to_gsd"]


def to_ase(core: _carom.Core) -> Any:
    """An ``ase.Atoms`` of all atoms; see :meth:`Simulation.to_ase`."""
    ase = package("ase", "ase")
    atoms, (x, y) = core.atoms(), core.sides()
    thickness = 2 * atoms["radii"].max(initial=0.0) or min(x, y)
    found = ase.Atoms(
        # X stands for no element: the atoms of fixed bodies.
        numbers=np.where(atoms["fixed"], 0, 1),
        positions=_spatial(atoms["positions"]),
        momenta=_spatial(atoms["velocities"]) * atoms["masses"][:, None],
        masses=atoms["masses"],
        cell=[[x, 0, 0], [core.tilt(), y, 0], [0, 0, thickness]],
        pbc=[True, True, False],
        info={"Time": core.time(), "kinds": atoms["names"]},
    )
    found.set_array("radius", atoms["radii"])
    found.set_array("angle", atoms["angles"])
    found.set_array("molecule_id", atoms["ids"])
    found.set_array("kind", atoms["kinds"])
    if len(atoms["bonds"]):
        found.info["bonds"] = atoms["bonds"]
    return found


def to_freud(core: _carom.Core) -> tuple[Any, Any]:
    """Box and centres of mass for ``freud``; see :meth:`Simulation.to_freud`."""
    freud = package("freud", "freud-analysis")
    x, y = core.sides()
    # Walls have no atoms, and no point.
    has_atoms = np.isin(core.array("ids"), core.atoms()["ids"])
    points = _spatial(core.array("positions")[has_atoms] - [x / 2, y / 2])
    box = freud.box.Box(Lx=x, Ly=y, xy=core.tilt() / y, is2D=True)
    # Of a box that a shear has tilted, freud has the parallelogram about the origin.
    points = box.wrap(points) if core.tilt() else points
    return box, points.astype(np.float32)


def to_gsd(core: _carom.Core) -> Any:
    """A ``gsd.hoomd.Frame`` of all atoms; see :meth:`Simulation.to_gsd`."""
    hoomd = package("gsd.hoomd", "gsd")
    atoms, sides = core.atoms(), np.array(core.sides())
    tilt = core.tilt() / sides[1]
    # In a box that a shear has tilted, x − tilt y is that of a rectangle.
    upright = atoms["positions"] - np.outer(atoms["positions"][:, 1] - sides[1] / 2, [tilt, 0])
    boxes = np.floor(upright / sides)
    inside = upright - (boxes + 0.5) * sides
    inside += np.outer(inside[:, 1], [tilt, 0])
    half = np.zeros(len(inside))
    _, molecule, count = np.unique(atoms["ids"], return_inverse=True, return_counts=True)
    frame = hoomd.Frame()
    frame.configuration.box = [*sides, 0, tilt, 0, 0]
    frame.configuration.dimensions = 2
    particles = frame.particles
    particles.N = len(inside)
    # Rounded to single precision a place may lie on the upper border.
    upper = [sides[0] / 2 if tilt == 0 else np.inf, sides[1] / 2, 0]
    particles.position = np.minimum(_spatial(inside).astype(np.float32), upper).astype(np.float32)
    particles.image = _spatial(boxes + atoms["images"]).astype(np.int32)
    particles.velocity = _spatial(atoms["velocities"])
    particles.orientation = np.column_stack(
        [np.cos(atoms["angles"] / 2), half, half, np.sin(atoms["angles"] / 2)]
    )
    particles.mass = atoms["masses"]
    particles.diameter = 2 * atoms["radii"]
    particles.body = np.where(count[molecule] == 1, -1, atoms["ids"].astype(np.int64))
    particles.typeid = atoms["kinds"]
    particles.types = atoms["names"]
    particles.type_shapes = [_shape(atoms["radii"][atoms["kinds"] == kind]) for kind in range(len(atoms["names"]))]
    if len(atoms["bonds"]):
        frame.bonds.N = len(atoms["bonds"])
        frame.bonds.group = atoms["bonds"].astype(np.uint32)
        frame.bonds.typeid = np.zeros(frame.bonds.N, dtype=np.uint32)
        frame.bonds.types = ["tether"]
    frame.log = {"time": np.array([core.time()])}
    return frame


def _shape(radii: Any) -> dict[str, Any]:
    """A disc, which the schema calls a sphere in two dimensions, if all atoms of a kind are equal."""
    sizes = np.unique(radii)
    return {"type": "Sphere", "diameter": 2 * float(sizes[0])} if len(sizes) == 1 else {}


def _spatial(pairs: Any) -> Any:
    """Rows of two numbers with a third that is 0."""
    return np.column_stack([pairs, np.zeros(len(pairs))])


def package(module: str, name: str) -> Any:
    """A module of an optional package; an ``ImportError`` says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"this needs the package {name}: pip install {name}") from error
