"""Where a surface crosses itself or another: OCC calls folded cavities valid, and a picture of them is ruined."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from glassworkbench.freecad import Part
from glassworkbench.scene import Mesh
from glassworkbench.spatial import SIDES
from glassworkbench.spatial.nearest import along_a_curve

WELD_MM = 1e-5
"""Vertices that agree to this are one."""

TOUCHING_MM = 1e-5
"""Triangles that reach through each other by less than this only touch."""

PAIRS_AT_ONCE = 1_000_000

MOST_CHECKED = 200
"""Shapes of more faces are not searched by OCC: that takes minutes."""


def self_intersections(mesh: Mesh) -> np.ndarray:
    """Return a place (k, 3) for each two triangles of a mesh that cross; see `crossing_places`."""
    return crossing_places(mesh.vertices_mm[mesh.triangles])


def crossing_places(corners: np.ndarray) -> np.ndarray:
    """Return a place (k, 3) for each two of the triangles (m, 3, 3) that cross without sharing a vertex.

    Triangles that only touch, and neighbours, are none. Lying in each other in one plane is not found, but where such
    a patch ends its sides cross.
    """
    keys = np.round(corners.reshape(-1, 3) / WELD_MM).astype(np.int64)
    vertex = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1, 3)
    places = []
    for i, j in _near_pairs(corners, corners):
        apart = (i != j) & ~np.any(vertex[i][:, :, None] == vertex[j][:, None, :], axis=(1, 2))
        places.append(_crossings(corners[i[apart]], corners[j[apart]]))
    return np.concatenate(places) if places else np.zeros((0, 3))


def faces_cross(shape: Part.Shape) -> bool:
    """Return whether faces of a shape cross, as far as OCC finds out; `MOST_CHECKED` faces are looked at, at most.

    OCC says so of edges, too, that lie in each other, like the two sides of a seam in an IGES file: they are no fault.
    """
    if len(shape.Faces) > MOST_CHECKED:
        return False
    try:
        shape.check(True)
    except ValueError as error:
        return "Face: BOPAlgo SelfIntersect" in str(error)
    return False


def intersections(first: Mesh, second: Mesh) -> np.ndarray:
    """Return a place (k, 3) for each triangle of one mesh and one of another that cross; see `self_intersections`."""
    one, other = first.vertices_mm[first.triangles], second.vertices_mm[second.triangles]
    places = [_crossings(one[i], other[j]) for i, j in _near_pairs(one, other)]
    return np.concatenate(places) if places else np.zeros((0, 3))


class _Boxes:
    """A binary tree of boxes over triangles, as one array a level, from the whole to single triangles."""

    def __init__(self, corners: np.ndarray) -> None:
        self.order = along_a_curve(corners.mean(axis=1))
        low, high = corners.min(axis=1)[self.order], corners.max(axis=1)[self.order]
        self.levels = [(low, high)]
        while len(low) > 1:
            pairs = np.arange(0, len(low), 2)
            low, high = np.minimum.reduceat(low, pairs, axis=0), np.maximum.reduceat(high, pairs, axis=0)
            self.levels.insert(0, (low, high))

    def at(self, depth: int) -> tuple[np.ndarray, np.ndarray]:
        return self.levels[min(depth, len(self.levels) - 1)]

    def children(self, nodes: np.ndarray, depth: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the two nodes each (n, 2) at the next depth, and which of them there are."""
        if depth >= len(self.levels) - 1:
            return np.column_stack([nodes, nodes]), np.tile([True, False], (len(nodes), 1))
        both = 2 * nodes[:, None] + np.arange(2)
        return both, both < len(self.levels[depth + 1][0])


def _near_pairs(first: np.ndarray, second: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield numbers (n,), (n,) of triangles of two sets whose boxes overlap; within one set, each pair once."""
    same = first is second
    one = _Boxes(first)
    other = one if same else _Boxes(second)
    depths = max(len(one.levels), len(other.levels)) - 1
    waiting = [(0, np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64))]
    while waiting:
        depth, a, b = waiting.pop()
        if depth == depths:
            yield one.order[a], other.order[b]
            continue
        (a, has_a), (b, has_b) = one.children(a, depth), other.children(b, depth)
        a, b = np.repeat(a, 2, axis=1), np.tile(b, (1, 2))
        there = np.repeat(has_a, 2, axis=1) & np.tile(has_b, (1, 2))
        if same:
            there &= a <= b
        a, b = a[there], b[there]
        (low_a, high_a), (low_b, high_b) = one.at(depth + 1), other.at(depth + 1)
        for axis in range(3):
            meet = (low_a[a, axis] <= high_b[b, axis]) & (low_b[b, axis] <= high_a[a, axis])
            a, b = a[meet], b[meet]
        for start in range(0, len(a), PAIRS_AT_ONCE):
            waiting.append((depth + 1, a[start : start + PAIRS_AT_ONCE], b[start : start + PAIRS_AT_ONCE]))


def _crossings(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return a place for each pair of triangles (n, 3, 3) of which a side of one passes through the other."""
    places = np.full((len(first), 3), np.nan)
    for triangles, pierced in ((first, second), (second, first)):
        normals = np.cross(pierced[:, 1] - pierced[:, 0], pierced[:, 2] - pierced[:, 0])
        lengths = np.linalg.norm(normals, axis=1)
        unit = normals / np.maximum(lengths, 1e-300)[:, None]
        above = np.einsum("nkx,nx->nk", triangles - pierced[:, :1], unit)
        for i, j in SIDES:
            through = np.flatnonzero(
                (above[:, i] * above[:, j] < 0.0)
                & (np.minimum(np.abs(above[:, i]), np.abs(above[:, j])) > TOUCHING_MM)
                & (lengths > 0.0)
                & np.isnan(places[:, 0])
            )
            share = above[through, i] / (above[through, i] - above[through, j])
            start, end = triangles[through, i], triangles[through, j]
            hits = start + share[:, None] * (end - start)
            inside = np.ones(len(through), dtype=bool)
            for k, after in SIDES:
                side = pierced[through, after] - pierced[through, k]
                across = np.cross(unit[through], side) / np.maximum(np.linalg.norm(side, axis=1), 1e-300)[:, None]
                inside &= np.einsum("nx,nx->n", hits - pierced[through, k], across) > TOUCHING_MM
            places[through[inside]] = hits[inside]
    return places[~np.isnan(places[:, 0])]
