"""The outer shape of a container that is already hollow."""

from __future__ import annotations

from glassworkbench.errors import InputError
from glassworkbench.freecad import Part


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
    if len(outside) == len(container.Faces) - 1:
        raise InputError("its inside and its outside are joined apart from the rim; give the mold's solid instead")
    lid = Part.Face(rim.OuterWire)
    shell = Part.makeShell([lid, *(container.Faces[number] for number in sorted(outside))])
    shell.sewShape()
    return Part.makeSolid(shell)
