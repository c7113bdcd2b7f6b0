"""Checked conversions of arguments to plain numbers and arrays."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["array", "ids", "is_mask", "masked", "number", "pixels", "plain", "read_only", "vectors", "whole",
           "word"]


def number(name: str, value: object) -> float:
    """``value`` as a float; a ``TypeError`` names the argument."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise TypeError(f"`{name}` must be a number, but is {value!r:.60}")
    try:
        return float(value)
    except (OverflowError, TypeError) as error:
        raise ValueError(f"`{name}` must be a number that a float can hold: {error}") from None


def whole(name: str, value: object, least: int, most: int = 2**63 - 1) -> int:
    """``value`` as an integer from ``least`` to ``most``; a ``ValueError`` names the argument."""
    is_whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not is_whole or not least <= int(value) <= most:  # type: ignore[call-overload]
        limit = "on" if most == 2**63 - 1 else f"to {most}"
        raise ValueError(f"`{name}` must be a whole number from {least} {limit}, but is {value!r:.60}")
    return int(value)  # type: ignore[call-overload,no-any-return]


def pixels(name: str, value: object) -> int:
    """``value`` as a size on a screen; a ``ValueError`` names the argument."""
    return whole(name, value, 16, 16384)


def word(name: str, value: object) -> str:
    """``value`` as a text; a ``TypeError`` names the argument."""
    if not isinstance(value, str):
        raise TypeError(f"`{name}` must be a text, but is {value!r:.60}")
    return str(value)


def array(
    name: str, value: ArrayLike, *, finite: bool = True
) -> NDArray[np.float64]:
    """``value`` as an array of floats; errors name the argument."""
    try:
        raw = np.asarray(value)
        if raw.dtype.kind not in "iuf":
            raise TypeError(f"`{name}` must be an array of real numbers, but its dtype is {raw.dtype}")
        floats = raw.astype(np.float64)
    except ValueError as error:
        raise ValueError(f"`{name}` must be an array of real numbers: {error}") from None
    if finite and not np.isfinite(floats).all():
        raise ValueError(f"`{name}` must be finite, but has NaN or infinite numbers")
    return floats


def vectors(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """``value`` as a vector [x, y] or rows of them; a ``ValueError`` names the argument."""
    floats = array(name, value)
    if floats.ndim not in (1, 2) or floats.shape[-1] != 2:
        raise ValueError(
            f"`{name}` must be two numbers [x, y] or rows of them, but is {floats.tolist()!r:.60}"
        )
    return floats


def read_only(value: ArrayLike) -> NDArray[np.float64]:
    """``value`` as an array of floats that cannot be written to."""
    floats = np.array(value, dtype=np.float64)
    floats.setflags(write=False)
    return floats


def is_mask(value: ArrayLike) -> bool:
    """Whether ``value`` is an array of booleans."""
    raw = np.asarray(value)
    return bool(raw.ndim == 1 and raw.dtype.kind == "b")


def masked(name: str, value: ArrayLike, numbers: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """The ``numbers`` of bodies at which a mask is true; errors name the argument."""
    mask = np.asarray(value, dtype=np.bool_)
    if mask.shape != numbers.shape:
        raise ValueError(
            f"`{name}`: a mask must have one entry for each of the {len(numbers)} bodies, but has {len(mask)}"
        )
    return np.ascontiguousarray(numbers[mask])


def ids(name: str, value: ArrayLike) -> NDArray[np.uint64]:
    """``value`` as numbers of bodies; errors name the argument."""
    raw = np.atleast_1d(np.asarray(value))
    if raw.size == 0:
        return np.zeros(0, dtype=np.uint64)
    if raw.ndim != 1 or raw.dtype.kind not in "iu":
        raise TypeError(
            f"`{name}` must be a tag, a number of a body, a one-dimensional array of them or a mask, "
            f"but has dtype {raw.dtype} and shape {raw.shape}"
        )
    if raw.dtype.kind == "i" and (raw < 0).any():
        raise ValueError(f"`{name}`: the number of a body is not negative")
    return np.ascontiguousarray(raw, dtype=np.uint64)


def plain(value: object) -> Any:
    """``value`` as nested dictionaries, lists, numbers and texts."""
    described = getattr(value, "_description", None)
    if callable(described):
        return plain(described())
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    return value
