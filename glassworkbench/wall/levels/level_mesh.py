"""The surface of a room as a mesh: vertices on it to a nanometre, creases sharp, normals exact."""

from __future__ import annotations

import numpy as np

from glassworkbench.mold.self_intersection import self_intersections
from glassworkbench.scene import Mesh
from glassworkbench.wall.levels.creases import crease_points, in_own_cell, near_creases, normals_on_sides
from glassworkbench.wall.levels.dual_surface import DualSurface, dual_surface, mean_at
from glassworkbench.wall.levels.level_set import Grid
from glassworkbench.wall.levels.refining import Facets, folded, refined
from glassworkbench.wall.levels.room import Room

SMOOTHINGS = 3
"""How often each vertex is moved half way to the middle of its neighbours, within its cell, before it is placed."""

STRAYED = 0.5
"""A vertex that is placed farther (in steps) outside its cell is on another part of the surface."""

ROUNDING_MM = 1e-4
"""Vertices nearer than this to the finish plane are in it."""

ATTEMPTS = 3
"""How often a mesh is refined anew that crosses itself, with the places left alone where it does."""

CREASE_SHARE = 0.01
"""A vertex on a crease may be this share of a step off the surface; else it is not put there."""


def level_mesh(room: Room, grid: Grid, inside: np.ndarray, deviation_mm: float) -> Mesh:
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
    points, value, gradients = room.on_surface(points + 0.5 * aside)
    lost = np.flatnonzero(_strayed(dual, (points - grid.origin_mm) / grid.step_mm) | (np.abs(value) > ROUNDING_MM))
    # A cell can reach through a thin wall. From inside the surface is always met.
    points[lost], _, gradients[lost] = room.on_surface(grid.points(dual.inner_nodes[lost]))

    numbers = near_creases(gradients, edges)
    row = np.full(len(points), -1)
    row[numbers] = np.arange(len(numbers))
    # A corner has neighbours on all its sides only with those across the quadrilaterals.
    across = np.concatenate([edges, *(dual.quads[:, [k, (k + 2) % 4]] for k in range(4))])
    mine = across[row[across[:, 0]] >= 0]
    owner, around = np.concatenate([row[mine[:, 0]], np.arange(len(numbers))]), np.concatenate([mine[:, 1], numbers])
    sharp, found = crease_points(room, points[numbers], owner, points[around], CREASE_SHARE * grid.step_mm)
    found &= in_own_cell(dual.cells[numbers], (sharp - grid.origin_mm) / grid.step_mm, dual.cells)
    snapped = points.copy()
    snapped[numbers[found]] = sharp[found]
    creased = np.zeros(len(points), dtype=bool)
    creased[numbers[found]] = True
    triangles = _triangles(room, dual, snapped, creased)
    while True:
        near = triangles[creased[triangles].any(axis=1)]
        back = np.unique(near[folded(room, snapped, near)])
        back = back[creased[back]]
        if len(back) == 0:
            break
        snapped[back], creased[back] = points[back], False
        triangles = _triangles(room, dual, snapped, creased)
    facets = Facets(snapped, gradients, creased, triangles)
    left = np.zeros((0, 3))
    for _ in range(ATTEMPTS):
        mesh = _mesh(room, refined(room, facets, deviation_mm, grid.step_mm, left))
        crossing = self_intersections(mesh)
        if len(crossing) == 0:
            break
        left = np.unique(np.concatenate([left, crossing]).round(1), axis=0)
    return mesh


def _mesh(room: Room, facets: Facets) -> Mesh:
    # Rounding must not part the lid from the finish plane.
    points = facets.points_mm.copy()
    points[np.abs(points[:, 2] - room.ceiling_mm) < ROUNDING_MM, 2] = room.ceiling_mm
    vertices, normals, triangles = normals_on_sides(room, points, -facets.gradients, facets.triangles, facets.creased)
    return Mesh(vertices, triangles, normals)


def _strayed(dual: DualSurface, places: np.ndarray) -> np.ndarray:
    """Return which vertices, at places (n, 3) in steps, lie clearly outside their cells."""
    return np.maximum(dual.cells - places, places - dual.cells - 1.0).max(axis=1) > STRAYED


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
