"""The wall got and asked over the height of the inner surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.scene import Mesh
from glassworkbench.wall.measuring.measure import LEVEL_MM, in_finish_plane, wall_at
from glassworkbench.wall.measuring.outside import Outside
from glassworkbench.wall.measuring.surface import at_level, facets, spread

LEVELS, POINTS_AROUND = 200, 120
"""Steps of the height in which the wall is told, and points of the inside at each."""

FLAT, POINTS_ON_FLAT = 0.9, 4000
"""Where the inside's normal rises or falls by more than this, it may lie between two levels: points on it are added."""


@dataclass(frozen=True, eq=False)
class WallOverHeight:
    """The wall in steps of the height, but for a rounded lip and what `WallAtPoints.free` marks.

    Parameters
    ----------
    edges_mm : array (n + 1,)
        Ends of the steps, ascending.
    got_mm, asked_mm : array (n, 2)
        The thinnest and the thickest wall all around at each, both toward the outer points that decide; NaN where
        there is no inner surface.
    """

    edges_mm: np.ndarray
    got_mm: np.ndarray
    asked_mm: np.ndarray

    @property
    def heights_mm(self) -> np.ndarray:
        """The steps' middles (n,)."""
        return 0.5 * (self.edges_mm[1:] + self.edges_mm[:-1])


def wall_over_height(inside: Mesh, wall: Outside, *, stem_top_mm: float = 0.0) -> WallOverHeight:
    """Return the wall over height; the parameters are those of `measure_wall`."""
    edges = np.linspace(0.0, wall.finish_height_mm, LEVELS + 1)
    wanted = ~in_finish_plane(inside)
    points = [at_level(inside, wanted, height, POINTS_AROUND) for height in 0.5 * (edges[1:] + edges[:-1])]
    normals = facets(inside.vertices_mm[inside.triangles])
    flat = wanted & (np.abs(normals[:, 2]) > FLAT * np.linalg.norm(normals, axis=1))
    if np.any(flat):
        points.append(spread(inside, flat, POINTS_ON_FLAT))
    found = wall_at(np.concatenate(points), wall, stem_top_mm=stem_top_mm)
    counts = ~found.free
    if wall.lip_height_mm < wall.finish_height_mm - LEVEL_MM:
        counts &= found.below_lip(wall)
    step = np.clip(np.searchsorted(edges, found.points_mm[counts, 2], side="right") - 1, 0, LEVELS - 1)
    asked = found.asked_mm[counts]
    return WallOverHeight(edges, _extremes(step, asked + found.deviation_mm[counts]), _extremes(step, asked))


def _extremes(step: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the smallest and the largest value (LEVELS, 2) of each step, NaN for one that has none."""
    ends = np.full((LEVELS, 2), np.nan)
    np.fmin.at(ends[:, 0], step, values)
    np.fmax.at(ends[:, 1], step, values)
    return ends
