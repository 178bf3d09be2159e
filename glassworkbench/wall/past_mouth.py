"""A cavity's mesh continued past the mouth, as the tracer takes it away from the outside."""

from __future__ import annotations

import numpy as np

from glassworkbench.scene import Mesh

PAST_MOUTH_MM = 5.0
"""How far the tracer's cavity reaches above the finish."""

LEVEL_MM = 1e-6


def past_mouth(inside: Mesh, finish_height_mm: float) -> Mesh:
    """Return a mesh that is closed level at the finish plane, its lid lifted and joined by an upright band."""
    points, triangles = inside.vertices_mm, inside.triangles
    level = np.abs(points[:, 2] - finish_height_mm) < LEVEL_MM
    lid = level[triangles].all(axis=1)
    _, place = np.unique(points, axis=0, return_inverse=True)
    place = place.reshape(-1)[triangles]
    walls, cover = triangles[~lid], triangles[lid]
    sides = _directed(walls)
    starts, ends = _directed(place[~lid]).T
    free = ~np.isin(starts * len(points) + ends, ends * len(points) + starts)
    p, q = sides[free].T
    up = np.array([0.0, 0.0, PAST_MOUTH_MM])
    normals = inside.normals * np.array([1.0, 1.0, 0.0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    count = len(p)
    band = np.concatenate([points[p], points[q], points[p] + up, points[q] + up])
    k = np.arange(count) + len(points)
    # The walls run from p to q along their free side, so the band runs back.
    strips = np.concatenate(
        [np.column_stack([k + count, k, k + 2 * count]), np.column_stack([k + count, k + 2 * count, k + 3 * count])]
    )
    raised = points[cover.ravel()] + up
    return _compact(
        np.concatenate([points, band, raised]),
        np.concatenate([walls, strips, np.arange(len(raised)).reshape(-1, 3) + len(points) + 4 * count]),
        np.concatenate([inside.normals, normals[p], normals[q], normals[p], normals[q], inside.normals[cover.ravel()]]),
    )


def _directed(triangles: np.ndarray) -> np.ndarray:
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


def _compact(points: np.ndarray, triangles: np.ndarray, normals: np.ndarray) -> Mesh:
    both = np.column_stack([points, normals])
    both, place = np.unique(both, axis=0, return_inverse=True)
    used, triangles = np.unique(place.reshape(-1)[triangles], return_inverse=True)
    return Mesh(both[used, :3], triangles.reshape(-1, 3), both[used, 3:])
