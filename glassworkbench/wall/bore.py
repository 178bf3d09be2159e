"""A prescribed bore: in the finish the inside is a cylinder about the axis, whatever the outside does there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Bore:
    """A bore in one particular mold.

    Parameters
    ----------
    radius_mm : float
    full_from_mm : float
        Above this height the inside is the cylinder: the lower end of the finish.
    none_below_mm : float
        Below this height the wall is as asked without a bore; in between the one becomes the other, smoothly.

    Notes
    -----
    An outer point at radius r that asks for the thickness r - R keeps a ball free whose nearest point to the axis is
    at radius R and at the same height. The balls of all outer points above a height therefore leave exactly the
    cylinder of radius R, also under rings and threads: to whoever offsets the outside, the bore is a thickness.
    """

    radius_mm: float
    full_from_mm: float
    none_below_mm: float

    def share(self, height_mm: np.ndarray) -> np.ndarray:
        """Return how far the bore decides at each height: 1 in the finish, 0 below the blend."""
        share = np.clip((height_mm - self.none_below_mm) / (self.full_from_mm - self.none_below_mm), 0.0, 1.0)
        return share * share * (3.0 - 2.0 * share)

    def thickness(self, radius_mm: np.ndarray, height_mm: np.ndarray, wall_mm: np.ndarray) -> np.ndarray:
        """Return the thickness asked at outer points that ask for `wall_mm` where no bore is."""
        share = self.share(height_mm)
        return share * (radius_mm - self.radius_mm) + (1.0 - share) * wall_mm
