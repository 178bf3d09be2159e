"""Gas that stayed in the glass: seeds and blisters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from glassworkbench.flaws.defect import AIR, Grain, InWall, Site


@dataclass(frozen=True, kw_only=True)
class Seed(InWall):
    """A small round bubble, left from melting.

    Parameters
    ----------
    diameter_mm : float
    """

    kind: ClassVar[str] = "seed"
    description: ClassVar[str] = "a small round bubble, left from melting"

    diameter_mm: float = 0.5

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("diameter_mm")

    def grains(self, site: Site) -> tuple[Grain, ...]:
        """Return a ball of air."""
        return (Grain(site.at_depth_mm(self.depth_mm), np.full(3, 0.5 * self.diameter_mm), site.frame, AIR),)


@dataclass(frozen=True, kw_only=True)
class Blister(InWall):
    """A large bubble, drawn out and flattened with the parison.

    Parameters
    ----------
    length_mm, width_mm, thickness_mm : float
        Up along the surface, horizontally along it, and through the wall.
    """

    kind: ClassVar[str] = "blister"
    description: ClassVar[str] = "a large bubble, drawn out and flattened with the parison"
    usual_severity: ClassVar[str] = "major"

    length_mm: float = 5.0
    width_mm: float = 3.0
    thickness_mm: float = 0.8

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("length_mm", "width_mm", "thickness_mm")

    def grains(self, site: Site) -> tuple[Grain, ...]:
        """Return an ellipsoid of air."""
        semi_axes = 0.5 * np.array([self.width_mm, self.length_mm, self.thickness_mm])
        return (Grain(site.at_depth_mm(self.depth_mm), semi_axes, site.frame, AIR),)
