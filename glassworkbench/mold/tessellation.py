"""Closed meshes of OCC shapes, with the exact surface normals at their nodes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold.measures import flat_top
from glassworkbench.mold.mending import welded
from glassworkbench.mold.mold import Mold
from glassworkbench.scene import Mesh
from glassworkbench.scene.validate import positive

NODE_DECIMALS = 4
"""Nodes are matched to their surface parameters by position, rounded to a tenth of a micrometre."""

EDGE_MM = 5e-3
"""A node on an edge may be as far from where its face has it; to ask the surface for its parameters takes long."""

MOUTH = -1
"""What stands for the number of a CAD face on the triangles that close the mouth of a mold that is a mesh."""

WELD_MM = 1e-7
"""Nodes of neighbouring faces nearer than this are one: in a turned solid they differ by rounding."""


def tessellate(shape: Part.Shape, deviation_mm: float) -> Mesh:
    """Return a closed mesh of a solid, no farther than `deviation_mm` from its faces.

    A node on an edge is stored once per face, at the same position and with that face's normal: sharp edges stay sharp,
    smooth faces shade smoothly, and the mesh has no gaps.

    Parameters
    ----------
    shape : Part.Shape
        One or more closed solids, in mm.
    deviation_mm : float

    Raises
    ------
    InputError
        If the deviation is not above 0.
    GlassWorkbenchError
        If OCC leaves a hole in the mesh.
    """
    return tessellate_faces(shape, deviation_mm)[0]


def tessellate_faces(shape: Part.Shape, deviation_mm: float) -> tuple[Mesh, np.ndarray]:
    """Return the mesh of `tessellate`, and the 1-based number (m,) of the shape's face that each triangle lies on."""
    vertices, triangles, normals, numbers = [], [], [], []
    count = 0
    for number, face, points, corners in meshed_faces(shape, deviation_mm):
        vertices.append(points)
        triangles.append(corners + count)
        normals.append(_normals(face, points, corners))
        numbers.append(np.full(len(corners), number, dtype=np.int32))
        count += len(points)
    points, corners = welded(np.concatenate(vertices), WELD_MM), np.concatenate(triangles)
    try:
        return Mesh(points, corners, np.concatenate(normals)), np.concatenate(numbers)
    except InputError as error:
        raise GlassWorkbenchError(
            f"the shape could not be meshed without holes at {deviation_mm:g} mm ({error}); "
            "repair the shape, or try another deviation"
        ) from error


def meshed_faces(shape: Part.Shape, deviation_mm: float) -> Iterator[tuple[int, Part.Face, np.ndarray, np.ndarray]]:
    """Yield of each face its 1-based number, itself as meshed, its nodes (n, 3) and triangles of node numbers (m, 3).

    The triangles are outward. Nodes of neighbouring faces on their common edge differ by rounding; see `WELD_MM`.

    Raises
    ------
    InputError
        If the deviation is not above 0.
    """
    deviation_mm = positive(deviation_mm, "deviation_mm")
    # OCC would otherwise hand out a coarser or finer mesh that an earlier caller left in the shape.
    shape = shape.copy(True, False)
    shape.tessellate(deviation_mm)
    for number, face in enumerate(shape.Faces, start=1):
        nodes, corners = face.tessellate(deviation_mm)
        if corners:
            yield number, face, np.array([tuple(node) for node in nodes]), np.array(corners, dtype=np.int64)


def outside_mesh(mold: Mold, deviation_mm: float) -> tuple[Mesh, np.ndarray]:
    """Return the upright mesh of a mold's whole closed outer body, the mouth included, and where its triangles lie.

    Parameters
    ----------
    mold : Mold
    deviation_mm : float
        Largest distance from the CAD faces; a mold that is a mesh is returned as it is.

    Returns
    -------
    mesh : Mesh
    faces : int array (m,)
        Of each triangle, the 1-based number of the CAD face; those that close the mouth carry
        `mold.anatomy.finish_face`. Of a mold that is a mesh 0, and `MOUTH` (-1) where it closes the mouth.

    Raises
    ------
    InputError
        If the deviation is not above 0.
    GlassWorkbenchError
        If OCC leaves a hole in the mesh.
    """
    if mold.mesh is None:
        return tessellate_faces(mold.upright, deviation_mm)
    positive(deviation_mm, "deviation_mm")
    mouth = flat_top(mold.mesh.vertices_mm, mold.mesh.triangles, mold.anatomy.finish_height_mm)
    return mold.mesh, np.where(mouth, MOUTH, 0).astype(np.int32)


def _normals(face: Part.Face, points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the face's unit outward normal (n, 3) at each of its nodes (n, 3)."""
    a, b, c = (points[corners[:, k]] for k in range(3))
    facets = np.cross(b - a, c - a)
    averaged = np.zeros_like(points)
    for k in range(3):
        np.add.at(averaged, corners[:, k], facets)
    averaged /= np.maximum(np.linalg.norm(averaged, axis=1, keepdims=True), 1e-300)

    if face.Surface.TypeId == "Part::GeomPlane":
        normals = np.tile(_normal(face.Surface, (0.0, 0.0)), (len(points), 1))
    else:
        surface = face.Surface
        normals = np.array([_normal(surface, uv) for uv in _parameters(face, points)])
    if np.einsum("ij,ij->", normals, averaged) < 0.0:
        normals = -normals
    # A surface has no normal, or a meaningless one, where it is degenerate (a cone's tip): the triangles' has to do.
    return np.where((np.einsum("ij,ij->i", normals, averaged) > 0.0)[:, None], normals, averaged)


def _normal(surface: Part.GeometrySurface, uv: tuple[float, float]) -> tuple[float, float, float]:
    # A face has the same but for its sense, and takes a hundred times as long over a B-spline.
    try:
        return tuple(surface.normal(*uv))
    except (Part.OCCError, RuntimeError):
        return (0.0, 0.0, 0.0)


def _parameters(face: Part.Face, points: np.ndarray) -> list[tuple[float, float]]:
    """Return the surface's parameters at a face's nodes (n, 3)."""
    surface, places = face.Surface, face.getUVNodes()
    there = np.array([tuple(surface.value(*uv)) for uv in places])
    known = {_key(point): uv for point, uv in zip(there.tolist(), places, strict=True)}
    found = [known.get(_key(point)) for point in points.tolist()]
    for row in [row for row, uv in enumerate(found) if uv is None]:
        off = np.linalg.norm(there - points[row], axis=1)
        nearest = int(np.argmin(off))
        found[row] = places[nearest] if off[nearest] < EDGE_MM else surface.parameter(FreeCAD.Vector(*points[row]))
    return found


def _key(point: object) -> tuple[float, float, float]:
    x, y, z = point
    return round(x, NODE_DECIMALS), round(y, NODE_DECIMALS), round(z, NODE_DECIMALS)
