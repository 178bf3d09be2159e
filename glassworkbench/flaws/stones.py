"""Solid inclusions: stones, with the glass around them that they have dissolved into."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from glassworkbench.flaws.defect import Grain, InWall, Site, Substance
from glassworkbench.settings import unknown_name

MINERALS = MappingProxyType(
    {"corundum": 1.765, "cristobalite": 1.485, "mullite": 1.648, "zirconia": 2.16, "zircon": 1.95}
)
"""Mean refractive index at 589 nm: Deer, Howie and Zussman, An Introduction to the Rock-Forming Minerals (1992)."""

OPACITY_PER_MM = 30.0
"""A polycrystalline grain scatters light away on its many faces; it is taken to absorb it: 1e-13 left after a mm."""


@dataclass(frozen=True, kw_only=True)
class Stone(InWall):
    """A grain of refractory or unmelted batch in a halo of glass that has dissolved some of it.

    Parameters
    ----------
    diameter_mm : float
        Of the grain.
    halo_mm : float
        How far the halo reaches beyond the grain, along the surface; a third of that through the wall.
    halo_index_offset : float
        Of the halo's refractive index from the glass's; dissolved alumina or zirconia raises it, silica lowers it.
    mineral : str
        One of `MINERALS`.
    """

    kind: ClassVar[str] = "stone"
    description: ClassVar[str] = "an opaque grain of refractory or unmelted batch in a halo of another index"
    usual_severity: ClassVar[str] = "major"

    diameter_mm: float = 1.0
    halo_mm: float = 0.8
    halo_index_offset: float = 0.01
    mineral: str = "corundum"

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("diameter_mm", "halo_mm")
        object.__setattr__(self, "halo_index_offset", self._finite("halo_index_offset"))
        if self.mineral not in MINERALS:
            raise unknown_name(f"{self.kind}: mineral", self.mineral, MINERALS)

    def grains(self, site: Site) -> tuple[Grain, ...]:
        """Return the grain, and the halo around it."""
        centre, radius = site.at_depth_mm(self.depth_mm), 0.5 * self.diameter_mm
        grain = Substance(self.mineral, MINERALS[self.mineral], absorption_per_mm=OPACITY_PER_MM)
        halo = Substance("halo", index_offset=self.halo_index_offset)
        reach = radius + self.halo_mm * np.array([1.0, 1.0, 1.0 / 3.0])
        return (
            Grain(centre, np.full(3, radius), site.frame, grain),
            Grain(centre, reach, site.frame, halo),
        )
