"""The curved surface behind a mesh whose vertices, with their normals, lie on it."""

from __future__ import annotations

import numpy as np

from glassworkbench.scene import Mesh
from glassworkbench.spatial import SIDES, sags

SEED = 20240229


def facets(corners_mm: np.ndarray) -> np.ndarray:
    """Return the normals (m, 3) of triangles (m, 3, 3), as long as the triangles' area."""
    return 0.5 * np.cross(corners_mm[:, 1] - corners_mm[:, 0], corners_mm[:, 2] - corners_mm[:, 0])


def surface_points(mesh: Mesh, triangles: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return the points (n, 3) of the surface over barycentric coordinates (n, 3) of triangles (n,) of a mesh."""
    corners, normals = mesh.vertices_mm[mesh.triangles[triangles]], mesh.normals[mesh.triangles[triangles]]
    sag = sags(corners, normals)
    height = sum(shares[:, i] * shares[:, j] * sag[:, side] for side, (i, j) in enumerate(SIDES))
    normal = np.einsum("ij,ijk->ik", shares, normals)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    return np.einsum("ij,ijk->ik", shares, corners) + height[:, None] * normal


def spread(mesh: Mesh, wanted: np.ndarray, count: int) -> np.ndarray:
    """Return points (count, 3) of the surface, evenly by area over the wanted triangles (m,), the same at each call."""
    random = np.random.default_rng(SEED)
    numbers = np.flatnonzero(wanted)
    area = np.cumsum(np.linalg.norm(facets(mesh.vertices_mm[mesh.triangles[numbers]]), axis=1))
    places = (np.arange(count) + random.random(count)) / count * area[-1]
    chosen = numbers[np.minimum(np.searchsorted(area, places), len(area) - 1)]
    u, v = random.random((2, count))
    flip = u + v > 1.0
    u, v = np.where(flip, 1.0 - u, u), np.where(flip, 1.0 - v, v)
    return surface_points(mesh, chosen, np.column_stack([1.0 - u - v, u, v]))


def at_level(mesh: Mesh, wanted: np.ndarray, height_mm: float, count: int) -> np.ndarray:
    """Return points of the surface, `count` at most, where sides of the wanted triangles (m,) cross a height."""
    heights = mesh.vertices_mm[mesh.triangles, 2]
    start, end = np.array(SIDES).T
    # Of the two triangles at a side, one goes up along it.
    rising = wanted[:, None] & (heights[:, start] < height_mm) & (heights[:, end] >= height_mm)
    triangle, side = np.nonzero(rising)
    chosen = np.unique(np.linspace(0, len(triangle) - 1, count).round().astype(int)) if len(triangle) else []
    triangle, side = triangle[chosen], side[chosen]
    low, high = heights[triangle, start[side]], heights[triangle, end[side]]
    along = (height_mm - low) / (high - low)
    shares = np.zeros((len(triangle), 3))
    row = np.arange(len(triangle))
    shares[row, start[side]], shares[row, end[side]] = 1.0 - along, along
    return surface_points(mesh, triangle, shares)


def surface_area(mesh: Mesh, wanted: np.ndarray | None = None) -> float:
    """Return the area (mm^2) of the surface behind the wanted triangles (m,) of a mesh, or behind all.

    Notes
    -----
    A surface at the height h over a triangle is larger by half the integral of |grad h|^2, which the middles of the
    sides give exactly as h is quadratic.
    """
    corners = mesh.vertices_mm[mesh.triangles]
    sag = sags(corners, mesh.normals[mesh.triangles])
    normal = facets(corners)
    area = np.linalg.norm(normal, axis=1)
    solid = area > 0.0
    if wanted is not None:
        solid &= wanted
    corners, normal, area, sag = corners[solid], normal[solid], area[solid], sag[solid]
    # The gradient of b_k is the opposite side, turned by a quarter within the plane, over twice the area.
    opposite = np.stack(
        [corners[:, 2] - corners[:, 1], corners[:, 0] - corners[:, 2], corners[:, 1] - corners[:, 0]], 1
    )
    gradients = np.cross(normal[:, None], opposite) / (2.0 * area**2)[:, None, None]
    squares = np.zeros(len(area))
    for middle in ((0.5, 0.5, 0.0), (0.0, 0.5, 0.5), (0.5, 0.0, 0.5)):
        slope = sum(
            sag[:, side, None] * (middle[i] * gradients[:, j] + middle[j] * gradients[:, i])
            for side, (i, j) in enumerate(SIDES)
        )
        squares += np.einsum("ij,ij->i", slope, slope) / 3.0
    return float(np.sum(area * (1.0 + 0.5 * squares)))
