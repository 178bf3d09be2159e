"""The method `thick_solid`: OCC's offset by way after way, each in a process of its own, and joined by zones."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import Part
from glassworkbench.wall.offset_ways import WAYS
from glassworkbench.wall.thick_solid import thick_solid
from glassworkbench.wall.worker import run_in_worker
from glassworkbench.wall.zones import Zone, check_zones, join_zones

TRY_SHARE = 0.5
"""No try gets more than this share of the time that is left, so that one which hangs leaves time for others."""

SHORTEST_TRY_SECONDS = 2.0
"""Starting FreeCAD takes about half of this."""


@dataclass(frozen=True, eq=False)
class ThickWall:
    """What OCC's offset made.

    Parameters
    ----------
    solid, cavity, past_mouth : Part.Shape
        Upright: the hollow solid, its cavity up to the finish plane, and the cavity reaching past the mouth.
    tries : tuple of str
        What was tried and how it ended, one line each.
    """

    solid: Part.Shape
    cavity: Part.Shape
    past_mouth: Part.Shape
    tries: tuple[str, ...]


def thick_wall(
    outer: Part.Shape,
    finish_face: int,
    zones: Sequence[Zone],
    bore_mm: float | None = None,
    seconds: float = 120.0,
) -> ThickWall:
    """Return a container with a wall by zones.

    Parameters
    ----------
    outer : Part.Shape
        Upright solid.
    finish_face : int
        1-based number of the planar face at the mouth.
    zones : sequence of (low_mm, high_mm, thickness_mm)
        Bottom to top, up to the finish; one from 0 for a uniform wall. Below the first one all is glass.
    bore_mm : float, optional
        Diameter of a straight bore in the topmost zone, instead of its thickness.
    seconds : float
        For all together. Each try gets a share of what is left.

    Raises
    ------
    InputError
        If the zones do not stand on one another, or the bore is no narrower than the finish.
    GlassWorkbenchError
        If no way leads to a cavity of one of the thicknesses, or they do not join; the message holds all tries.
    """
    deadline = time.monotonic() + seconds
    finish = outer.Faces[finish_face - 1]
    check_zones(zones, finish.CenterOfMass.z)
    if bore_mm is not None and not 0.0 < bore_mm < 2.0 * _largest_bore_radius(finish):
        raise InputError(
            f"bore: {bore_mm:g} mm do not fit into the finish; it must be below {2.0 * _largest_bore_radius(finish):g}"
        )
    tries: list[str] = []
    floor = zones[0][0]
    if len(zones) == 1 and bore_mm is None:
        return ThickWall(*_offset(outer, finish_face, zones[0][2], floor, deadline, tries), tuple(tries))
    offset_zones = zones if bore_mm is None else zones[:-1]
    thicknesses = list(dict.fromkeys(thickness for _, _, thickness in offset_zones))
    cavities = [_offset(outer, finish_face, thickness, floor, deadline, tries)[2] for thickness in thicknesses]
    arguments = {"finish_face": finish_face, "zones": zones, "thicknesses_mm": thicknesses, "bore_mm": bore_mm}
    try:
        shapes = run_in_worker(join_zones, [outer, *cavities], arguments, deadline - time.monotonic())
    except GlassWorkbenchError as error:
        raise GlassWorkbenchError(f"the zones do not join: {error}") from error
    return ThickWall(*shapes, tuple(tries))


def _largest_bore_radius(finish: Part.Face) -> float:
    """Return how far the edge of the finish is from the axis, at least."""
    return min((point.x**2 + point.y**2) ** 0.5 for point in finish.OuterWire.discretize(Number=256))


def _offset(
    outer: Part.Shape, finish_face: int, thickness_mm: float, floor_mm: float, deadline: float, tries: list[str]
) -> list[Part.Shape]:
    """Return what the first good way gives for one thickness; every outcome is added to the tries."""
    first = len(tries)
    for way in WAYS:
        left = deadline - time.monotonic()
        if left < SHORTEST_TRY_SECONDS:
            tries.append(f"{thickness_mm:g} mm: no time is left for other ways")
            break
        arguments = {"finish_face": finish_face, "thickness_mm": thickness_mm, "ways": [way], "floor_mm": floor_mm}
        try:
            shapes = run_in_worker(thick_solid, [outer], arguments, max(TRY_SHARE * left, SHORTEST_TRY_SECONDS))
        except GlassWorkbenchError as error:
            tries.append(f"{thickness_mm:g} mm, {way}: {error}")
        else:
            tries.append(f"{thickness_mm:g} mm, {way}: good")
            return shapes
    raise GlassWorkbenchError("; ".join(tries[first:]))
