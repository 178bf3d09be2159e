"""Cracks: checks and splits, thin films of air."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.flaws.defect import AIR, Grain, InWall, Site, turned_in_surface


@dataclass(frozen=True, kw_only=True)
class _Crack(InWall):
    length_mm: float
    opening_mm: float = 0.01
    direction_deg: float = 0.0
    tilt_deg: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("length_mm", "opening_mm")
        for field in ("direction_deg", "tilt_deg"):
            object.__setattr__(self, field, self._finite(field))

    def _film(self, site: Site, across_mm: float) -> Grain:
        along, beside, outward = turned_in_surface(site, self.direction_deg).T
        tilt = np.radians(self.tilt_deg)
        inward = np.sin(tilt) * beside - np.cos(tilt) * outward
        rotation = np.column_stack([along, inward, np.cross(along, inward)])
        semi_axes = 0.5 * np.array([self.length_mm, across_mm, self.opening_mm])
        return Grain(site.at_depth_mm(self.depth_mm), semi_axes, rotation, AIR, within_wall=False)


@dataclass(frozen=True, kw_only=True)
class Check(_Crack):
    """A crack that goes partly through the wall: a lens-shaped film of air, which may be open to either side.

    Parameters
    ----------
    length_mm : float
        Along the surface.
    across_mm : float
        Along the crack's plane, across its length.
    opening_mm : float
        Thickness of the film in its middle.
    direction_deg : float
        Which way along the surface it runs: 0 horizontal, 90 upward.
    tilt_deg : float
        Of its plane from straight through the wall (0) towards lying along the surface (90).
    """

    kind: ClassVar[str] = "check"
    description: ClassVar[str] = "a crack partly through the wall, which glitters: a thin film of air"
    usual_severity: ClassVar[str] = "critical"

    length_mm: float = 4.0
    across_mm: float = 1.5
    tilt_deg: float = 45.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("across_mm")

    def grains(self, site: Site) -> tuple[Grain, ...]:
        """Return a flat ellipsoid of air."""
        return (self._film(site, self.across_mm),)


@dataclass(frozen=True, kw_only=True)
class Split(_Crack):
    """A crack that goes all the way through the wall, open to both sides; parameters as for `Check`."""

    kind: ClassVar[str] = "split"
    description: ClassVar[str] = "a crack all the way through the wall"
    usual_severity: ClassVar[str] = "critical"

    THROUGH: ClassVar[float] = 2.0
    """How far it reaches across, as a multiple of what the wall asks for: its edges lie outside the glass."""

    length_mm: float = 15.0
    direction_deg: float = 90.0
    tilt_deg: float = 20.0

    MOST_TILT_DEG: ClassVar[float] = 60.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not abs(self.tilt_deg) <= self.MOST_TILT_DEG:
            raise InputError(
                f"{self.kind}: tilt_deg: at {self.tilt_deg:g} deg it would not go through the wall; "
                f"give at most {self.MOST_TILT_DEG:g}"
            )

    def grains(self, site: Site) -> tuple[Grain, ...]:
        """Return a flat ellipsoid of air."""
        return (self._film(site, self.THROUGH * site.wall_mm / np.cos(np.radians(self.tilt_deg))),)
