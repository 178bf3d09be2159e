"""Checks that the scene's dataclasses share, each raising an InputError that names the field."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from glassworkbench.errors import InputError


def finite_array(value: object, shape: tuple[int | None, ...], field: str) -> np.ndarray:
    """Return `value` as a read-only, contiguous float64 array of `shape` (None: any length).

    Raises
    ------
    InputError
        If the shape differs or a number is not finite.
    """
    try:
        array = np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise InputError(f"{field}: expected numbers, got {value!r}") from error
    fits = array.ndim == len(shape) and all(
        want is None or want == have for want, have in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = " x ".join("n" if want is None else str(want) for want in shape)
        raise InputError(f"{field}: expected an array of {wanted or 'one'} numbers, got shape {array.shape}")
    if not np.all(np.isfinite(array)):
        raise InputError(f"{field}: every number must be finite (no NaN, no infinity)")
    array.setflags(write=False)
    return array


def file_path(value: object) -> Path:
    """Return `value` as a path, or raise an InputError."""
    if not isinstance(value, (str, os.PathLike)):
        raise InputError(f"file: {value!r} is no path; give the name of a file")
    return Path(value)


def positive(value: object, field: str) -> float:
    """Return `value` as a float above zero, or raise an InputError that names `field`."""
    number = finite(value, field)
    if number <= 0.0:
        raise InputError(f"{field}: must be above 0, got {number:g}")
    return number


def finite(value: object, field: str) -> float:
    """Return `value` as a finite float, or raise an InputError that names `field`."""
    return float(finite_array(value, (), field))


def unit_vector(value: object, field: str) -> np.ndarray:
    """Return `value` (3,) scaled to length 1, or raise an InputError that names `field`."""
    vector = finite_array(value, (3,), field)
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        raise InputError(f"{field}: a direction cannot be the zero vector")
    unit = vector / length
    unit.setflags(write=False)
    return unit
