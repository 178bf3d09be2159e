"""Ways to have OCC offset the faces of a container of any shape inward: each fails on other shapes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.wall.methods.revolved import PAST_MOUTH_MM
from glassworkbench.wall.offsetting.offset_check import facets, facets_volume

ARC, INTERSECTION = 0, 2
"""How OCC joins offset faces at a convex edge: by a rounding, or by extending both until they meet."""

LIP_HEIGHT_MM = 5.0
"""Faces beside the finish that lie wholly within this height of it are the lip's rounding."""

ODD_ANGLE_DEG = 33.7
"""A turn about the axis that brings no seam or edge of a container onto another's place."""


@dataclass(frozen=True)
class Way:
    """One way to have OCC offset a container inward.

    Parameters
    ----------
    offset : callable
        Makes the cavity past the mouth of an upright solid: `(outer, finish_face, thickness_mm, way)`.
    join : int
        ARC or INTERSECTION.
    intersections : bool
        Whether OCC looks for crossings of all faces, or of neighbours only.
    tolerance_mm : float
    turn_deg : float
        The solid is turned about its axis by this before the offset, and back after it.
    heel_share : float
        How much of the heel `level_floor` cuts away, in thicknesses.
    """

    offset: Callable[[Part.Shape, int, float, Way], Part.Shape]
    join: int
    intersections: bool = True
    tolerance_mm: float = 1e-4
    turn_deg: float = 0.0
    heel_share: float = 0.0


def cavity_past_mouth(outer: Part.Shape, finish_face: int, thickness_mm: float, way: Way) -> Part.Shape:
    """Return the cavity of an upright solid by a way, reaching past the mouth."""
    origin, axis = FreeCAD.Vector(), FreeCAD.Vector(0, 0, 1)
    turned = outer.copy()
    turned.rotate(origin, axis, way.turn_deg)
    past_mouth = way.offset(turned, finish_face, thickness_mm, way)
    past_mouth.rotate(origin, axis, -way.turn_deg)
    return past_mouth


def straight_bore(outer: Part.Shape, finish_face: int, thickness_mm: float, way: Way) -> Part.Shape:
    """Return the cavity past the mouth by an offset of the faces but the finish and the lip's rounding.

    The faces are continued by a straight collar that reaches above the mouth and offset inward as one open shell; the
    collar takes care that the mouth's edge is planar, and that the cavity reaches through it.
    """
    finish = outer.Faces[finish_face - 1]
    edges = {edge.hashCode() for edge in finish.Edges}
    walls = [
        face
        for number, face in enumerate(outer.Faces, start=1)
        if number != finish_face and not (_lowest(face) > finish.CenterOfMass.z - LIP_HEIGHT_MM and _has(face, edges))
    ]
    return _open_offset(walls, finish.CenterOfMass.z, thickness_mm, way)


def rounded_lip(outer: Part.Shape, finish_face: int, thickness_mm: float, way: Way) -> Part.Shape:
    """Return the cavity past the mouth by an offset of all faces but the finish, continued by a straight collar."""
    walls = [face for number, face in enumerate(outer.Faces, start=1) if number != finish_face]
    return _open_offset(walls, outer.Faces[finish_face - 1].CenterOfMass.z, thickness_mm, way)


def closed_solid(outer: Part.Shape, finish_face: int, thickness_mm: float, way: Way) -> Part.Shape:
    """Return the cavity past the mouth by an offset of the whole solid, its finish drawn up first."""
    finish = outer.Faces[finish_face - 1]
    rise = thickness_mm + 2.0 * PAST_MOUTH_MM
    plug = finish.extrude(FreeCAD.Vector(0, 0, rise))
    walls = [face for number, face in enumerate(outer.Faces, start=1) if number != finish_face]
    sides = [face for face in plug.Faces if not _is_level(face, finish.CenterOfMass.z)]
    shell = Part.Shell([*walls, *sides])
    shell.sewShape(1e-6)
    inside = Part.Solid(shell).makeOffsetShape(-thickness_mm, way.tolerance_mm, way.intersections, False, 0, way.join)
    return below(_outward(inside), finish.CenterOfMass.z + PAST_MOUTH_MM)


def level_floor(outer: Part.Shape, finish_face: int, thickness_mm: float, way: Way) -> Part.Shape:
    """Return the cavity past the mouth by an offset of the sides, cut level a wall above the base.

    A heel that is rounded more tightly than the wall is thick has no counterpart inside, but OCC keeps its offset,
    which folds over itself. So the heel is cut away, and what is above it continued straight down.
    """
    height = outer.Faces[finish_face - 1].CenterOfMass.z
    cut = way.heel_share * thickness_mm
    sides = above(outer, cut)
    walls = [face for face in sides.Faces if not _is_level(face, cut) and not _is_level(face, height)]
    inside = _offset(_with_collar(walls, height), thickness_mm, way)
    lower = min(_openings(inside), key=lambda wire: wire.CenterOfMass.z)
    skirt = [face for edge in lower.Edges for face in edge.extrude(FreeCAD.Vector(0, 0, -2.0 * thickness_mm)).Faces]
    shell = Part.Shell([*inside, *skirt])
    shell.sewShape(1e-5)
    tube = shell.cut(_box(shell, -np.inf, thickness_mm))
    return below(_closed(tube.Faces), height + PAST_MOUTH_MM)


WAYS: dict[str, Way] = {
    "closed": Way(closed_solid, ARC),
    "level floor": Way(level_floor, ARC, heel_share=0.5),
    "straight bore": Way(straight_bore, ARC),
    "extended": Way(straight_bore, INTERSECTION),
    "neighbours": Way(straight_bore, ARC, intersections=False),
    "turned": Way(closed_solid, ARC, turn_deg=ODD_ANGLE_DEG),
    "coarse": Way(straight_bore, ARC, tolerance_mm=1e-2),
    "level floor, higher": Way(level_floor, ARC, heel_share=1.0),
    "rounded lip": Way(rounded_lip, INTERSECTION),
}
"""By the order in which they are tried."""


def _has(face: Part.Face, edges: set[int]) -> bool:
    return any(edge.hashCode() in edges for edge in face.Edges)


def _lowest(face: Part.Face) -> float:
    return min(point.z for point in face.tessellate(0.1)[0])


def _is_level(face: Part.Face, height: float) -> bool:
    return all(abs(point.z - height) < 1e-6 for point in face.tessellate(0.1)[0])


def _open_offset(walls: Sequence[Part.Face], height: float, thickness_mm: float, way: Way) -> Part.Shape:
    inside = _offset(_with_collar(walls, height), thickness_mm, way)
    openings = len(_openings(inside))
    if openings != 1:
        raise GlassWorkbenchError(f"the offset has {openings} openings, where one must be")
    return below(_closed(inside), height + PAST_MOUTH_MM)


def _with_collar(walls: Sequence[Part.Face], height: float) -> Part.Shape:
    """Return the walls as a shell that goes straight on past the mouth."""
    middle = 0.5 * height
    boundary = [edge for edge in _free_edges(walls) if edge.CenterOfMass.z > middle]
    rise = height + 2.0 * PAST_MOUTH_MM - max(vertex.Z for edge in boundary for vertex in edge.Vertexes)
    collar = [edge.extrude(FreeCAD.Vector(0, 0, rise)) for edge in boundary]
    shell = Part.Shell([*walls, *(face for sheet in collar for face in sheet.Faces)])
    shell.sewShape(1e-6)
    if shell.ShapeType != "Shell":
        raise GlassWorkbenchError("the walls fall apart without the finish and the heel")
    return shell


def _offset(shape: Part.Shape, thickness_mm: float, way: Way) -> list[Part.Face]:
    faces = shape.makeOffsetShape(-thickness_mm, way.tolerance_mm, way.intersections, False, 0, way.join, False).Faces
    if not faces:
        raise GlassWorkbenchError("the offset is empty")
    return faces


def _openings(faces: Sequence[Part.Face]) -> list[Part.Wire]:
    return [Part.Wire(edges) for edges in Part.sortEdges(_free_edges(faces))]


def _closed(faces: Sequence[Part.Face]) -> Part.Shape:
    """Return the solid that faces bound when their openings, which are level, are closed."""
    shell = Part.Shell([*faces, *map(Part.Face, _openings(faces))])
    shell.sewShape(1e-5)
    return _outward(Part.Solid(shell.Shells[0]))


def _free_edges(faces: Sequence[Part.Face]) -> list[Part.Edge]:
    """Return the edges that only one of the faces has."""
    edges = [edge for face in faces for edge in face.Edges if not (edge.Degenerated or edge.isSeam(face))]
    counts = Counter(edge.hashCode() for edge in edges)
    return [edge for edge in edges if counts[edge.hashCode()] == 1]


def below(solid: Part.Shape, height_mm: float) -> Part.Shape:
    """Return what of an upright solid lies below a height.

    Raises
    ------
    GlassWorkbenchError
        If that is not one solid.
    """
    return _single(solid.cut(_box(solid, height_mm, np.inf)))


def above(solid: Part.Shape, height_mm: float) -> Part.Shape:
    """Return what of an upright solid lies above a height.

    Raises
    ------
    GlassWorkbenchError
        If that is not one solid.
    """
    return _single(solid.cut(_box(solid, -np.inf, height_mm)))


def _single(shape: Part.Shape) -> Part.Shape:
    if len(shape.Solids) != 1:
        raise GlassWorkbenchError(f"the cavity falls into {len(shape.Solids)} parts")
    return shape.Solids[0]


def _box(shape: Part.Shape, low_mm: float, high_mm: float) -> Part.Shape:
    """Return a box that holds all of a shape between two heights, which may be infinite."""
    box = shape.BoundBox
    reach = box.DiagonalLength
    low, high = max(low_mm, box.ZMin - reach), min(high_mm, box.ZMax + reach)
    corner = FreeCAD.Vector(box.XMin - reach, box.YMin - reach, low)
    return Part.makeBox(box.XLength + 2 * reach, box.YLength + 2 * reach, high - low, corner)


def _outward(solid: Part.Shape) -> Part.Shape:
    return solid if facets_volume(facets(solid, 0.1)) > 0.0 else solid.reversed()
