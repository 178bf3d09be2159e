"""The sharp edges and corners of a level surface: where they are, and the normals on their sides."""

from __future__ import annotations

import numpy as np

from glassworkbench.wall.levels.dual_surface import mean_at
from glassworkbench.wall.levels.room import Room

TURN_RAD = np.radians(10.0)
"""Neighbouring normals that differ by more may have a crease between them."""

APPROACH = 0.25
"""Each round samples the sides of a crease this much nearer to it: on a smooth, bent surface the normals then agree."""

ROUNDS = 3

FLATNESS = 2e-3
"""Share of the largest eigenvalue of the normals' squares below which they span no further direction."""

REACH = 0.6
"""A crease may lie this far (in steps) outside the cell of its vertex where the cell it lies in has none."""

ASTRAY = 0.5
"""A normal whose product with its triangle's is smaller belongs to another side of a crease that was left blunt."""

SAME_SIDE = np.cos(np.radians(6.0))
"""Normals around a crease's vertex that differ by less lie on one side of it."""


def near_creases(gradients: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the numbers of the vertices whose gradient (n, 3) differs from that of a neighbour by a crease's angle.

    Edges (m, 2) lead from each vertex to its neighbours.
    """
    turned = np.einsum("ij,ij->i", gradients[edges[:, 0]], gradients[edges[:, 1]]) < np.cos(TURN_RAD)
    return np.unique(edges[turned])


def crease_points(
    room: Room, near_mm: np.ndarray, owner: np.ndarray, around_mm: np.ndarray, tolerance_mm: float | np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (k, 3) of creases that are nearest to some points, and which of them (k,) are such.

    Parameters
    ----------
    room : Room
    near_mm : array (k, 3)
    owner : int array (m,)
    around_mm : array (m, 3)
        Near the surface, on all sides of the crease sought by number `owner`.
    tolerance_mm : float or array (k,)
        A place that is farther from the surface is none.

    Notes
    -----
    The tangent planes on the sides meet at the crease (dual contouring: Ju et al., ACM Trans. Graph. 21 (2002) 339).
    The planes of bent sides meet off it, so they are taken anew from nearer and nearer.
    """
    found, sharp = np.array(near_mm), np.ones(len(near_mm), dtype=bool)
    points = around_mm
    for k in range(ROUNDS):
        points, _, normals = room.on_surface(points, 1)
        mean, rank = _meeting(owner, points, normals, len(found))
        found[sharp] = mean[sharp]
        sharp &= rank > 1
        left = sharp[owner]
        owner, points = owner[left], points[left]
        if k + 1 < ROUNDS:
            points = found[owner] + APPROACH * (points - found[owner])
    sharp[sharp] = np.abs(room.value(found[sharp])) < np.broadcast_to(tolerance_mm, sharp.shape)[sharp]
    return found, sharp


def _meeting(owner: np.ndarray, points: np.ndarray, normals: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (count, 3) nearest to the samples' middles where their planes meet, and along how many axes."""
    squares = np.empty((count, 3, 3))
    for i in range(3):
        for j in range(3):
            squares[:, i, j] = np.bincount(owner, normals[:, i] * normals[:, j], minlength=count)
    middle = mean_at(owner, points, count)
    gaps = np.einsum("ij,ij->i", normals, points - middle[owner])
    right = np.column_stack([np.bincount(owner, normals[:, k] * gaps, minlength=count) for k in range(3)])
    values, vectors = np.linalg.eigh(squares)
    spans = values > FLATNESS * values[:, -1:]
    inverse = np.where(spans, 1.0 / np.where(spans, values, 1.0), 0.0)
    step = np.einsum("nij,nj,nkj,nk->ni", vectors, inverse, vectors, right)
    return middle + step, spans.sum(axis=1)


def in_own_cell(cells: np.ndarray, places: np.ndarray, all_cells: np.ndarray) -> np.ndarray:
    """Return which places (k, 3), in steps, lie in their cells (k, 3), or near them in a cell without a vertex."""
    at = np.floor(places).astype(np.int64)
    own = np.all(at == cells, axis=1)
    outside = np.maximum(cells - places, places - cells - 1.0).max(axis=1)
    span = np.maximum(all_cells.max(axis=0), at.max(axis=0)) + 2
    keys = np.ravel_multi_index(tuple(np.clip(at, 0, None).T), tuple(span))
    taken = np.isin(keys, np.ravel_multi_index(tuple(all_cells.T), tuple(span)))
    return own | (~taken & (outside < REACH))


def normals_on_sides(
    room: Room, vertices_mm: np.ndarray, normals: np.ndarray, triangles: np.ndarray, creased: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices, normals and triangles with the vertices on creases stored once for each side.

    Parameters
    ----------
    room : Room
    vertices_mm, normals : array (n, 3)
        Outward normals, right but for the vertices on creases.
    triangles : int array (m, 3)
    creased : bool array (n,)
    """
    corners = vertices_mm[triangles]
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets /= np.maximum(np.linalg.norm(facets, axis=1, keepdims=True), 1e-300)
    astray = np.einsum("ij,ikj->ik", facets, normals[triangles]) < ASTRAY
    number, corner = np.nonzero(creased[triangles] | astray)
    vertex = triangles[number, corner]
    at, middle = vertices_mm[vertex], corners[number].mean(axis=1)
    # At the crease itself the side is open: extrapolate from two places within the triangle.
    near, far = (-room.on_surface(at + share * (middle - at), 1)[2] for share in (0.1, 0.2))
    side = 2.0 * near - far
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-300)
    side = np.where((np.einsum("ij,ij->i", near, far) > SAME_SIDE)[:, None], side, near)
    side = np.where((np.einsum("ij,ij->i", side, facets[number]) < ASTRAY)[:, None], facets[number], side)

    order = np.argsort(vertex, kind="stable")
    starts = np.flatnonzero(np.diff(vertex[order], prepend=-1))
    copies, copied_normals = [], []
    triangles = triangles.copy()
    for group in np.split(order, starts[1:]) if len(order) else []:
        left = group
        while len(left):
            same = side[left] @ side[left[0]] > SAME_SIDE
            mine, left = left[same], left[~same]
            mean = side[mine].sum(axis=0)
            triangles[number[mine], corner[mine]] = len(vertices_mm) + len(copies)
            copies.append(vertices_mm[vertex[mine[0]]])
            copied_normals.append(mean / np.linalg.norm(mean))
    if copies:
        vertices_mm = np.concatenate([vertices_mm, copies])
        normals = np.concatenate([normals, copied_normals])
    used, triangles = np.unique(triangles, return_inverse=True)
    return vertices_mm[used], normals[used], triangles.reshape(-1, 3)
