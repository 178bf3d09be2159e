"""A B-rep solid from a cavity that is a mesh: with few enough facets that CAD programs can open it."""

from __future__ import annotations

import importlib

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.scene import Mesh

FACETS = 4_000
"""OCC takes some ten seconds to sew so many, and four times as long for three times as many."""

SEWING_MM = 1e-4

LEVEL_MM = 0.02
"""Facets that come this near to the finish plane lie in it."""


def fewer_facets(inside: Mesh, finish_height_mm: float, facets: int = FACETS) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) and triangles (m, 3) of a coarser mesh of a cavity, without its lid in the finish plane.

    Parameters
    ----------
    inside : Mesh
        Closed level at the finish plane.
    finish_height_mm : float
    facets : int
        How many triangles may be left.
    """
    # FreeCAD's module; the edges whose loss costs least go first (Garland and Heckbert, SIGGRAPH 1997).
    mesh = importlib.import_module("Mesh").Mesh(inside.vertices_mm[inside.triangles].reshape(-1, 3).tolist())
    if mesh.CountFacets > facets:
        mesh.decimate(facets)
    points, triangles = mesh.Topology
    points, triangles = np.array([tuple(point) for point in points]), np.array(triangles)
    level = np.abs(points[:, 2] - finish_height_mm) < LEVEL_MM
    points[level, 2] = finish_height_mm
    return points, triangles[~level[triangles].all(axis=1)]


def faceted_solid(
    outer: Part.Shape, finish_face: int, points: list[list[float]], triangles: list[list[int]]
) -> list[Part.Shape]:
    """Return, as the only one of a list, an outer solid whose inside is bounded by facets that end at its mouth.

    Parameters
    ----------
    outer : Part.Shape
        Upright.
    finish_face : int
        1-based number of its planar face at the mouth.
    points, triangles : lists
        As of `fewer_facets`, turned out of the cavity.

    Raises
    ------
    GlassWorkbenchError
        If they do not join to one closed, valid solid.
    """
    vectors = [FreeCAD.Vector(*point) for point in points]
    corners = np.array(triangles)
    edges: dict[tuple[int, int], Part.Edge] = {}

    def edge(a: int, b: int) -> Part.Edge:
        key = (min(a, b), max(a, b))
        if key not in edges:
            edges[key] = Part.makeLine(vectors[key[0]], vectors[key[1]])
        return edges[key]

    facets = [Part.Face(Part.Wire([edge(a, b), edge(b, c), edge(c, a)])) for a, b, c in triangles]
    directed = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    sides = set(map(tuple, directed.tolist()))
    free = [edge(a, b) for a, b in directed.tolist() if (b, a) not in sides]
    outlines = Part.sortEdges(free)
    if len(outlines) != 1:
        raise GlassWorkbenchError(f"the facets have {len(outlines)} rims, where the mouth is one")
    # Built, not cut: OCC's cut takes some of the outlines for none.
    rim = Part.makeFace([outer.Faces[finish_face - 1].OuterWire, Part.Wire(outlines[0])], "Part::FaceMakerBullseye")
    walls = [face for number, face in enumerate(outer.Faces, start=1) if number != finish_face]
    sewn = Part.Compound([*walls, *rim.Faces, *facets])
    sewn.sewShape(SEWING_MM)
    if len(sewn.Shells) != 1 or not sewn.Shells[0].isClosed():
        raise GlassWorkbenchError("the outside and the facets do not join to one closed shell")
    solid = Part.Solid(sewn.Shells[0])
    if not solid.isValid():
        raise GlassWorkbenchError("the outside and the facets join to a solid that is not valid")
    return [solid]
