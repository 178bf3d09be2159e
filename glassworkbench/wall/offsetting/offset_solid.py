"""The container with a wall of one thickness, by OCC's offset, checked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import Part
from glassworkbench.wall.offsetting.healing import healed
from glassworkbench.wall.offsetting.offset_check import check_offset, check_solid
from glassworkbench.wall.offsetting.offset_ways import LIP_HEIGHT_MM, WAYS, above, below, cavity_past_mouth
from glassworkbench.wall.solids import hollow_solid


def offset_solid(
    outer: Part.Shape, finish_face: int, thickness_mm: float, ways: Sequence[str] = (), floor_mm: float = 0.0
) -> list[Part.Shape]:
    """Return the hollow solid, its cavity up to the finish plane, and the cavity reaching past the mouth.

    Parameters
    ----------
    outer : Part.Shape
        Upright solid.
    finish_face : int
        1-based number of the planar face at the mouth.
    thickness_mm : float
    ways : sequence of str
        Names of `WAYS`, tried in turn; all of them if none is given.
    floor_mm : float
        The cavity ends level at this height; 0 for a floor that follows the base.

    Raises
    ------
    GlassWorkbenchError
        If none of the ways gives a closed, valid cavity with the wall asked; the message says why.
    """
    reasons = []
    whole = healed(outer)
    cut = floor_mm - thickness_mm
    body = above(whole, cut) if floor_mm > 0.0 and cut > 0.0 else whole
    finish = outer.Faces[finish_face - 1]
    height = finish.CenterOfMass.z
    for way in (WAYS[name] for name in ways or WAYS):
        try:
            past_mouth = cavity_past_mouth(body, number_of(finish, body), thickness_mm, way)
            cavity = below(past_mouth, height)
            check_solid(cavity)
            check_offset(body, cavity, height, thickness_mm, max(LIP_HEIGHT_MM, 2.0 * thickness_mm))
            return [hollowed(whole, cavity, past_mouth, number_of(finish, whole)), cavity, past_mouth]
        # OCC raises errors of many kinds, which derive from Exception only.
        except Exception as error:
            reasons.append(str(error).strip() or type(error).__name__)
    raise GlassWorkbenchError(", or ".join(dict.fromkeys(reasons)))


def number_of(finish: Part.Face, solid: Part.Shape) -> int:
    """Return the 1-based number that the finish has in a solid of which some other faces were cut."""
    gaps = [
        (face.CenterOfMass - finish.CenterOfMass).Length + abs(face.Area - finish.Area) / finish.Length
        for face in solid.Faces
    ]
    return 1 + int(np.argmin(gaps))


def hollowed(outer: Part.Shape, cavity: Part.Shape, past_mouth: Part.Shape, finish_face: int) -> Part.Shape:
    """Return the outer solid without a cavity, which is given up to the finish plane and past the mouth."""
    try:
        return hollow_solid(outer, cavity, finish_face)
    except GlassWorkbenchError:
        # Slower, and it fails where faces nearly coincide, but it needs no exact match at the mouth.
        rest = outer.cut(past_mouth)
        if len(rest.Solids) != 1:
            raise
        return rest.Solids[0]
