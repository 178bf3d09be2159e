"""The cavity that is wanted, between a level floor and the plane of the mouth, as a function with a known gradient."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.wall.measuring.outside import Outside

NEWTON_MM = 1e-7
"""Points nearer to the level than this are on it."""

NEWTON_STEPS = 8


@dataclass(frozen=True, eq=False)
class Room:
    """How far inside the cavity points lie: the clearance, and the distances from ceiling and floor.

    Parameters
    ----------
    wall : Outside
    ceiling_mm, floor_mm : float
        Heights between which the cavity is.
    """

    wall: Outside
    ceiling_mm: float
    floor_mm: float = -np.inf

    def value(self, points_mm: np.ndarray) -> np.ndarray:
        """Return how far inside points (n, 3) lie (n,): 0 on the surface, below 0 outside."""
        heights = points_mm[:, 2]
        level = np.minimum(self.ceiling_mm - heights, heights - self.floor_mm)
        return np.minimum(self.wall.clearance(points_mm).clearance_mm, level)

    def value_and_gradient(self, points_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the values (n,) of points (n, 3) and the unit vectors (n, 3) along which they grow.

        Where |p - s| - t(s) is lowest over s, its derivative with respect to s is zero, so that along p is all there is
        of the clearance's: the unit vector from s to p, also where the thickness varies.
        """
        found = self.wall.clearance(points_mm)
        value = found.clearance_mm.copy()
        gradient = (points_mm - found.feet_mm) / np.maximum(found.distance_mm, 1e-300)[:, None]
        for level, up in (
            (self.ceiling_mm - points_mm[:, 2], [0.0, 0.0, -1.0]),
            (points_mm[:, 2] - self.floor_mm, [0.0, 0.0, 1.0]),
        ):
            lower = level < value
            value[lower], gradient[lower] = level[lower], up
        return value, gradient

    def on_surface(self, points_mm: np.ndarray, steps: int = NEWTON_STEPS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return points (n, 3) moved to the surface, their values (n,) and gradients (n, 3) there.

        From inside one step along the gradient meets the surface exactly: the function falls as fast as it may.
        """
        points = np.array(points_mm)
        value, gradient = self.value_and_gradient(points)
        for _ in range(steps):
            off = np.flatnonzero(np.abs(value) > NEWTON_MM)
            if len(off) == 0:
                break
            points[off] -= value[off, None] * gradient[off]
            value[off], gradient[off] = self.value_and_gradient(points[off])
        return points, value, gradient
