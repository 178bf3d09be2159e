"""The triangles of a body of patches as the tracer sees them: pieces of the exact surface with shared curved edges.

How they keep a ray from leaking is told in ``native/patch.hpp``; the native core and the numpy reference both start
from these tables.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.scene import Patches

GRID = 4
"""Parts of a triangle's sides between the points at which its bulge and its normals are sampled."""

BOX_MARGIN = 0.5
"""Share of the bulge by which a box is widened beyond the samples."""

CONE_MARGIN = 1.25
"""Factor on the largest angle between a triangle's sampled normals and their middle."""

TOWARDS_MIDDLE = 1e-7
"""Share of the way to a triangle's middle at which a collapsed edge's normal is taken: the limit, but for 1e-7 rad."""


@dataclass(frozen=True, eq=False)
class CurvedTriangles:
    """Tables with one row a triangle; edge k runs from corner k to the next.

    Parameters
    ----------
    corners_mm : array (m, 3, 3)
    middles_mm : array (m, 3, 3)
        The middle of each edge, on the surface; the same numbers for both triangles at the edge.
    along : bool array (m, 3)
        Whether the edge is run in the sense in which it is stored, which one of its triangles does.
    low_mm, high_mm : array (m, 3)
        A box around the curved triangle.
    cone_axis : array (m, 3), cone_sine : array (m,)
        A ray can be tangent to the triangle only if the sine of its angle with the plane across the axis is less.
    """

    corners_mm: np.ndarray
    middles_mm: np.ndarray
    along: np.ndarray
    low_mm: np.ndarray
    high_mm: np.ndarray
    cone_axis: np.ndarray
    cone_sine: np.ndarray

    @classmethod
    def of(cls, patches: Patches) -> CurvedTriangles:
        corners = patches.mesh.vertices_mm[patches.mesh.triangles]
        uv = patches.uv_of_corner
        count = len(corners)

        share = np.array([(i, j, GRID - i - j) for i in range(GRID + 1) for j in range(GRID + 1 - i)]) / GRID
        # Normals are taken a little inside, where no edge is collapsed.
        inner = share + TOWARDS_MIDDLE * (1.0 / 3.0 - share)
        sheet = np.repeat(patches.sheet_of_triangle, len(share))
        points = patches.evaluate(sheet, np.einsum("sk,mkc->msc", share, uv).reshape(-1, 2))[0]
        points = points.reshape(count, -1, 3)
        _, by_u, by_v = patches.evaluate(sheet, np.einsum("sk,mkc->msc", inner, uv).reshape(-1, 2))
        normals = _unit(np.cross(by_u, by_v)).reshape(count, -1, 3)

        axis = _unit(normals.sum(axis=1))
        angle = np.arccos(np.clip(np.einsum("mc,msc->ms", axis, normals).min(axis=1), -1.0, 1.0))
        sine = np.sin(np.minimum(CONE_MARGIN * angle + 1e-6, np.pi / 2.0))
        sine = np.where(np.einsum("mc,mc->m", axis, axis) > 0.5, sine, 1.0)

        middles, along = _edges(patches, corners)
        around = np.concatenate([corners, points, 2.0 * middles - 0.5 * (corners + np.roll(corners, -1, axis=1))], 1)
        low, high = around.min(axis=1), around.max(axis=1)
        flat = np.einsum("sk,mkc->msc", share, corners)
        bulge = np.abs(points - flat).max(axis=(1, 2))
        margin = BOX_MARGIN * bulge + 1e-12 * np.abs(corners).max()
        return cls(
            np.ascontiguousarray(corners),
            np.ascontiguousarray(middles),
            along,
            low - margin[:, None],
            high + margin[:, None],
            axis,
            sine,
        )


def _edges(patches: Patches, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the edges' middles and senses: see `CurvedTriangles`.

    The sheets on both sides of an edge know a middle each; the edge has the mean of them.
    """
    uv = patches.uv_of_corner
    middle_uv = 0.5 * (uv + np.roll(uv, -1, axis=1))
    sheet = np.repeat(patches.sheet_of_triangle, 3)
    middles = patches.evaluate(sheet, middle_uv.reshape(-1, 2))[0]
    _, place = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    start = place.reshape(-1)
    end = np.roll(start.reshape(-1, 3), -1, axis=1).reshape(-1)
    pairs = np.stack([np.minimum(start, end), np.maximum(start, end)], axis=1)
    _, edge = np.unique(pairs, axis=0, return_inverse=True)
    edge = edge.reshape(-1)
    sums = np.zeros((edge.max() + 1, 3))
    np.add.at(sums, edge, middles)
    middles = (sums / np.bincount(edge)[:, None])[edge]
    return middles.reshape(-1, 3, 3), (start <= end).reshape(-1, 3)


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)
