"""Shortest distances from points to a polyline in the plane."""

from __future__ import annotations

import numpy as np


def distance_to_polyline(points: np.ndarray, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return distances (n,) and nearest points (n, 2).

    Parameters
    ----------
    points : array (n, 2)
    vertices : array (m, 2)
    """
    starts, along = vertices[:-1], np.diff(vertices, axis=0)
    squared = np.maximum(np.sum(along**2, axis=1), 1e-300)
    distances, feet = np.empty(len(points)), np.empty((len(points), 2))
    for first in range(0, len(points), 256):
        group = slice(first, first + 256)
        offset = points[group, None] - starts
        share = np.clip(np.einsum("ijk,jk->ij", offset, along) / squared, 0.0, 1.0)
        gap = np.linalg.norm(offset - share[:, :, None] * along, axis=2)
        nearest = gap.argmin(axis=1)
        row = np.arange(len(nearest))
        distances[group] = gap[row, nearest]
        feet[group] = starts[nearest] + share[row, nearest, None] * along[nearest]
    return distances, feet
