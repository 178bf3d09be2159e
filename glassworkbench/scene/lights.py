"""Lights: what a ray sees once it has left the glass."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene.validate import finite_array


@dataclass(frozen=True, eq=False)
class Panel:
    """A diffuse luminous parallelogram, seen from both sides; it ends every ray that meets it.

    Parameters
    ----------
    origin_mm : array (3,)
        One corner.
    u_mm, v_mm : array (3,)
        The edges from that corner.
    radiance : array (3,)
        R, G, B; one number stands for all three.
    """

    origin_mm: np.ndarray
    u_mm: np.ndarray
    v_mm: np.ndarray
    radiance: np.ndarray = field(default=(1.0, 1.0, 1.0))

    def __post_init__(self) -> None:
        for name in ("origin_mm", "u_mm", "v_mm"):
            object.__setattr__(self, name, finite_array(getattr(self, name), (3,), f"panel {name}"))
        if np.linalg.norm(np.cross(self.u_mm, self.v_mm)) == 0.0:
            raise InputError("panel u, v: they must span an area")
        object.__setattr__(self, "radiance", _radiance(self.radiance, "panel radiance"))


@dataclass(frozen=True, eq=False)
class Environment:
    """Light from infinitely far, as a latitude-longitude map.

    Parameters
    ----------
    radiance : array (h, w, 3)
        Row 0 looks up (+z), the last row down; column centres run over the azimuth
        a = atan2(y, x) from -180 to +180 degrees. Bilinear in between, periodic in azimuth.
        One number or one colour means the same light from everywhere.
    """

    radiance: np.ndarray

    def __post_init__(self) -> None:
        radiance = np.asarray(self.radiance, dtype=np.float64)
        if radiance.ndim <= 1:
            radiance = np.broadcast_to(_radiance(radiance, "environment radiance"), (1, 1, 3))
        radiance = finite_array(radiance, (None, None, 3), "environment radiance")
        if radiance.size == 0 or np.any(radiance < 0.0):
            raise InputError("environment radiance: must have pixels, none of them negative")
        object.__setattr__(self, "radiance", radiance)


Light = Panel | Environment


def _radiance(value: object, name: str) -> np.ndarray:
    array = np.asarray(value, dtype=np.float64)
    if array.ndim == 0:
        array = np.repeat(array, 3)
    array = finite_array(array, (3,), name)
    if np.any(array < 0.0):
        raise InputError(f"{name}: must not be negative")
    return array
