"""Numbers of a material as they come from a file, checked where they enter; errors name the field."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from glassworkbench.errors import InputError

LARGEST_NM = 100_000.0


LARGEST_PER_MM = 1e6
"""A metal absorbs less (1/mm); what is above is a slip of the pen."""


def text(value: object, where: str) -> str:
    """Return a text that is not empty, else raise InputError."""
    if not isinstance(value, str) or not value:
        raise InputError(f"{where}: must be a text in quotation marks, got {value!r}")
    return value


def coefficients(value: object, where: str) -> np.ndarray:
    """Return absorption coefficients in 1/mm (n,), else raise InputError."""
    found = numbers(value, where)
    if np.any(found < 0.0):
        raise InputError(f"{where}: must not be negative, got {found.min():g}")
    if np.any(found > LARGEST_PER_MM):
        raise InputError(f"{where}: must be at most {LARGEST_PER_MM:g} per mm, got {found.max():g}")
    return found


def number(value: object, where: str) -> float:
    """Return one finite number, else raise InputError."""
    return float(_finite(value, where, 0))


def above_zero(value: object, where: str) -> float:
    """Return one finite number above 0, else raise InputError."""
    found = number(value, where)
    if found <= 0.0:
        raise InputError(f"{where}: must be above 0, got {found:g}")
    return found


def not_negative(value: object, where: str) -> float:
    """Return one finite number of at least 0, else raise InputError."""
    found = number(value, where)
    if found < 0.0:
        raise InputError(f"{where}: must not be negative, got {found:g}")
    return found


def numbers(value: object, where: str) -> np.ndarray:
    """Return finite numbers (n,), read-only, else raise InputError."""
    return _finite(value, where, 1)


def rising_nm(value: object, where: str) -> np.ndarray:
    """Return wavelengths in nm that rise, at least two, read-only, else raise InputError."""
    found = numbers(value, where)
    if len(found) < 2:
        raise InputError(f"{where}: needs two wavelengths at least, got {len(found)}")
    if not np.all(np.diff(found) > 0.0):
        first = int(np.argmin(np.diff(found) > 0.0))
        raise InputError(f"{where}: must rise, but {found[first + 1]:g} nm follows {found[first]:g} nm; sort the rows")
    if found[0] <= 0.0 or found[-1] > LARGEST_NM:
        raise InputError(f"{where}: must lie between 0 and {LARGEST_NM:g} nm, got {found[0]:g} to {found[-1]:g}")
    return found


def range_nm(value: object, where: str) -> tuple[float, float]:
    """Return the shortest and the longest wavelength in nm, else raise InputError."""
    found = rising_nm(value, where)
    if len(found) != 2:
        raise InputError(f"{where}: must be the shortest and the longest wavelength, got {len(found)} numbers")
    return float(found[0]), float(found[1])


def within(
    wavelengths_nm: float | Sequence[float] | np.ndarray, known_nm: tuple[float, float], what: str
) -> np.ndarray:
    """Return wavelengths as an array if all of them lie in a range.

    Raises
    ------
    InputError
        Naming the first that does not, and `what` is known in the range alone: nothing is extrapolated.
    """
    found = np.asarray(wavelengths_nm, dtype=np.float64)
    # Written so that NaN lies outside, too.
    outside = ~((found >= known_nm[0]) & (found <= known_nm[1]))
    if np.any(outside):
        first, (low, high) = found[outside].flat[0], known_nm
        raise InputError(f"{what}: {first:g} nm lies outside {low:g} to {high:g} nm, where it is known")
    return found


def _finite(value: object, where: str, dimensions: int) -> np.ndarray:
    wanted = "numbers" if dimensions else "a number"
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{where}: must be {wanted}, got {value!r}") from error
    if array.ndim != dimensions or isinstance(value, (str, bool)):
        raise InputError(f"{where}: must be {wanted}, got {value!r}")
    if not np.all(np.isfinite(array)):
        raise InputError(f"{where}: must be finite, got {value!r}")
    array.setflags(write=False)
    return array
