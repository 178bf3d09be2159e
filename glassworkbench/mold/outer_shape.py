"""The outer shape and the cavity of a container that is already hollow."""

from __future__ import annotations

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part

LEVEL_SHARE = 1e-6
"""A rim is level, and round, if its crest keeps its height and its radius within this share of its radius."""

CUT_SHARES = (0.002, 0.005, 0.01, 0.02, 0.05)
"""Shares of the height by which a rim without a level crest is cut flat, the first that leaves a ring is taken."""


def outer_shape(container: Part.Shape, rim_face: int) -> Part.Shape:
    """Return the solid within the outside of a hollow container, closed by a flat face over its rim.

    Parameters
    ----------
    container : Part.Shape
        One solid.
    rim_face : int
        1-based number of the flat ring that parts its outside from its inside; 0 if there is none.

    Raises
    ------
    InputError
        If the rim is not a flat ring, or the inside is joined to the outside elsewhere.
    """
    outside, _ = _sides(container, rim_face)
    return _closed([Part.Face(container.Faces[rim_face - 1].OuterWire), *outside])


def outer_shape_within_crest(container: Part.Shape) -> tuple[Part.Shape, float]:
    """Return the solid within the outside of an upright hollow container whose rim is rounded, and what was cut off.

    The crest, the ring where the rim is highest, parts the outside from the inside: a flat face within it closes the
    solid. Where the crest is not level and round, the rim is cut flat below it.

    Parameters
    ----------
    container : Part.Shape
        One solid, its mouth toward +z, its axis on z.

    Returns
    -------
    outer : Part.Shape
    cut_mm : float
        How far below its top the rim was cut; 0 where the crest itself closes the solid.

    Raises
    ------
    InputError
        If the inside is joined to the outside apart from the rim.
    """
    top, radius = _crest(container)
    if radius is None:
        return _cut_flat(container, top)
    shell = _split_at(container, top, radius)
    rim = [edge for edge in shell.Edges if _lies_on_ring(edge, top, radius)]
    if not rim:
        return _cut_flat(container, top)
    neighbours = _faces_of_edges(shell)
    first = max(neighbours[rim[0].hashCode()], key=lambda number: _mean_radius(shell.Faces[number]))
    outside = _reached(shell, [first], {edge.hashCode() for edge in rim})
    if len(outside) == len(shell.Faces):
        raise InputError("its inside and its outside are joined apart from the rim; give the mold's solid instead")
    lid = Part.Face(Part.Wire(Part.__sortEdges__(rim)))
    return _closed([lid, *(shell.Faces[number] for number in outside)]), 0.0


def cavity_shape(container: Part.Shape, rim_face: int, past_mouth_mm: float) -> Part.Shape:
    """Return the solid within the inside of an upright hollow container, going straight on past the mouth.

    Parameters
    ----------
    container : Part.Shape
        One solid, its mouth toward +z.
    rim_face : int
        1-based number of the flat ring that parts its outside from its inside; 0 if there is none.
    past_mouth_mm : float

    Raises
    ------
    InputError
        As `outer_shape`.
    """
    _, inside = _sides(container, rim_face)
    rim = container.Faces[rim_face - 1]
    mouth = next(wire for wire in rim.Wires if not wire.isSame(rim.OuterWire))
    rise = FreeCAD.Vector(0, 0, past_mouth_mm)
    lid = Part.Face(mouth)
    lid.translate(rise)
    return _closed([*inside, *mouth.extrude(rise).Faces, lid])


def _closed(faces: list[Part.Face]) -> Part.Shape:
    shell = Part.makeShell(faces)
    shell.sewShape()
    return Part.makeSolid(shell)


def _sides(container: Part.Shape, rim_face: int) -> tuple[list[Part.Face], list[Part.Face]]:
    """Return the faces outside and those inside of the rim."""
    if rim_face == 0:
        raise InputError("its rim is rounded, so nothing parts outside from inside; give the mold's solid instead")
    rim = container.Faces[rim_face - 1]
    neighbours = _faces_of_edges(container)
    first = {number for edge in rim.OuterWire.Edges for number in neighbours[edge.hashCode()]} - {rim_face - 1}
    outside = _reached(container, sorted(first), {edge.hashCode() for edge in rim.Edges})
    inside = sorted(set(range(len(container.Faces))) - set(outside) - {rim_face - 1})
    bordering = {number for edge in rim.Edges for number in neighbours[edge.hashCode()]} - {rim_face - 1}
    if not bordering - set(outside):
        raise InputError("its inside and its outside are joined apart from the rim; give the mold's solid instead")
    return [container.Faces[number] for number in outside], [container.Faces[number] for number in inside]


def _faces_of_edges(shape: Part.Shape) -> dict[int, list[int]]:
    """Return the places in `shape.Faces` of the faces at each edge, by the edge's hash code."""
    neighbours: dict[int, list[int]] = {}
    for number, face in enumerate(shape.Faces):
        for edge in face.Edges:
            neighbours.setdefault(edge.hashCode(), []).append(number)
    return neighbours


def _reached(shape: Part.Shape, first: list[int], border: set[int]) -> list[int]:
    """Return the places of the faces that can be reached from the first ones without crossing the border's edges."""
    neighbours = _faces_of_edges(shape)
    reached, waiting = set(first), list(first)
    while waiting:
        for edge in shape.Faces[waiting.pop()].Edges:
            if edge.hashCode() not in border:
                new = set(neighbours[edge.hashCode()]) - reached
                reached |= new
                waiting += new
    return sorted(reached)


def _crest(container: Part.Shape) -> tuple[float, float | None]:
    """Return the height and the radius of an upright container's crest; no radius where it is not level and round."""
    box = container.BoundBox
    reach = 2.0 * box.DiagonalLength
    above = box.ZMax + 1.0
    radii, heights = [], []
    for turn in np.arange(8) * 0.25 * np.pi:
        sector = Part.makePlane(reach, 1e-3 * box.XLength, FreeCAD.Vector(0, 0, above))
        sector.rotate(FreeCAD.Vector(), FreeCAD.Vector(0, 0, 1), np.degrees(turn))
        _, pairs, _ = sector.distToShape(container)
        heights.append(pairs[0][1].z)
        radii.append(np.hypot(pairs[0][1].x, pairs[0][1].y))
    level = max(np.ptp(radii), np.ptp(heights)) < LEVEL_SHARE * max(radii)
    return max(heights), float(np.mean(radii)) if level else None


def _split_at(container: Part.Shape, top: float, radius: float) -> Part.Shape:
    """Return the container's shell, its faces that reach the crest parted there into what is outside and inside."""
    within = Part.makeCylinder(radius, 2.0 * top, FreeCAD.Vector(0, 0, -0.5 * top))
    faces = []
    for face in container.Faces:
        if face.BoundBox.ZMax > top - LEVEL_SHARE * radius:
            faces += [*face.cut(within).Faces, *face.common(within).Faces]
        else:
            faces.append(face)
    shell = Part.makeShell(faces)
    shell.sewShape()
    return shell


def _lies_on_ring(edge: Part.Edge, height: float, radius: float) -> bool:
    low, high = edge.ParameterRange
    near = 1e3 * LEVEL_SHARE * radius
    places = [edge.valueAt(low + share * (high - low)) for share in (0.0, 0.3, 0.7, 1.0)]
    return all(abs(p.z - height) < near and abs(np.hypot(p.x, p.y) - radius) < near for p in places)


def _mean_radius(face: Part.Face) -> float:
    return float(np.mean([np.hypot(point.x, point.y) for point in face.tessellate(0.1)[0]]))


def _cut_flat(container: Part.Shape, top: float) -> tuple[Part.Shape, float]:
    for share in CUT_SHARES:
        size = 2.0 * container.BoundBox.DiagonalLength
        below = Part.makeBox(2 * size, 2 * size, size + (1.0 - share) * top, FreeCAD.Vector(-size, -size, -size))
        cut = container.common(below)
        for number, face in enumerate(cut.Faces, start=1):
            if len(cut.Solids) == 1 and len(face.Wires) == 2 and face.BoundBox.ZMin > (1.0 - share) * top - 1e-6:
                return outer_shape(cut.Solids[0], number), share * top
    raise InputError("its rim is rounded, so nothing parts outside from inside; give the mold's solid instead")
