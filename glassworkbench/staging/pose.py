"""How a container stands at a station: turned, tilted, beside its place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.scene import Surface
from glassworkbench.scene.placing import placed, rotation
from glassworkbench.scene.validate import finite, finite_array


@dataclass(frozen=True)
class Pose:
    """A container turned about its axis, then tilted about the middle of its base, then moved.

    Parameters
    ----------
    rotation_deg : float
        About the axis, counter-clockwise seen from above.
    tilt_deg : float
        Of the axis from upright.
    tilt_azimuth_deg : float
        Where the finish leans to, from +x towards +y.
    offset_mm : (float, float, float)
    """

    rotation_deg: float = 0.0
    tilt_deg: float = 0.0
    tilt_azimuth_deg: float = 0.0
    offset_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("rotation_deg", "tilt_deg", "tilt_azimuth_deg"):
            object.__setattr__(self, name, finite(getattr(self, name), f"container: {name}"))
        offset = finite_array(self.offset_mm, (3,), "container: offset_mm")
        object.__setattr__(self, "offset_mm", tuple(map(float, offset)))

    @property
    def turn(self) -> np.ndarray:
        """The rotation (3, 3)."""
        azimuth = np.radians(self.tilt_azimuth_deg)
        hinge = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        upright = np.array([0.0, 0.0, 1.0])
        return rotation(hinge, np.radians(self.tilt_deg)) @ rotation(upright, np.radians(self.rotation_deg))

    @property
    def is_none(self) -> bool:
        """Whether it leaves the container where it is."""
        return self.rotation_deg == self.tilt_deg == 0.0 and not any(self.offset_mm)

    def applied(self, surface: Surface) -> Surface:
        """Return a surface of the container so placed."""
        return surface if self.is_none else placed(surface, self.turn, np.array(self.offset_mm))
