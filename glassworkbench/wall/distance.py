"""Shortest distances from points to a polyline in the plane and to a triangle mesh in space."""

from __future__ import annotations

import numpy as np

BLOCK = 32
"""Triangles that share one bounding box; small enough to look at all, large enough to skip many at once."""


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


def nearest_on_mesh(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the nearest points (n, 3) of triangles, the triangles' numbers (n,) and barycentric coordinates (n, 3).

    Parameters
    ----------
    points : array (n, 3)
    triangles : array (m, 3, 3)
        Corners of each triangle.
    """
    order = _along_a_curve(triangles.mean(axis=1))
    triangles = triangles[order]
    edges = np.arange(0, len(triangles), BLOCK)
    low = np.minimum.reduceat(triangles.min(axis=1), edges, axis=0)
    high = np.maximum.reduceat(triangles.max(axis=1), edges, axis=0)
    numbers, shares = np.empty(len(points), dtype=int), np.empty((len(points), 3))
    for number, point in enumerate(points):
        outside = np.maximum(np.maximum(low - point, point - high), 0.0)
        bound = np.einsum("ij,ij->i", outside, outside)
        # A few near boxes give a distance that rules out nearly all the others.
        near = np.argpartition(bound, 3)[:4] if len(bound) > 4 else np.arange(len(bound))
        best = _nearest_in_blocks(point, triangles, edges[near])[0]
        _, numbers[number], shares[number] = _nearest_in_blocks(
            point, triangles, edges[(bound <= best) | (np.arange(len(bound)) == near[0])]
        )
    feet = np.einsum("ij,ijk->ik", shares, triangles[numbers])
    return feet, order[numbers], shares


def _nearest_in_blocks(point: np.ndarray, triangles: np.ndarray, starts: np.ndarray) -> tuple[float, int, np.ndarray]:
    rows = (starts[:, None] + np.arange(BLOCK)).ravel()
    rows = rows[rows < len(triangles)]
    squared, shares = _nearest_on_triangles(point, triangles[rows])
    k = int(np.argmin(squared))
    return float(squared[k]), int(rows[k]), shares[k]


def _along_a_curve(centres: np.ndarray) -> np.ndarray:
    """Return an order (Morton's) in which neighbours in the list are neighbours in space."""
    size = max(float(np.ptp(centres, axis=0).max()), 1e-300)
    cells = ((centres - centres.min(axis=0)) / size * 1023.0).astype(np.int64)
    keys = np.zeros(len(cells), dtype=np.int64)
    for bit in range(10):
        for axis in range(3):
            keys |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(keys, kind="stable")


def _nearest_on_triangles(point: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return squared distances (m,) and the barycentric coordinates (m, 3) of the nearest point of each triangle.

    It is the foot on the triangle's plane if that lies inside, else the nearest point of its edges.
    """
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    ab, ac, ap = b - a, c - a, point - a
    d00, d01, d11 = (np.einsum("ij,ij->i", p, q) for p, q in ((ab, ab), (ab, ac), (ac, ac)))
    d20, d21 = np.einsum("ij,ij->i", ap, ab), np.einsum("ij,ij->i", ap, ac)
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = d00 * d11 - d01 * d01
        v = (d11 * d20 - d01 * d21) / determinant
        w = (d00 * d21 - d01 * d20) / determinant
        inside = (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0)
        gap = ap - v[:, None] * ab - w[:, None] * ac
    squared = np.where(inside, np.einsum("ij,ij->i", gap, gap), np.inf)
    shares = np.column_stack([1.0 - v - w, v, w])
    for i, j in ((0, 1), (1, 2), (2, 0)):
        start, along = triangles[:, i], triangles[:, j] - triangles[:, i]
        share = np.einsum("ij,ij->i", point - start, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
        share = np.clip(share, 0.0, 1.0)
        gap = point - start - share[:, None] * along
        edge_squared = np.einsum("ij,ij->i", gap, gap)
        nearer = edge_squared < squared
        squared[nearer] = edge_squared[nearer]
        shares[nearer] = 0.0
        shares[nearer, i], shares[nearer, j] = 1.0 - share[nearer], share[nearer]
    return squared, shares
