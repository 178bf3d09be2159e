"""Measures taken from meshes: OCC's own bounding boxes are loose and its volumes are wrong on long revolved faces."""

from __future__ import annotations

import itertools

import numpy as np

from glassworkbench.freecad import Part
from glassworkbench.scene import Mesh
from glassworkbench.spatial import sags

FLAT_SHARE = 1e-4
"""Triangles that lie in a plane across the axis within this share of the height are one flat end."""


def mesh_of(shape: Part.Shape) -> tuple[np.ndarray, np.ndarray]:
    """Return a mesh (vertices (n, 3), triangles (m, 3)) fine enough to measure a container by, 0.1 % of its size."""
    vertices, triangles = shape.tessellate(measuring_deviation_mm(shape))
    return np.array([tuple(vertex) for vertex in vertices]), np.array(triangles)


def measuring_deviation_mm(shape: Part.Shape) -> float:
    """Return the deviation of `mesh_of`."""
    return max(1e-3 * min(shape.BoundBox.DiagonalLength, 200.0), 1e-6)


def volume_behind(mesh: Mesh) -> float:
    """Return the volume (mm^3) within the curved surface behind a closed mesh: each triangle adds its mean bulge."""
    corners = mesh.vertices_mm[mesh.triangles]
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    bulge = areas @ sags(corners, mesh.normals[mesh.triangles]).sum(axis=1) / 12.0
    return signed_volume(mesh.vertices_mm, mesh.triangles) + float(bulge)


def signed_volume(vertices_mm: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume (mm^3) that a closed mesh holds, negative if its triangles face inward."""
    a, b, c = (vertices_mm[triangles[:, k]] - vertices_mm[0] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def crossings_on_axis(vertices_mm: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the heights (n,) where the z axis passes through a closed mesh, ascending."""
    a, b, c = (vertices_mm[triangles[:, k], :2] for k in range(3))

    def cross(p: np.ndarray, q: np.ndarray) -> np.ndarray:
        return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]

    shares = np.stack([cross(b, c), cross(c, a), cross(a, b)])
    area = shares.sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = shares / area
    hit = np.all(shares >= -1e-9, axis=0) & (np.abs(area) > 0.0)
    heights = np.sort((shares.T[hit] * vertices_mm[triangles[hit], 2]).sum(axis=1))
    # A vertex or edge on the axis is met by each triangle around it.
    apart = np.diff(heights, prepend=-np.inf) > 1e-6 * np.ptp(vertices_mm[:, 2])
    return heights[apart]


def flat_top(vertices_mm: np.ndarray, triangles: np.ndarray, height_mm: float) -> np.ndarray:
    """Return which triangles (m,) of an upright closed mesh lie in the plane z = `height_mm` and face upward."""
    a, b, c = (vertices_mm[triangles[:, k]] for k in range(3))
    level = np.abs(vertices_mm[:, 2] - height_mm) < FLAT_SHARE * np.ptp(vertices_mm[:, 2])
    return np.all(level[triangles], axis=1) & (np.cross(b - a, c - a)[:, 2] > 0.0)


def smallest_width(vertices_mm: np.ndarray) -> float:
    """Return the smallest distance (mm) between two vertical planes that hold all points (n, 3), to half a degree."""
    angles = np.linspace(0.0, np.pi, 360, endpoint=False)
    return float(np.ptp(vertices_mm[:, :2] @ np.array([np.cos(angles), np.sin(angles)]), axis=0).min())


def smallest_box(vertices_mm: np.ndarray) -> float:
    """Return the volume (mm^3) of the smallest upright box that holds all points (n, 3), its turn to half a degree."""
    angles = np.linspace(0.0, np.pi, 360, endpoint=False)
    widths = np.ptp(vertices_mm[:, :2] @ np.array([np.cos(angles), np.sin(angles)]), axis=0)
    return float((widths * np.roll(widths, 180)).min() * np.ptp(vertices_mm[:, 2]))


def distance_to_polyline(points_mm: np.ndarray, polyline_mm: np.ndarray) -> np.ndarray:
    """Return the distance (n,) of each point (n, 2) to a polyline (m, 2)."""
    nearest = np.full(len(points_mm), np.inf)
    for start, end in itertools.pairwise(polyline_mm):
        along = end - start
        length_squared = along @ along
        if length_squared == 0.0:
            continue
        offset = points_mm - start
        share = np.clip(offset @ along / length_squared, 0.0, 1.0)
        np.minimum(nearest, np.linalg.norm(offset - share[:, None] * along, axis=1), out=nearest)
    return nearest
