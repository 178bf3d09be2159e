"""The underside of a container: the base inside the ring it stands on, however high it is pushed up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.mold import Mold
from glassworkbench.mold.measures import mesh_of
from glassworkbench.mold.meridian import points

LEVEL_SHARE = 1e-6
"""What is within this share of the height of the lowest point belongs to the ring."""

NEAR_SHARE = 2e-3
"""A point this share of the height above the underside still belongs to it."""

RING_SHARE = 2e-4
"""A container that is not round stands on what is this near (share of its height) to the lowest point."""


@dataclass(frozen=True, eq=False)
class Underside:
    """Where the ring is and how high the base rises inside it.

    Parameters
    ----------
    ring_mm : array (n, 2)
        Corners of the ring, counter-clockwise about the axis from -180 degrees on; one corner (r, 0) means a circle.
    radii_mm, heights_mm : array (m,)
        The base's height at each radius, for a round one; it holds the end values beyond.
    near_mm : float
        How far above that a point still counts.
    """

    ring_mm: np.ndarray
    radii_mm: np.ndarray
    heights_mm: np.ndarray
    near_mm: float

    def holds(self, points_mm: np.ndarray) -> np.ndarray:
        """Return which outer points (n, 3), upright, lie on the underside."""
        radius = np.hypot(points_mm[:, 0], points_mm[:, 1])
        base = np.interp(radius, self.radii_mm, self.heights_mm)
        return (radius < self.ring_radius(points_mm)) & (points_mm[:, 2] <= base + self.near_mm)

    def ring_radius(self, points_mm: np.ndarray) -> np.ndarray:
        """Return the distance of the ring from the axis (n,) in the directions of points (n, 3)."""
        if len(self.ring_mm) == 1:
            return np.full(len(points_mm), self.ring_mm[0, 0])
        x, y = points_mm[:, 0], points_mm[:, 1]
        angles = np.arctan2(self.ring_mm[:, 1], self.ring_mm[:, 0])
        after = np.searchsorted(angles, np.arctan2(y, x), side="right") % len(angles)
        p, q = self.ring_mm[after - 1], self.ring_mm[after]
        side = q - p
        radius = np.hypot(x, y)
        crossing = (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]) * radius
        towards = x * side[:, 1] - y * side[:, 0]
        return np.where(towards > 0.0, crossing / np.where(towards > 0.0, towards, 1.0), np.inf)


def underside_of(mold: Mold) -> Underside:
    """Return the underside of a mold."""
    height = mold.anatomy.height_mm
    if mold.is_nearly_round:
        outline = points(mold.core, 64)
        last = int(np.flatnonzero(outline[:, 1] <= LEVEL_SHARE * height)[-1])
        base = outline[: last + 1]
        order = np.argsort(base[:, 0], kind="stable")
        return Underside(base[-1:] * [1.0, 0.0], base[order, 0], base[order, 1], NEAR_SHARE * height)
    ring = _ring(mold)
    top = np.array([max(mold.anatomy.push_up_mm, 0.0)])
    return Underside(ring, np.zeros(1), top, NEAR_SHARE * height)


def _ring(mold: Mold) -> np.ndarray:
    """Return the corners (n, 2) of the convex outline of what a mold that is not round stands on."""
    vertices = mesh_of(mold.upright)[0] if mold.mesh is None else mold.mesh.vertices_mm
    outline = _convex_outline(vertices[vertices[:, 2] <= RING_SHARE * mold.anatomy.height_mm, :2])
    after = np.roll(outline, -1, axis=0)
    if len(outline) > 2 and np.all(outline[:, 0] * after[:, 1] - outline[:, 1] * after[:, 0] > 0.0):
        return outline[np.argsort(np.arctan2(outline[:, 1], outline[:, 0]))]
    # What does not go round the axis says less than the mean radius of what the container stands on.
    return np.array([[mold.anatomy.bearing_radius_mm, 0.0]])


def _convex_outline(points: np.ndarray) -> np.ndarray:
    """Return the corners (k, 2) of the convex hull, counter-clockwise: Andrew, Inf. Process. Lett. 9 (1979) 216."""
    ordered = np.unique(points, axis=0)
    chains = []
    for direction in (ordered, ordered[::-1]):
        chain: list[np.ndarray] = []
        for point in direction:
            while len(chain) > 1:
                (x, y), (u, v) = chain[-1] - chain[-2], point - chain[-2]
                if x * v - y * u > 0.0:
                    break
                chain.pop()
            chain.append(point)
        chains += chain[:-1]
    return np.array(chains).reshape(-1, 2)
