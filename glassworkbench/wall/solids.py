"""B-rep solids of a hollow container: the cavity revolved, and the outside joined to the inside at the mouth."""

from __future__ import annotations

import itertools

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.wall.turning.inner_meridian import CavityMeridian

STRAIGHT_MM = 1e-6
"""A cubic whose inner control points lie this close to its chord is a line."""

FLAT_MM = 1e-5
"""A face within this of the finish plane lies in it."""

SEWING_MM = 1e-5


def revolved_solid(cavity: CavityMeridian) -> Part.Shape:
    """Return the cavity up to the finish plane as a solid, one face for each smooth run of its meridian."""
    edges = [_edge(cavity.segments[first:last]) for first, last in cavity.smooth_runs]
    ends = cavity.segments[-1, 3], cavity.segments[0, 0]
    edges.append(Part.LineSegment(*(_vector(end) for end in ends)).toShape())
    face = Part.Face(Part.Wire(edges))
    solid = face.revolve(FreeCAD.Vector(0, 0, 0), FreeCAD.Vector(0, 0, 1), 360)
    return _outward(Part.Solid(solid.Shells[0]))


def hollow_solid(outer: Part.Shape, cavity: Part.Shape, finish_face: int) -> Part.Shape:
    """Return the outer solid without the cavity, which ends level at the outer solid's finish face.

    Parameters
    ----------
    outer, cavity : Part.Shape
        Upright solids.
    finish_face : int
        1-based number of the planar face of `outer` at the mouth.

    Raises
    ------
    GlassWorkbenchError
        If the two do not join to one closed, valid solid.
    """
    finish = outer.Faces[finish_face - 1]
    height = finish.CenterOfMass.z
    mouth = [face for face in cavity.Faces if _lies_at(face, height)]
    if len(mouth) != 1:
        raise GlassWorkbenchError(f"the cavity has {len(mouth)} faces in the plane of the mouth, where one must be")
    rim = finish.cut(mouth[0])
    walls = [face for number, face in enumerate(outer.Faces, start=1) if number != finish_face]
    inside = [face.reversed() for face in cavity.Faces if not face.isSame(mouth[0])]
    shell = Part.Shell([*walls, *rim.Faces, *inside])
    shell.sewShape(SEWING_MM)
    shells = shell.Shells
    if len(shells) != 1 or not shells[0].isClosed():
        raise GlassWorkbenchError("the outside and the inside do not join at the mouth to one closed shell")
    solid = _outward(Part.Solid(shells[0]))
    if not solid.isValid():
        raise GlassWorkbenchError("the outside and the inside join at the mouth to a solid that is not valid")
    return solid


def _edge(run: np.ndarray) -> Part.Edge:
    """Return a smooth chain of cubics (n, 4, 3) as one edge.

    Knot spans are chosen so that the handles on both sides of a joint agree in length: OCC's algorithms want curves
    whose derivative, not only its direction, is continuous.
    """
    if len(run) == 1 and _is_line(run[0]):
        return Part.LineSegment(_vector(run[0, 0]), _vector(run[0, 3])).toShape()
    spans = [1.0]
    for before, after in itertools.pairwise(run):
        ratio = np.linalg.norm(after[1, :2] - after[0, :2]) / np.linalg.norm(before[3, :2] - before[2, :2])
        spans.append(spans[-1] * float(ratio))
    knots = np.concatenate([[0.0], np.cumsum(spans)])
    poles = [run[0, 0], *(point for segment in run for point in segment[1:3]), run[-1, 3]]
    curve = Part.BSplineCurve()
    curve.buildFromPolesMultsKnots(
        [_vector(pole) for pole in poles],
        [4, *[2] * (len(run) - 1), 4],
        (knots / knots[-1]).tolist(),
        False,
        3,
    )
    return curve.toShape()


def _is_line(segment: np.ndarray) -> bool:
    chord = segment[3, :2] - segment[0, :2]
    normal = np.array([-chord[1], chord[0]]) / np.linalg.norm(chord)
    return bool(np.abs((segment[1:3, :2] - segment[0, :2]) @ normal).max() < STRAIGHT_MM)


def _vector(point: np.ndarray) -> FreeCAD.Vector:
    return FreeCAD.Vector(float(point[0]), 0.0, float(point[1]))


def _lies_at(face: Part.Face, height: float) -> bool:
    return face.BoundBox.ZLength < FLAT_MM and abs(face.CenterOfMass.z - height) < FLAT_MM


def _outward(solid: Part.Shape) -> Part.Shape:
    vertices, triangles = solid.tessellate(0.02 * solid.BoundBox.DiagonalLength)
    vertices = np.array([tuple(vertex) for vertex in vertices])
    a, b, c = (vertices[np.array(triangles)[:, k]] - vertices[0] for k in range(3))
    return solid if np.einsum("ij,ij->", a, np.cross(b, c)) > 0.0 else solid.reversed()
