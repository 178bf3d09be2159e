"""The outer shape and the cavity of a container that is already hollow."""

from __future__ import annotations

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part


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
    faces_of_edge: dict[int, list[int]] = {}
    for number, face in enumerate(container.Faces):
        for edge in face.Edges:
            faces_of_edge.setdefault(edge.hashCode(), []).append(number)
    outside: set[int] = {rim_face - 1}
    waiting = list(rim.OuterWire.Edges)
    while waiting:
        for number in faces_of_edge[waiting.pop().hashCode()]:
            if number not in outside:
                outside.add(number)
                waiting += container.Faces[number].Edges
    outside.remove(rim_face - 1)
    inside = set(range(len(container.Faces))) - outside - {rim_face - 1}
    if not inside:
        raise InputError("its inside and its outside are joined apart from the rim; give the mold's solid instead")
    return tuple([container.Faces[number] for number in sorted(side)] for side in (outside, inside))
