"""A homogeneous material: refractive index, absorption, density, and where the numbers come from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError


@dataclass(frozen=True, eq=False)
class _Material:
    name: str
    refractive_index: float
    absorption_per_mm: np.ndarray
    density_g_per_cm3: float
    description: str = ""
    source: str = ""

    def __post_init__(self) -> None:
        absorption = _numbers(self, "absorption_per_mm", (3,))
        if np.any(absorption < 0.0):
            raise InputError(f"{self.name}: absorption_per_mm must not be negative")
        index = float(_numbers(self, "refractive_index", ()))
        if index < 1.0:
            raise InputError(f"{self.name}: refractive_index must be at least 1, got {index:g}")
        density = float(_numbers(self, "density_g_per_cm3", ()))
        if density <= 0.0:
            raise InputError(f"{self.name}: density_g_per_cm3 must be above 0, got {density:g}")
        object.__setattr__(self, "absorption_per_mm", absorption)
        object.__setattr__(self, "refractive_index", index)
        object.__setattr__(self, "density_g_per_cm3", density)

    def transmittance(self, path_mm: float) -> np.ndarray:
        """Return the internal transmittance R, G, B over a path in mm (Beer-Lambert), (3,)."""
        return np.exp(-self.absorption_per_mm * path_mm)


class Glass(_Material):
    """What a container is made of.

    Parameters
    ----------
    name : str
    refractive_index : float
        At the sodium or helium d line.
    absorption_per_mm : array (3,)
        Napierian absorption coefficient (1/mm) for R, G, B.
    density_g_per_cm3 : float
    description, source : str
        For the user; where the numbers come from and what is assumed.

    Raises
    ------
    InputError
        If a number is missing, not finite or impossible.
    """


class Filling(_Material):
    """A liquid in the container; parameters as for `Glass`."""


def _numbers(material: _Material, field: str, shape: tuple[int, ...]) -> np.ndarray:
    value = getattr(material, field)
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{material.name}: {field} must be numbers, got {value!r}") from error
    if array.shape != shape:
        wanted = "three numbers (R, G, B)" if shape else "one number"
        raise InputError(f"{material.name}: {field} must be {wanted}, got {value!r}")
    if not np.all(np.isfinite(array)):
        raise InputError(f"{material.name}: {field} must be finite, got {value!r}")
    array.setflags(write=False)
    return array
