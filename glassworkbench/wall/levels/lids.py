"""The level lid of a cavity's mesh: lifted to the finish plane, or past the mouth as the tracer takes it away."""

from __future__ import annotations

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.scene import Mesh

PAST_MOUTH_MM = 5.0
"""How far the tracer's cavity reaches above the finish."""

LEVEL_MM = 1e-6
"""Vertices this near to a height lie at it."""


def lifted(mesh: Mesh, level_mm: float, rise_mm: float) -> Mesh:
    """Return an upright closed mesh with the triangles at its top lifted, and an upright band that joins them.

    Parameters
    ----------
    mesh : Mesh
    level_mm : float
        Height of the lid.
    rise_mm : float
        How far it is lifted.

    Raises
    ------
    GlassWorkbenchError
        If nothing of the mesh lies level there.
    """
    points, triangles = mesh.vertices_mm, mesh.triangles
    lid = (np.abs(points[:, 2] - level_mm) < LEVEL_MM)[triangles].all(axis=1)
    if not lid.any():
        raise GlassWorkbenchError(f"the cavity has no level mouth at height {level_mm:.1f} mm")
    _, place = np.unique(points, axis=0, return_inverse=True)
    place = place.reshape(-1)[triangles]
    starts, ends = _directed(place[~lid]).T
    free = ~np.isin(starts * len(points) + ends, ends * len(points) + starts)
    # The walls run from p to q along their free sides, so the band runs back.
    p, q = _directed(triangles[~lid])[free].T
    up = np.array([0.0, 0.0, rise_mm])
    normals = mesh.normals * np.array([1.0, 1.0, 0.0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    band = np.concatenate([points[p], points[q], points[p] + up, points[q] + up])
    low_p, low_q, high_p, high_q = len(points) + np.arange(4 * len(p)).reshape(4, -1)
    cover = triangles[lid].ravel()
    return _compact(
        np.concatenate([points, band, points[cover] + up]),
        np.concatenate(
            [
                triangles[~lid],
                np.column_stack([low_q, low_p, high_p]),
                np.column_stack([low_q, high_p, high_q]),
                np.arange(len(cover)).reshape(-1, 3) + len(points) + len(band),
            ]
        ),
        np.concatenate([mesh.normals, np.tile(normals[np.concatenate([p, q])], (2, 1)), mesh.normals[cover]]),
    )


def _directed(triangles: np.ndarray) -> np.ndarray:
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


def _compact(points: np.ndarray, triangles: np.ndarray, normals: np.ndarray) -> Mesh:
    """Return a mesh of the vertices that are used, each pair of position and normal stored once."""
    both, place = np.unique(np.column_stack([points, normals]), axis=0, return_inverse=True)
    used, triangles = np.unique(place.reshape(-1)[triangles], return_inverse=True)
    return Mesh(both[used, :3], triangles.reshape(-1, 3), both[used, 3:])
