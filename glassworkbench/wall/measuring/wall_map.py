"""The wall over the whole outside, and over height: what a map shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.mold import Mold
from glassworkbench.mold.tessellation import MOUTH, outside_mesh
from glassworkbench.scene import Mesh
from glassworkbench.spatial import NearestTriangles
from glassworkbench.wall.measuring.outside import Outside, halved
from glassworkbench.wall.measuring.wall_over_height import WallOverHeight, wall_over_height

DEVIATION_MM = 0.05
"""Of the triangles that carry the colours."""

SIDE_SHARE = 0.012
"""No side of a coloured triangle is longer than this share of the container's height."""


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
        """Return the range that colours stand for: the wall over height, and no less than 10 % of it.

        Behind threads and sharp edges of the outside the way to the inside is longer; these share the last colour.
        """
        got = self.over_height.got_mm
        low, middle, high = np.nanmin(got), np.nanmedian(got), np.nanmax(got)
        return float(min(low, 0.95 * middle)), float(max(high, 1.05 * middle))


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
    # Without a stem, what stands level on the ground may lie below 0 by a rounding error, and is wall all the same.
    stem = (height < mold.anatomy.stem_top_mm) & (mold.anatomy.stem_top_mm > 0.0)
    thickness[mouth | (height > wall.lip_height_mm) | stem] = np.nan
    over_height = wall_over_height(inside, wall, stem_top_mm=mold.anatomy.stem_top_mm)
    return WallMap(corners, normals, thickness, over_height)


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
