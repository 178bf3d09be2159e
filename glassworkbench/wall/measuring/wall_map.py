"""The wall over the whole outside, and over height: what a map shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.mold import Mold
from glassworkbench.mold.tessellation import MOUTH, outside_mesh
from glassworkbench.scene import Mesh
from glassworkbench.spatial import NearestTriangles
from glassworkbench.wall.measuring.measure import LEVEL_MM, in_finish_plane, wall_at
from glassworkbench.wall.measuring.outside import Outside, halved
from glassworkbench.wall.measuring.surface import at_level, facets

DEVIATION_MM = 0.05
"""Of the triangles that carry the colours."""

SIDE_SHARE = 0.012
"""No side of a coloured triangle is longer than this share of the container's height."""

LEVELS, POINTS_AROUND = 200, 120
"""Heights at which the wall is told, and points of the inside at each."""


@dataclass(frozen=True, eq=False)
class WallMap:
    """The thickness of the wall, seen from outside.

    Parameters
    ----------
    corners_mm, normals : array (m, 3, 3)
        Of triangles of the outside, upright, and the outside's unit normals there.
    thickness_mm : array (m, 3)
        From each corner to the inside. NaN where there is no wall: over the mouth, on the lip's rounding, a
        stem and its foot.
    over_height : WallOverHeight
    """

    corners_mm: np.ndarray
    normals: np.ndarray
    thickness_mm: np.ndarray
    over_height: WallOverHeight

    def span_mm(self) -> tuple[float, float]:
        """Return the range that colours stand for: nearly all of the wall, and no less than 10 % of it."""
        thickness = self.thickness_mm.mean(axis=1)
        order = np.argsort(thickness)[: np.count_nonzero(np.isfinite(thickness))]
        area = np.cumsum(np.linalg.norm(facets(self.corners_mm[order]), axis=1))
        low, middle, high = thickness[order[np.searchsorted(area, area[-1] * np.array([0.01, 0.5, 0.99]))]]
        return float(min(low, 0.95 * middle)), float(max(high, 1.05 * middle))


@dataclass(frozen=True, eq=False)
class WallOverHeight:
    """The wall at levels, as far as there are inner points at them.

    Parameters
    ----------
    heights_mm : array (n,)
        Ascending.
    got_mm, asked_mm : array (n, 2)
        The thinnest and the thickest wall around the container at each level.
    """

    heights_mm: np.ndarray
    got_mm: np.ndarray
    asked_mm: np.ndarray


def wall_map(mold: Mold, inside: Mesh, wall: Outside) -> WallMap:
    """Return the map of a container's wall.

    Parameters
    ----------
    mold : Mold
    inside : Mesh
        The cavity, upright, closed level at the finish plane.
    wall : Outside
        With the thickness asked on it.
    """
    mesh, faces = outside_mesh(mold, DEVIATION_MM)
    corners, normals = mesh.vertices_mm[mesh.triangles], mesh.normals[mesh.triangles]
    mouth = np.isin(faces, (mold.anatomy.finish_face, MOUTH)) & (faces != 0)
    corners, normals, mouth = _short_sided(corners, normals, mouth, SIDE_SHARE * mold.anatomy.height_mm)
    keys = np.round(corners.reshape(-1, 3) * 1e5).astype(np.int64)
    _, first, place = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    points = corners.reshape(-1, 3)[first]
    into = NearestTriangles(inside.vertices_mm[inside.triangles], inside.normals[inside.triangles])
    thickness = into.search(points).distance_mm[place.reshape(-1)].reshape(-1, 3)
    height = corners[:, :, 2].mean(axis=1)
    thickness[mouth | (height > wall.lip_height_mm) | (height < mold.anatomy.stem_top_mm)] = np.nan
    return WallMap(corners, normals, thickness, _over_height(mold, inside, wall))


def _short_sided(
    corners: np.ndarray, normals: np.ndarray, marked: np.ndarray, longest_mm: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    done = []
    while len(corners):
        lengths = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        long = lengths.max(axis=1) > longest_mm
        done.append((corners[~long], normals[~long], marked[~long]))
        corners, normals = halved(corners[long], normals[long], lengths[long].argmax(axis=1))
        marked = np.concatenate([marked[long], marked[long]])
    return tuple(np.concatenate(part) for part in zip(*done, strict=True))


def _over_height(mold: Mold, inside: Mesh, wall: Outside) -> WallOverHeight:
    # On a rounded lip, and as far below as it reaches inside, the wall is not what was asked.
    top = wall.finish_height_mm
    if wall.lip_height_mm < top - LEVEL_MM:
        top = wall.lip_height_mm - float(wall.thickness_mm[wall.collar].max())
    heights = (np.arange(LEVELS) + 0.5) / LEVELS * top
    wanted = ~in_finish_plane(inside)
    around = [at_level(inside, wanted, height, POINTS_AROUND) for height in heights]
    counts = np.array([len(points) for points in around])
    found = wall_at(np.concatenate(around), wall, stem_top_mm=mold.anatomy.stem_top_mm)
    starts = (np.cumsum(counts) - counts)[counts > 0]

    def extremes(values: np.ndarray) -> np.ndarray:
        return np.column_stack([extreme.reduceat(values, starts) for extreme in (np.minimum, np.maximum)])

    return WallOverHeight(heights[counts > 0], extremes(found.distance_mm), extremes(found.asked_mm))
