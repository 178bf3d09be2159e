"""The surface of a room as a mesh: vertices on it to a nanometre, creases sharp, normals exact."""

from __future__ import annotations

import numpy as np

from glassworkbench.scene import Mesh
from glassworkbench.wall.creases import in_own_cell, normals_on_sides, snapped_to_creases
from glassworkbench.wall.dual_surface import DualSurface, dual_surface, mean_at
from glassworkbench.wall.level_set import Grid
from glassworkbench.wall.room import Room

SMOOTHINGS = 3
"""How often each vertex is moved half way to the middle of its neighbours, within its cell, before it is placed."""

CREASE_SHARE = 0.01
"""A vertex on a crease may be this share of a step off the surface; else it is not put there."""

FOLDED = 0.2
"""A triangle whose normal has a smaller product with those at its corners is folded over."""


def level_mesh(room: Room, grid: Grid, inside: np.ndarray) -> Mesh:
    """Return the closed mesh around the nodes (nx, ny, nz) of a grid that are inside.

    No face of a cell may be ambiguous; see `dual_surface.without_ambiguity`.
    """
    dual = dual_surface(inside)
    edges = np.concatenate([dual.quads[:, [k, (k + 1) % 4]] for k in range(4)])
    places = dual.places
    for _ in range(SMOOTHINGS):
        places = 0.5 * (places + mean_at(edges[:, 0], places[edges[:, 1]], len(places)))
        places = np.clip(places, dual.cells, dual.cells + 1.0)
    points, _, gradients = room.on_surface(grid.points(places), 1)
    middles = mean_at(edges[:, 0], points[edges[:, 1]], len(points))
    aside = middles - points
    aside -= np.einsum("ij,ij->i", aside, gradients)[:, None] * gradients
    points, _, gradients = room.on_surface(points + 0.5 * aside)

    numbers, sharp = snapped_to_creases(room, points, gradients, edges, CREASE_SHARE * grid.step_mm)
    own = in_own_cell(dual.cells[numbers], (sharp - grid.origin_mm) / grid.step_mm, dual.cells)
    snapped = points.copy()
    snapped[numbers[own]] = sharp[own]
    creased = np.zeros(len(points), dtype=bool)
    creased[numbers[own]] = True
    triangles = _triangles(room, dual, snapped, creased)
    while True:
        folded = _folded(snapped, -gradients, creased, triangles)
        back = np.unique(triangles[folded])
        back = back[creased[back]]
        if len(back) == 0:
            break
        snapped[back], creased[back] = points[back], False
        triangles = _triangles(room, dual, snapped, creased)
    return Mesh(*_in_order(*normals_on_sides(room, snapped, -gradients, triangles, creased)))


def _triangles(room: Room, dual: DualSurface, points: np.ndarray, creased: np.ndarray) -> np.ndarray:
    """Cut each quadrilateral along its shorter diagonal; near a crease, along the one that is nearer to the surface."""
    quads = dual.quads
    corners = points[quads]
    cost = np.stack([np.linalg.norm(corners[:, k] - corners[:, k + 2], axis=1) for k in (0, 1)], axis=1)
    near = np.flatnonzero(creased[quads].any(axis=1))
    if len(near):
        middles = np.stack([0.5 * (corners[near, k] + corners[near, k + 2]) for k in (0, 1)], axis=1)
        off = np.abs(room.value(middles.reshape(-1, 3))).reshape(-1, 2)
        cost[near] = off + 1e-3 * cost[near]
    first = (cost[:, 0] <= cost[:, 1])[:, None]
    one = np.where(first, quads[:, [0, 1, 2]], quads[:, [0, 1, 3]])
    other = np.where(first, quads[:, [0, 2, 3]], quads[:, [1, 2, 3]])
    return np.concatenate([one, other])


def _folded(points: np.ndarray, normals: np.ndarray, creased: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    facets = np.cross(b - a, c - a)
    facets /= np.maximum(np.linalg.norm(facets, axis=1, keepdims=True), 1e-300)
    smooth = ~creased[triangles]
    agree = np.einsum("ij,ikj->ik", facets, normals[triangles])
    worst = np.where(smooth, agree, 1.0).min(axis=1)
    return (worst < FOLDED) & creased[triangles].any(axis=1)


def _in_order(vertices: np.ndarray, normals: np.ndarray, triangles: np.ndarray) -> tuple:
    return vertices, triangles, normals
