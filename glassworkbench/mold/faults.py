"""What is wrong with a CAD shape, in sentences for its designer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from glassworkbench.freecad import Part
from glassworkbench.mold.measures import mesh_of
from glassworkbench.mold.self_intersection import crossing_places, faces_cross

LOOSE_MM = 1e-3
"""Edges that lie farther than this off their faces spoil offsets and booleans."""

TINY_MM = 0.01
"""Edges shorter than this are leftovers of modelling; offsets fail at them."""

USUAL_MM = (20.0, 1500.0)
"""Sizes of containers; others make the unit doubtful."""


def faults(shape: Part.Shape, unit: str | None) -> list[str]:
    """Return a sentence for each thing that is wrong with a shape (in mm), with its place; empty for a sound one.

    Parameters
    ----------
    shape : Part.Shape
    unit : str or None
        What the file says its lengths are in, if it says so.
    """
    return [
        *_doubtful_unit(shape, unit),
        *_invalid(shape),
        *_kinks(shape),
        *_loose_edges(shape),
        *_tiny_edges(shape),
        *_crossings(shape),
    ]


def _doubtful_unit(shape: Part.Shape, unit: str | None) -> list[str]:
    size = shape.BoundBox.DiagonalLength
    if USUAL_MM[0] < size < USUAL_MM[1]:
        return []
    declared = "" if unit is None else f", read as {unit}"
    remedy = "if that is wrong, give the scale to mm (scale_to_mm)"
    return [f"it is about {size:.2g} mm large{declared}, unusual for a container; {remedy}"]


def _invalid(shape: Part.Shape) -> list[str]:
    if shape.isValid():
        return []
    faces = [number for number, face in enumerate(shape.Faces, start=1) if not face.isValid()]
    where = f" ({_numbered(shape, faces)})" if faces else ""
    return [f"OCC finds the shape invalid{where}; repair it in the CAD program if hollowing fails"]


def _kinks(shape: Part.Shape) -> list[str]:
    broken = [
        number
        for number, face in enumerate(shape.Faces, start=1)
        if type(face.Surface).__name__ == "BSplineSurface" and face.Surface.Continuity == "C0"
    ]
    if not broken:
        return []
    return [
        f"B-spline faces have kinks (C0), which OCC cannot offset before it splits them: {_numbered(shape, broken)}"
    ]


def _loose_edges(shape: Part.Shape) -> list[str]:
    loose = [edge for edge in shape.Edges if not edge.Degenerated and edge.Tolerance > LOOSE_MM]
    if not loose:
        return []
    worst = max(loose, key=lambda edge: edge.Tolerance)
    count = "an edge lies" if len(loose) == 1 else f"{len(loose)} edges lie"
    return [f"{count} up to {worst.Tolerance:.2g} mm off the faces that meet there, the worst {_near(worst)}"]


def _tiny_edges(shape: Part.Shape) -> list[str]:
    tiny = [edge for edge in shape.Edges if not edge.Degenerated and edge.Length < TINY_MM]
    if not tiny:
        return []
    shortest = min(tiny, key=lambda edge: edge.Length)
    count = "an edge is" if len(tiny) == 1 else f"{len(tiny)} edges are"
    return [f"{count} shorter than {TINY_MM:g} mm, the shortest ({shortest.Length:.2g} mm) {_near(shortest)}"]


def _crossings(shape: Part.Shape) -> list[str]:
    # Solids of an assembly may touch each other: each is searched by itself.
    crossing = [part for part in shape.Solids or [shape] if faces_cross(part)]
    if not crossing:
        return []
    vertices, triangles = mesh_of(crossing[0])
    places = crossing_places(vertices[triangles])
    return [f"its surface crosses itself{f' {near(places[0])}' if len(places) else ''}"]


def _numbered(shape: Part.Shape, faces: list[int]) -> str:
    listed = [f"face {number} {_near(shape.Faces[number - 1])}" for number in faces[:3]]
    more = [f"{len(faces) - 3} more"] if len(faces) > 3 else []
    return ", ".join([*listed, *more])


def _near(part: Part.Shape) -> str:
    return near(part.CenterOfMass)


def near(place_mm: Sequence[float]) -> str:
    """Return where a place (3,) of the CAD file is, in words."""
    # Adding 0 makes zero of a minus zero.
    x, y, z = np.round(place_mm, 1) + 0.0
    return f"near ({x:.1f}, {y:.1f}, {z:.1f}) mm"
