"""Closes an open shell with flat faces over its holes."""

from __future__ import annotations

from glassworkbench.errors import InputError
from glassworkbench.freecad import Part


def closed_solid(shape: Part.Shape) -> tuple[Part.Shape, list[str]]:
    """Return the solid within an open shell or loose faces, its flat holes closed, and a sentence that tells it.

    A shape whose solids are closed already is returned as it is, with no sentence.

    Parameters
    ----------
    shape : Part.Shape
        Faces that meet at their edges, in mm.

    Raises
    ------
    InputError
        If the edge of a hole is not flat, or the faces do not make one shell.
    """
    if shape.isNull() or (shape.Solids and all(shell.isClosed() for shell in shape.Shells)):
        return shape, []
    shell = _sewn(shape.Faces)
    owners: dict[int, int] = {}
    for face in shell.Faces:
        for edge in face.Edges:
            owners[edge.hashCode()] = owners.get(edge.hashCode(), 0) + 1
    # A seam belongs to one face and closes it all the same; an edge of no length (a cone's tip) bounds nothing.
    free = [edge for edge in shell.Edges if owners[edge.hashCode()] == 1 and not edge.Degenerated and edge.Length > 0.0]
    free = [edge for edge in free if not any(edge.isSeam(face) for face in shell.Faces)]
    lids = [_lid(Part.Wire(edges)) for edges in Part.sortEdges(free)]
    shell = _sewn([*shell.Faces, *lids])
    if len(shell.Shells) != 1 or not shell.isClosed():
        raise InputError("its faces do not make one closed surface even with their flat holes closed; repair the file")
    told = f"its surface was open: {len(lids)} flat {'hole was' if len(lids) == 1 else 'holes were'} closed"
    return Part.makeSolid(shell), [told] if lids else []


def _sewn(faces: list[Part.Face]) -> Part.Shape:
    shell = Part.makeShell(faces)
    shell.sewShape()
    return shell


def _lid(hole: Part.Wire) -> Part.Face:
    place = hole.Vertexes[0].Point
    where = f"near ({place.x:.3f}, {place.y:.3f}, {place.z:.3f}) mm"
    if not hole.isClosed() or hole.findPlane(1e-4) is None:
        raise InputError(
            f"its hole {where} is not flat, so no flat face closes it; close the surface in the CAD program"
        )
    return Part.Face(hole)
