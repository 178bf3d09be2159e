"""A wall that differs on planar faces bounded by sharp edges: their planes are moved before a uniform offset."""

from __future__ import annotations

from collections.abc import Sequence

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.wall.offsetting.offset_check import check_faces
from glassworkbench.wall.offsetting.offset_solid import hollowed, number_of, offset_solid
from glassworkbench.wall.offsetting.offset_ways import LIP_HEIGHT_MM

SHARP_COSINE = 0.9
"""Faces whose normals make a smaller angle than this one's (26 degrees) meet smoothly: OCC cannot part their walls."""

SUPPORT_MM = 1e-4
"""How far a solid may reach beyond a plane that it is said to lie behind."""

FaceThickness = tuple[int, float]
"""1-based number of a face, and the thickness of its wall in mm."""


def check_face(solid: Part.Shape, number: int, finish_face: int) -> None:
    """Raise unless a face can have a wall of its own.

    Raises
    ------
    InputError
        If it is no face with a wall behind it, not planar, or meets a neighbour smoothly.
    """
    if not 1 <= number <= len(solid.Faces) or number == finish_face:
        raise InputError(f"wall Face{number}: it is no face with a wall behind it; name another")
    face = solid.Faces[number - 1]
    if face.Surface.TypeId != "Part::GeomPlane":
        raise InputError(
            f"wall Face{number}: it is not planar, so OCC cannot give it a wall of its own; lofted and inner_mesh can"
        )
    for edge in face.Edges:
        point = edge.valueAt(0.5 * (edge.FirstParameter + edge.LastParameter))
        for other in solid.ancestorsOfType(edge, Part.Face):
            cosine = _normal(face, point).dot(_normal(other, point))
            if not other.isSame(face) and cosine > SHARP_COSINE:
                raise InputError(
                    f"wall Face{number}: it meets a neighbour smoothly, so OCC cannot part their walls; "
                    "lofted and inner_mesh can"
                )


def per_face_solid(
    outer: Part.Shape,
    finish_face: int,
    thickness_mm: float,
    faces: Sequence[FaceThickness],
    ways: Sequence[str] = (),
) -> list[Part.Shape]:
    """Return the hollow solid, its cavity up to the finish plane, and the cavity reaching past the mouth.

    Parameters
    ----------
    outer : Part.Shape
        Upright solid.
    finish_face : int
        1-based number of the planar face at the mouth.
    thickness_mm : float
        Of all faces but those named.
    faces : sequence of (face, thickness_mm)
    ways : sequence of str
        As in `offset_solid`.

    Raises
    ------
    GlassWorkbenchError
        If OCC's offset fails, or its wall is not what was asked of each face.

    Notes
    -----
    A face whose wall shall be thicker is moved inward by the difference, one that shall be thinner outward; then the
    uniform offset leaves the right wall behind each. Where a moved face meets walls that are not square to it, that
    is an approximation; what comes out is measured against the faces as they are.
    """
    body = outer
    for number, face_mm in faces:
        body = _with_face_moved(body, outer.Faces[number - 1], thickness_mm - face_mm)
    finish = outer.Faces[finish_face - 1]
    _, cavity, past_mouth = offset_solid(body, number_of(finish, body), thickness_mm, ways)
    thicknesses = [dict(faces).get(number, thickness_mm) for number in range(1, len(outer.Faces) + 1)]
    check_faces(outer, cavity, finish_face, thicknesses, max(LIP_HEIGHT_MM, 2.0 * thickness_mm))
    return [hollowed(outer, cavity, past_mouth, finish_face), cavity, past_mouth]


def _normal(face: Part.Face, point: FreeCAD.Vector) -> FreeCAD.Vector:
    return face.normalAt(*face.Surface.parameter(point))


def _with_face_moved(solid: Part.Shape, face: Part.Face, outward_mm: float) -> Part.Shape:
    """Return a solid whose planar face is moved along its normal."""
    middle, normal = face.CenterOfMass, _normal(face, face.CenterOfMass)
    if outward_mm >= 0.0:
        moved = solid.fuse(face.extrude(normal * outward_mm)) if outward_mm > 0.0 else solid
    else:
        if max((vertex.Point - middle).dot(normal) for vertex in solid.Vertexes) > SUPPORT_MM:
            raise GlassWorkbenchError("parts of the mold lie beyond the plane of a face whose wall shall be thicker")
        reach = solid.BoundBox.DiagonalLength
        sheet = Part.makePlane(4 * reach, 4 * reach, FreeCAD.Vector(-2 * reach, -2 * reach, 0))
        sheet.Placement = FreeCAD.Placement(
            middle + normal * outward_mm, FreeCAD.Rotation(FreeCAD.Vector(0, 0, 1), normal)
        ).multiply(sheet.Placement)
        moved = solid.cut(sheet.extrude(normal * 2 * reach))
    if len(moved.Solids) != 1:
        raise GlassWorkbenchError(f"with a face moved the mold falls into {len(moved.Solids)} parts")
    return moved.removeSplitter().Solids[0]
