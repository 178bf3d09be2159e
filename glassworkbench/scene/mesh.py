"""Closed triangle meshes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene.validate import finite_array


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles with a normal at each vertex, for what has no exact surface.

    Parameters
    ----------
    vertices_mm : array (n, 3)
    triangles : int array (m, 3)
        Counter-clockwise seen from outside; the mesh is closed (each edge belongs to two triangles).
    normals : array (n, 3), optional
        Unit outward normals; area-weighted averages of the triangles' where not given.
    has_averaged_normals : bool
        Whether the normals are but averages of the triangles', not those of the surface that the mesh stands for; so
        where they are not given.

    Raises
    ------
    InputError
        If an index is out of range, a vertex not finite, or the mesh has a hole.
    """

    vertices_mm: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None
    has_averaged_normals: bool = False

    def __post_init__(self) -> None:
        vertices = finite_array(self.vertices_mm, (None, 3), "vertices_mm")
        triangles = np.array(self.triangles, dtype=np.int32, order="C")
        if triangles.ndim != 2 or triangles.shape[1] != 3 or len(triangles) < 4:
            raise InputError(f"triangles: expected at least 4 rows of 3 vertex numbers, got shape {triangles.shape}")
        if triangles.min() < 0 or triangles.max() >= len(vertices):
            raise InputError("triangles: a vertex number is out of range")
        _check_closed(vertices, triangles)
        triangles.setflags(write=False)
        if self.normals is None:
            normals = _vertex_normals(vertices, triangles)
            object.__setattr__(self, "has_averaged_normals", True)
        else:
            normals = finite_array(self.normals, (len(vertices), 3), "normals")
        object.__setattr__(self, "vertices_mm", vertices)
        object.__setattr__(self, "triangles", triangles)
        object.__setattr__(self, "normals", normals)

    @property
    def box_mm(self) -> tuple[np.ndarray, np.ndarray]:
        """The lower and the upper corner (3,) of the box around it."""
        return self.vertices_mm.min(axis=0), self.vertices_mm.max(axis=0)

    def placed(self, turn: np.ndarray, shift_mm: np.ndarray) -> Mesh:
        """Return the mesh turned by a rotation (3, 3) about the origin, then moved."""
        return replace(self, vertices_mm=shift_mm + self.vertices_mm @ turn.T, normals=self.normals @ turn.T)


def _check_closed(vertices: np.ndarray, triangles: np.ndarray) -> None:
    # A vertex may be stored once per face it bounds (its normals differ there), so edges are matched by position.
    _, place = np.unique(vertices, axis=0, return_inverse=True)
    corners = place.reshape(-1)[triangles]
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    edges = edges[edges[:, 0] != edges[:, 1]]
    keys = edges[:, 0].astype(np.int64) * (len(vertices) + 1) + edges[:, 1]
    twins = edges[:, 1].astype(np.int64) * (len(vertices) + 1) + edges[:, 0]
    if not np.array_equal(np.sort(keys), np.sort(twins)):
        lone = edges[~np.isin(twins, keys)]
        where = ""
        if len(lone):
            x, y, z = vertices[np.flatnonzero(place.reshape(-1) == lone[0, 0])[0]]
            where = f", near ({x:.3f}, {y:.3f}, {z:.3f}) mm"
        raise InputError(f"triangles: the mesh is not closed{where}; fill its holes and align its faces")


def _vertex_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area_normals = np.cross(b - a, c - a)
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, triangles[:, k], area_normals)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.where(lengths > 0.0, lengths, 1.0)
    normals.setflags(write=False)
    return normals
