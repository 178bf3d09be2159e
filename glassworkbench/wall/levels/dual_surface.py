"""The surface between the nodes of a grid that are inside and those that are not: one vertex in each cell it crosses.

Surface nets (Gibson, MICCAI 1998) in their manifold form (Nielson, Dual marching cubes, IEEE Visualization 2004): where
two sheets pass through one cell, it has a vertex for each.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

_CORNERS = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)])
"""Corner k of a cell lies at these steps from its first."""

_EDGES = np.array([[a, a | 1 << axis] for axis in range(3) for a in range(8) if not a >> axis & 1])
"""Corners that the twelve edges of a cell join, four along each axis."""


@dataclass(frozen=True, eq=False)
class DualSurface:
    """A closed surface of quadrilaterals, every edge shared by two.

    Parameters
    ----------
    cells : int array (n, 3)
        The cell that each vertex belongs to.
    places : array (n, 3)
        The mean of the middles of the grid's edges that are crossed there, in steps.
    inner_nodes : int array (n, 3)
        A node that is inside, at the end of one of those edges.
    quads : int array (m, 4)
        Counter-clockwise, seen from where the grid is not inside.
    """

    cells: np.ndarray
    places: np.ndarray
    inner_nodes: np.ndarray
    quads: np.ndarray


def without_ambiguity(inside: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """Return a part of the nodes that are inside, so that no face of a cell has only opposite corners inside.

    Of two opposite corners the one with the smaller bound is taken out: sheets that meet in less than a step part.
    """
    inside = inside.copy()
    while True:
        found = 0
        for axis in range(3):
            i, j = (k for k in range(3) if k != axis)
            corners = {(a, b): _shifted(inside.shape, {i: a, j: b}) for a in (0, 1) for b in (0, 1)}
            values = {key: inside[at] for key, at in corners.items()}
            for one, other in (((0, 0), (1, 1)), ((0, 1), (1, 0))):
                rest = [key for key in corners if key not in (one, other)]
                twisted = values[one] & values[other] & ~values[rest[0]] & ~values[rest[1]]
                first_less = bound[corners[one]] < bound[corners[other]]
                inside[corners[one]] &= ~(twisted & first_less)
                inside[corners[other]] &= ~(twisted & ~first_less)
                found += int(twisted.sum())
        if not found:
            return inside


def _shifted(shape: tuple[int, ...], offsets: dict[int, int]) -> tuple[slice, ...]:
    return tuple(
        slice(offsets[axis], count - 1 + offsets[axis]) if axis in offsets else slice(None)
        for axis, count in enumerate(shape)
    )


def dual_surface(inside: np.ndarray) -> DualSurface:
    """Return the surface around the nodes (nx, ny, nz) that are inside.

    The outermost nodes must be outside, and no face ambiguous; see `without_ambiguity`.
    """
    shape = np.array(inside.shape) - 1
    code = np.zeros(shape, dtype=np.uint8)
    for k, corner in enumerate(_CORNERS):
        code |= inside[tuple(slice(c, c + n) for c, n in zip(corner, shape, strict=True))].astype(np.uint8) << k
    sheet_of_edge, sheets = _sheets()
    active = np.flatnonzero(sheets[code.ravel()])
    first = np.full(code.size, -1, dtype=np.int64)
    first[active] = np.cumsum(sheets[code.ravel()[active]]) - sheets[code.ravel()[active]]
    cells = np.repeat(np.column_stack(np.unravel_index(active, shape)), sheets[code.ravel()[active]], axis=0)
    first = first.reshape(shape)

    quads, middles, ends = [], [], []
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        low, high = (
            _shifted(inside.shape, {axis: 0}),
            tuple(slice(1, None) if k == axis else slice(None) for k in range(3)),
        )
        edges = np.argwhere(inside[low] != inside[high])
        around = []
        for back_i, back_j in ((1, 1), (0, 1), (0, 0), (1, 0)):
            cell = edges.copy()
            cell[:, i] -= back_i
            cell[:, j] -= back_j
            corner = back_i << i | back_j << j
            number = int(np.flatnonzero((_EDGES[:, 0] == corner) & (_EDGES[:, 1] == corner | 1 << axis))[0])
            at = tuple(cell.T)
            around.append(first[at] + sheet_of_edge[code[at], number])
        quad = np.column_stack(around)
        leaving = inside[tuple(edges.T)]
        quads.append(np.where(leaving[:, None], quad, quad[:, ::-1]))
        end = edges.copy()
        end[:, axis] += ~leaving
        ends.append(end)
        middle = edges.astype(np.float64)
        middle[:, axis] += 0.5
        middles.append(middle)
    quads, middles = np.concatenate(quads), np.concatenate(middles)
    places = mean_at(quads.ravel(), np.repeat(middles, 4, axis=0), len(cells))
    inner_nodes = np.empty_like(cells)
    inner_nodes[quads.ravel()] = np.repeat(np.concatenate(ends), 4, axis=0)
    return DualSurface(cells, places, inner_nodes, quads)


def mean_at(numbers: np.ndarray, vectors: np.ndarray, count: int) -> np.ndarray:
    """Return the mean (count, 3) of the vectors (n, 3) that carry each number (n,)."""
    sums = np.column_stack([np.bincount(numbers, vectors[:, k], minlength=count) for k in range(3)])
    return sums / np.maximum(np.bincount(numbers, minlength=count), 1)[:, None]


@cache
def _sheets() -> tuple[np.ndarray, np.ndarray]:
    """Return for each of the 256 cells the sheet (256, 12) that crosses each edge, and how many sheets there are."""
    sheet_of_edge, counts = np.zeros((256, 12), dtype=np.int64), np.zeros(256, dtype=np.int64)
    faces = [
        [e for e in range(12) if all(_CORNERS[c, axis] == side for c in _EDGES[e])]
        for axis in range(3)
        for side in (0, 1)
    ]
    for code in range(256):
        crossed = [e for e in range(12) if (code >> _EDGES[e, 0] & 1) != (code >> _EDGES[e, 1] & 1)]
        label = {e: e for e in crossed}
        for face in faces:
            joined = [e for e in face if e in label]
            if joined:
                old, new = {label[e] for e in joined}, min(label[e] for e in joined)
                label = {e: new if at in old else at for e, at in label.items()}
        names = sorted(set(label.values()))
        counts[code] = len(names)
        for e, name in label.items():
            sheet_of_edge[code, e] = names.index(name)
    return sheet_of_edge, counts
