"""The cavity of a container of any shape by OCC's offset of its faces: uniform walls."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.wall.revolved import PAST_MOUTH_MM
from glassworkbench.wall.solids import hollow_solid

OFFSET_TOLERANCE_MM = 1e-4

ARC, INTERSECTION = 0, 2
"""How OCC joins offset faces at a convex edge: by a rounding, or by extending both until they meet."""

LIP_HEIGHT_MM = 5.0
"""Faces beside the finish that lie wholly within this height of it are the lip's rounding."""


def thick_solid(outer: Part.Shape, finish_face: int, thickness_mm: float) -> list[Part.Shape]:
    """Return the hollow solid, its cavity up to the finish plane, and the cavity reaching past the mouth.

    Parameters
    ----------
    outer : Part.Shape
        Upright solid.
    finish_face : int
        1-based number of the planar face at the mouth.
    thickness_mm : float

    Raises
    ------
    GlassWorkbenchError
        If none of OCC's ways gives a closed, valid cavity inside the outer solid; the message says why.

    Notes
    -----
    The faces but the mouth are continued by a straight collar above the mouth and offset inward as one open shell; the
    collar takes care that the mouth's edge is planar, and that the cavity reaches through it.
    """
    height = outer.Faces[finish_face - 1].CenterOfMass.z
    outer_volume = _volume(outer)
    reasons = []
    for walls in _wall_faces(outer, finish_face):
        for join in (ARC, INTERSECTION):
            try:
                past_mouth = _cavity(walls, height, thickness_mm, join)
                cavity = _below(past_mouth, height)
                _check(cavity, outer_volume)
                return [_hollow(outer, cavity, past_mouth, finish_face), cavity, past_mouth]
            # OCC raises errors of many kinds, which derive from Exception only.
            except Exception as error:
                reasons.append(str(error).strip() or type(error).__name__)
    raise GlassWorkbenchError(", or ".join(dict.fromkeys(reasons)))


def _hollow(outer: Part.Shape, cavity: Part.Shape, past_mouth: Part.Shape, finish_face: int) -> Part.Shape:
    try:
        return hollow_solid(outer, cavity, finish_face)
    except GlassWorkbenchError:
        # Slower, and it fails where faces nearly coincide, but it needs no exact match at the mouth.
        rest = outer.cut(past_mouth)
        if len(rest.Solids) != 1:
            raise
        return rest.Solids[0]


def _wall_faces(outer: Part.Shape, finish_face: int) -> Iterator[list[Part.Face]]:
    """Yield the faces with a wall behind them: first without the lip's rounding, so that the bore runs straight."""
    finish = outer.Faces[finish_face - 1]
    height = finish.CenterOfMass.z
    rest = [face for number, face in enumerate(outer.Faces, start=1) if number != finish_face]
    edges = {edge.hashCode() for edge in finish.Edges}
    lip = [
        face
        for face in rest
        if any(edge.hashCode() in edges for edge in face.Edges) and _lowest(face) > height - LIP_HEIGHT_MM
    ]
    if lip:
        yield [face for face in rest if not any(face.isSame(other) for other in lip)]
    yield rest


def _lowest(face: Part.Face) -> float:
    return min(point.z for point in face.tessellate(0.1)[0])


def _cavity(walls: Sequence[Part.Face], height: float, thickness_mm: float, join: int) -> Part.Shape:
    boundary = _free_edges(walls)
    rise = height + 2.0 * PAST_MOUTH_MM - max(vertex.Z for edge in boundary for vertex in edge.Vertexes)
    collar = [edge.extrude(FreeCAD.Vector(0, 0, rise)) for edge in boundary]
    shell = Part.Shell([*walls, *(face for sheet in collar for face in sheet.Faces)])
    shell.sewShape(1e-6)
    inside = shell.makeOffsetShape(-thickness_mm, OFFSET_TOLERANCE_MM, True, False, 0, join, False)
    faces = inside.Faces
    if not faces:
        raise GlassWorkbenchError("the offset is empty")
    wires = [Part.Wire(edges) for edges in Part.sortEdges(_free_edges(faces))]
    if len(wires) != 1:
        raise GlassWorkbenchError(f"the offset has {len(wires)} openings, where one must be")
    closed = Part.Shell([*faces, Part.Face(wires[0])])
    closed.sewShape(1e-5)
    solid = Part.Solid(closed.Shells[0])
    solid = solid if _volume(solid) > 0.0 else solid.reversed()
    return _below(solid, height + PAST_MOUTH_MM)


def _free_edges(faces: Sequence[Part.Face]) -> list[Part.Edge]:
    """Return the edges that only one of the faces has."""
    edges = [edge for face in faces for edge in face.Edges if not (edge.Degenerated or edge.isSeam(face))]
    counts = Counter(edge.hashCode() for edge in edges)
    return [edge for edge in edges if counts[edge.hashCode()] == 1]


def _below(solid: Part.Shape, height: float) -> Part.Shape:
    box = solid.BoundBox
    reach = box.DiagonalLength
    slab = Part.makeBox(
        box.XLength + 2 * reach,
        box.YLength + 2 * reach,
        box.ZLength + 2 * reach,
        FreeCAD.Vector(box.XMin - reach, box.YMin - reach, height),
    )
    rest = solid.cut(slab)
    if len(rest.Solids) != 1:
        raise GlassWorkbenchError(f"the cavity falls into {len(rest.Solids)} parts")
    return rest.Solids[0]


def _check(cavity: Part.Shape, outer_volume: float) -> None:
    if not cavity.isValid() or not cavity.Shells[0].isClosed():
        raise GlassWorkbenchError("the cavity is not a valid closed solid")
    try:
        cavity.check(True)
    except ValueError as error:
        crosses = "SelfIntersect" in str(error)
        raise GlassWorkbenchError(f"the offset surface {'crosses itself' if crosses else 'is faulty'}") from error
    volume = _volume(cavity)
    if not 0.0 < volume < outer_volume:
        raise GlassWorkbenchError("the cavity is not inside the mold")


def _volume(solid: Part.Shape) -> float:
    # OCC's own volume can be wrong by a factor on long faces, so a mesh is asked.
    vertices, triangles = solid.tessellate(0.1)
    vertices = np.array([tuple(vertex) for vertex in vertices])
    a, b, c = (vertices[np.array(triangles)[:, k]] - vertices[0] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
