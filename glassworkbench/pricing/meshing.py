"""Triangle meshes of a scene's bodies, each density with about a quarter of the deviation of the one before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from glassworkbench.scene import Ellipsoid, Mesh, Patches, Revolved, Scene, Surface

DENSITIES = 3

COARSEST_SHARE = 0.004
"""How far the coarsest mesh of a turned body is off, as a share of its largest radius: circles of 36 sides."""

SAMPLES = 65
"""Places along a segment of a meridian from which the corners of its polygon are chosen."""


def meshed(scene: Scene, density: int) -> Scene:
    """Return a scene with meshes in place of exact bodies; those that are meshes already stay.

    Parameters
    ----------
    scene : Scene
    density : int
        From 0; each next has four times the triangles where the body curves in both directions, twice where in one. At
        their vertices are the surface's normals.
    """
    bodies = [replace(body, surface=_mesh(body.surface, density)) for body in scene.bodies]
    return replace(scene, bodies=bodies)


def triangle_count(scene: Scene) -> int:
    """Return the number of triangles in all meshes of a scene."""
    return sum(len(body.surface.triangles) for body in scene.bodies if isinstance(body.surface, Mesh))


def _mesh(surface: Surface, density: int) -> Mesh:
    if isinstance(surface, Revolved):
        return _mesh_of_revolved(surface, density)
    if isinstance(surface, Ellipsoid):
        return _mesh_of_ellipsoid(surface, density)
    if isinstance(surface, Patches):
        return _mesh_of_patches(surface, density)
    return surface


def _mesh_of_revolved(surface: Revolved, density: int) -> Mesh:
    off_mm = COARSEST_SHARE * 0.25**density * float(surface.meridian[:, :, 0].max())
    pieces = [_polygon(segment, off_mm) for segment in surface.meridian]
    mesh = _turned(pieces, _sides(density))
    z = surface.axis
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    return mesh.placed(np.column_stack([x, np.cross(z, x), z]), surface.base_mm)


def _sides(density: int) -> int:
    """Return the sides of a polygon in a circle whose middles lie `COARSEST_SHARE` / 4 ** density inside of it."""
    return int(np.ceil(np.pi / np.arccos(1.0 - COARSEST_SHARE * 0.25**density)))


def _polygon(segment: np.ndarray, off_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Return corners (n, 2) on a meridian segment, its ends among them, and the body's outward normals there."""
    u = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    weights = segment[:, 2]
    basis = np.hstack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
    points = (basis * weights) @ segment[:, :2] / (basis @ weights)[:, None]
    points[[0, -1]] = segment[[0, 3], :2]
    tangents = np.gradient(points, u[:, 0], axis=0, edge_order=2)
    normals = np.column_stack([tangents[:, 1], -tangents[:, 0]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    # Arcs that turn by a at radius R leave their chord by R a^2 / 8 = length a / 8.
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    turns = np.arccos(np.clip(np.einsum("ij,ij->i", normals[1:], normals[:-1]), -1.0, 1.0))
    needed = np.concatenate([[0.0], np.cumsum(np.sqrt(lengths * turns / (8.0 * off_mm)))])
    count = int(np.clip(np.ceil(needed[-1]), 1, SAMPLES - 1))
    if needed[-1] < 1e-6:
        chosen = np.array([0, SAMPLES - 1])
    else:
        chosen = np.unique(np.searchsorted(needed, np.linspace(0.0, needed[-1], count + 1)).clip(0, SAMPLES - 1))
        chosen[0], chosen[-1] = 0, SAMPLES - 1
    return points[chosen], normals[chosen]


def _turned(pieces: list[tuple[np.ndarray, np.ndarray]], sides: int) -> Mesh:
    """Return the mesh of polygons (r, z) with normals, one after the other, turned about z."""
    angles = 2.0 * np.pi * np.arange(sides) / sides
    across, along = np.cos(angles), np.sin(angles)
    vertices, normals, triangles, count = [], [], [], 0
    here = np.arange(sides)
    there = np.roll(here, -1)
    for points, slopes in pieces:
        for values, into in ((points, vertices), (slopes, normals)):
            r, z = values[:, :1], np.repeat(values[:, 1:], sides, axis=1)
            into.append(np.stack([r * across, r * along, z], axis=2).reshape(-1, 3))
        for row in range(len(points) - 1):
            low, high = count + row * sides, count + (row + 1) * sides
            if points[row, 0] > 0.0:
                triangles.append(np.column_stack([low + here, low + there, high + here]))
            if points[row + 1, 0] > 0.0:
                triangles.append(np.column_stack([high + here, low + there, high + there]))
        count += len(points) * sides
    return Mesh(np.concatenate(vertices), np.concatenate(triangles), np.concatenate(normals))


def _mesh_of_ellipsoid(surface: Ellipsoid, density: int) -> Mesh:
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, -(-_sides(density) // 2) + 1)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    circle[[0, -1], 0] = 0.0
    ball = _turned([(circle, circle)], _sides(density))
    normals = ball.normals / surface.semi_axes_mm
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    mesh = Mesh(ball.vertices_mm * surface.semi_axes_mm, ball.triangles, normals)
    return mesh.placed(surface.rotation, surface.centre_mm)


def _mesh_of_patches(surface: Patches, density: int) -> Mesh:
    """Return the triangles by which sheets join, each cut in four as often as the density says."""
    sheets, uv = surface.sheet_of_triangle, surface.uv_of_corner
    corners = surface.mesh.vertices_mm[surface.mesh.triangles]
    for _ in range(density):
        sheets, uv, corners = _quartered(surface, sheets, uv, corners)
    _, by_u, by_v = surface.evaluate(np.repeat(sheets, 3), uv.reshape(-1, 2))
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets = np.repeat(facets, 3, axis=0)
    normals = np.cross(by_u, by_v)
    normals *= np.where(np.einsum("ij,ij->i", normals, facets) < 0.0, -1.0, 1.0)[:, None]
    # At a pole the sheet has no normal.
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(lengths > 1e-12 * lengths.max(), normals, facets)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return Mesh(corners.reshape(-1, 3), np.arange(3 * len(sheets)).reshape(-1, 3), normals)


def _quartered(
    surface: Patches, sheets: np.ndarray, uv: np.ndarray, corners: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    middle_uv = 0.5 * (uv + np.roll(uv, -1, axis=1))
    middles = surface.evaluate(np.repeat(sheets, 3), middle_uv.reshape(-1, 2))[0]
    # Two sheets that share an edge agree on its middle, or there would be a gap.
    _, place = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    place = place.reshape(-1, 3)
    edges = np.sort(np.stack([place, np.roll(place, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    _, edge = np.unique(edges, axis=0, return_inverse=True)
    edge = edge.reshape(-1)
    sums = np.zeros((edge.max() + 1, 3))
    np.add.at(sums, edge, middles)
    middles = (sums / np.bincount(edge)[:, None])[edge].reshape(-1, 3, 3)

    def cut(at_corners: np.ndarray, at_middles: np.ndarray) -> np.ndarray:
        a, b, c = (at_corners[:, k] for k in range(3))
        ab, bc, ca = (at_middles[:, k] for k in range(3))
        quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        return np.concatenate([np.stack(quarter, axis=1) for quarter in quarters])

    return np.tile(sheets, 4), cut(uv, middle_uv), cut(corners, middles)
