"""The thickness asked along an outer meridian, and how fast it grows there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from glassworkbench.wall.asking.bore import Bore
from glassworkbench.wall.asking.thickness import ThicknessOverHeight

STEP_SHARE = 1e-7
"""Of the blend's height: the step of the difference that stands for the derivative of a bore's share."""


@dataclass(frozen=True, eq=False)
class AlongMeridian:
    """A thickness over height, and a bore where one is prescribed, as functions of the points of a meridian.

    Parameters
    ----------
    over_height : ThicknessOverHeight
    bore : Bore or None
    """

    over_height: ThicknessOverHeight
    bore: Bore | None = None

    @cached_property
    def knots_mm(self) -> np.ndarray:
        """Heights where the thickness is less smooth than elsewhere."""
        knots = self.over_height.heights_mm if len(self.over_height.heights_mm) > 1 else np.zeros(0)
        if self.bore is None:
            return knots
        return np.union1d(knots, [self.bore.none_below_mm, self.bore.full_from_mm])

    def at(self, points: np.ndarray, underside: np.ndarray | bool = False) -> np.ndarray:
        """Return the thickness (n,) in mm at points (n, 2); `underside` marks those inside the standing ring."""
        wall = self.over_height.at(points[:, 1], underside)
        return wall if self.bore is None else self.bore.thickness(points[:, 0], points[:, 1], wall)

    def growth(self, points: np.ndarray, tangents: np.ndarray, underside: np.ndarray | bool = False) -> np.ndarray:
        """Return the change (n,) of the thickness per mm along unit tangents (n, 2)."""
        height, rise = points[:, 1], tangents[:, 1]
        growth = self.over_height.slope(height, underside) * rise
        if self.bore is None:
            return growth
        share = self.bore.share(height)
        return (1.0 - share) * growth + share * tangents[:, 0] + self.blend_slope(points, underside) * rise

    def blend_slope(self, points: np.ndarray, underside: np.ndarray | bool = False) -> np.ndarray:
        """Return how much (n,) the inside comes inward per mm of height on its way to the bore."""
        bore, height = self.bore, points[:, 1]
        step = STEP_SHARE * (bore.full_from_mm - bore.none_below_mm)
        slope = (bore.share(height + step) - bore.share(height - step)) / (2.0 * step)
        return slope * (points[:, 0] - bore.radius_mm - self.over_height.at(height, underside))
