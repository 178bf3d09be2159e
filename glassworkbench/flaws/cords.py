"""Glass of another composition: cords."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.flaws.defect import Grain, InWall, Site, Substance, turned_in_surface


@dataclass(frozen=True, kw_only=True)
class Cord(InWall):
    """A strand of glass whose refractive index is a little other.

    Parameters
    ----------
    length_mm, width_mm, thickness_mm : float
        Along it, across it along the surface, and through the wall.
    index_offset : float
        Of its refractive index from the glass's.
    direction_deg : float
        Which way along the surface it runs: 0 horizontal, 90 upward. It is straight, so a horizontal one must be short.
    """

    kind: ClassVar[str] = "cord"
    description: ClassVar[str] = "a strand of glass whose refractive index is a little other"

    length_mm: float = 40.0
    width_mm: float = 1.0
    thickness_mm: float = 0.6
    index_offset: float = 0.003
    direction_deg: float = 90.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("length_mm", "width_mm", "thickness_mm")
        for field in ("index_offset", "direction_deg"):
            object.__setattr__(self, field, self._finite(field))
        if self.index_offset == 0.0:
            raise InputError(f"{self.kind}: index_offset: it is 0, so nothing would be seen; give it one like 0.003")

    def grains(self, site: Site) -> tuple[Grain, ...]:
        """Return a long ellipsoid."""
        semi_axes = 0.5 * np.array([self.length_mm, self.width_mm, self.thickness_mm])
        frame = turned_in_surface(site, self.direction_deg)
        return (
            Grain(site.at_depth_mm(self.depth_mm), semi_axes, frame, Substance("cord", index_offset=self.index_offset)),
        )
