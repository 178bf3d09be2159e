"""Shortest distances from points to a polyline in the plane and to a triangle mesh in space."""

from __future__ import annotations

import numpy as np

BLOCK = 32
"""Triangles that share one bounding box; small enough to look at all, large enough to skip many at once."""


def distance_to_polyline(points: np.ndarray, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return distances (n,), nearest points (n, 2) and the numbers (n,) of the polyline's segments they lie on.

    Parameters
    ----------
    points : array (n, 2)
    vertices : array (m, 2)
    """
    starts, along = vertices[:-1], np.diff(vertices, axis=0)
    squared = np.maximum(np.sum(along**2, axis=1), 1e-300)
    distances, feet, numbers = np.empty(len(points)), np.empty((len(points), 2)), np.empty(len(points), dtype=int)
    for first in range(0, len(points), 256):
        group = slice(first, first + 256)
        offset = points[group, None] - starts
        share = np.clip(np.einsum("ijk,jk->ij", offset, along) / squared, 0.0, 1.0)
        gap = np.linalg.norm(offset - share[:, :, None] * along, axis=2)
        nearest = gap.argmin(axis=1)
        row = np.arange(len(nearest))
        distances[group] = gap[row, nearest]
        feet[group] = starts[nearest] + share[row, nearest, None] * along[nearest]
        numbers[group] = nearest
    return distances, feet, numbers


def distance_to_mesh(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return distances (n,) and nearest points (n, 3).

    Parameters
    ----------
    points : array (n, 3)
    triangles : array (m, 3, 3)
        Corners of each triangle.
    """
    triangles = triangles[_along_a_curve(triangles.mean(axis=1))]
    edges = np.arange(0, len(triangles), BLOCK)
    low = np.minimum.reduceat(triangles.min(axis=1), edges, axis=0)
    high = np.maximum.reduceat(triangles.max(axis=1), edges, axis=0)
    distances, feet = np.empty(len(points)), np.empty((len(points), 3))
    for number, point in enumerate(points):
        outside = np.maximum(np.maximum(low - point, point - high), 0.0)
        bound = np.einsum("ij,ij->i", outside, outside)
        best = np.inf
        # The few nearest boxes give a distance that rules out nearly all the others.
        for blocks in (np.argpartition(bound, 3)[:4] if len(bound) > 4 else np.arange(len(bound)), None):
            if blocks is None:
                blocks = np.flatnonzero(bound < best)
            rows = (edges[blocks][:, None] + np.arange(BLOCK)).ravel()
            rows = rows[rows < len(triangles)]
            if len(rows) == 0:
                continue
            nearest = _nearest_on_triangles(point, triangles[rows])
            squared = np.sum((nearest - point) ** 2, axis=1)
            k = int(np.argmin(squared))
            if squared[k] < best:
                best, feet[number] = squared[k], nearest[k]
        distances[number] = np.sqrt(best)
    return distances, feet


def _along_a_curve(centres: np.ndarray) -> np.ndarray:
    """Return an order (Morton's) in which neighbours in the list are neighbours in space."""
    size = max(float(np.ptp(centres, axis=0).max()), 1e-300)
    cells = ((centres - centres.min(axis=0)) / size * 1023.0).astype(np.int64)
    keys = np.zeros(len(cells), dtype=np.int64)
    for bit in range(10):
        for axis in range(3):
            keys |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(keys, kind="stable")


def _nearest_on_triangles(point: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the nearest point (m, 3) on each triangle: the foot on its plane, or else the nearest on its edges."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    ab, ac, ap = b - a, c - a, point - a
    d00, d01, d11 = (np.einsum("ij,ij->i", p, q) for p, q in ((ab, ab), (ab, ac), (ac, ac)))
    d20, d21 = np.einsum("ij,ij->i", ap, ab), np.einsum("ij,ij->i", ap, ac)
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = d00 * d11 - d01 * d01
        v = (d11 * d20 - d01 * d21) / determinant
        w = (d00 * d21 - d01 * d20) / determinant
        inside = (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0)
    best = np.full((len(a), 3), np.inf)
    best[inside] = (a + v[:, None] * ab + w[:, None] * ac)[inside]
    squared = np.sum((best - point) ** 2, axis=1)
    for start, along in ((a, ab), (b, c - b), (c, a - c)):
        share = np.einsum("ij,ij->i", point - start, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
        foot = start + np.clip(share, 0.0, 1.0)[:, None] * along
        gap = np.sum((foot - point) ** 2, axis=1)
        nearer = ~(squared <= gap)
        best[nearer], squared[nearer] = foot[nearer], gap[nearer]
    return best
