"""The method `thick_solid`: OCC's offset by way after way, each in a process of its own, and joined by zones."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError, OutOfTimeError
from glassworkbench.freecad import Part
from glassworkbench.mold import Anatomy, Mold, tessellate
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.asking.by_face import ByFace
from glassworkbench.wall.candidate import Candidate, NoCandidateError
from glassworkbench.wall.measuring.outside import DEVIATION_MM, Outside
from glassworkbench.wall.offsetting.offset_solid import offset_solid
from glassworkbench.wall.offsetting.offset_ways import WAYS
from glassworkbench.wall.offsetting.per_face import FaceThickness, check_face, per_face_solid
from glassworkbench.wall.offsetting.zones import Zone, check_zones, join_zones, zones_over_height
from glassworkbench.wall.worker import run_in_worker

TRY_SHARE = 0.5
"""No try gets more than this share of the time that is left, so that one which hangs leaves time for others."""

SHORTEST_TRY_SECONDS = 2.0
"""Starting FreeCAD takes about half of this."""

MOST_ZONES = 6
"""More offsets than these take too long, and their steps are no wall anyone asked for."""

ZONE_LEVELS = 241
"""Heights at which the thickness asked is looked at."""

ZONE_DEVIATION_SHARE = 0.015
"""How far a zone may be from the thickness asked, as a share of the thinnest wall."""


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
    offset_zones = zones if bore_mm is None else zones[:-1]
    thicknesses = list(dict.fromkeys(thickness for _, _, thickness in offset_zones))
    made = []
    for thickness in thicknesses:
        arguments = {"finish_face": finish_face, "thickness_mm": thickness, "floor_mm": zones[0][0]}
        made.append(_first_good(offset_solid, outer, arguments, deadline, tries))
    if len(zones) == 1 and bore_mm is None:
        return ThickWall(*made[0], tuple(tries))
    cavities = [past_mouth for _, _, past_mouth in made]
    arguments = {"finish_face": finish_face, "zones": zones, "thicknesses_mm": thicknesses, "bore_mm": bore_mm}
    try:
        shapes = run_in_worker(join_zones, [outer, *cavities], arguments, deadline - time.monotonic())
    except GlassWorkbenchError as error:
        raise GlassWorkbenchError(f"the zones do not join: {error}") from error
    return ThickWall(*shapes, tuple(tries))


def _largest_bore_radius(finish: Part.Face) -> float:
    """Return how far the edge of the finish is from the axis, at least."""
    return min((point.x**2 + point.y**2) ** 0.5 for point in finish.OuterWire.discretize(Number=256))


def thick_wall_per_face(
    outer: Part.Shape,
    finish_face: int,
    thickness_mm: float,
    faces: Sequence[FaceThickness],
    seconds: float = 120.0,
) -> ThickWall:
    """Return a container with walls of their own behind planar faces bounded by sharp edges.

    Parameters
    ----------
    outer, finish_face, seconds
        As in `thick_wall`.
    thickness_mm : float
        Of all faces but those named.
    faces : sequence of (face, thickness_mm)
        1-based numbers of faces.

    Raises
    ------
    InputError
        If a face is not planar, or meets a neighbour smoothly.
    GlassWorkbenchError
        If no way leads to the walls asked; the message holds all tries.
    """
    for number, _ in faces:
        check_face(outer, number, finish_face)
    tries: list[str] = []
    arguments = {"finish_face": finish_face, "thickness_mm": thickness_mm, "faces": faces}
    shapes = _first_good(per_face_solid, outer, arguments, time.monotonic() + seconds, tries)
    return ThickWall(*shapes, tuple(tries))


def _first_good(
    job: Callable[..., list[Part.Shape]],
    outer: Part.Shape,
    arguments: dict[str, object],
    deadline: float,
    tries: list[str],
) -> list[Part.Shape]:
    """Return what a job makes of the outside by the first good way; every outcome is added to the tries."""
    out_of_time = False
    for way in WAYS:
        left = deadline - time.monotonic()
        label = f"{arguments['thickness_mm']:g} mm"
        if left < SHORTEST_TRY_SECONDS:
            tries.append(f"{label}: no time is left for other ways")
            out_of_time = True
            break
        try:
            share = max(TRY_SHARE * left, SHORTEST_TRY_SECONDS)
            shapes = run_in_worker(job, [outer], {**arguments, "ways": [way]}, share)
        except GlassWorkbenchError as error:
            tries.append(f"{label}, {way}: {error}")
            out_of_time |= isinstance(error, OutOfTimeError)
        else:
            tries.append(f"{label}, {way}: good")
            return shapes
    raise NoCandidateError(f"none of OCC's ways leads to it, the last: {tries[-1]}", tuple(tries), out_of_time)


def thick_solid(mold: Mold, asked: AskedThickness, wall: Outside, seconds: float) -> Candidate:
    """Return the container that OCC's offset makes of a mold.

    A wall that varies over the height becomes zones; one that steps from face to face is made by moving those faces.

    Raises
    ------
    GlassWorkbenchError
        If the mold is a mesh, the wall varies otherwise or too much for zones, a face with a wall of its own is not
        planar or has no sharp edges, or no way leads to it; a `NoCandidateError` tells of all ways.
    """
    if mold.upright is None:
        raise GlassWorkbenchError("OCC offsets the faces of CAD files only, and the mold is a mesh")
    made = _by_zones(mold, asked, seconds) if asked.by_face is None else _by_face(mold, asked.by_face, seconds)
    return Candidate(made.solid, made.past_mouth, tessellate(made.cavity, DEVIATION_MM), details=made.tries)


def _by_zones(mold: Mold, asked: AskedThickness, seconds: float) -> ThickWall:
    if asked.over_height is None:
        raise GlassWorkbenchError("OCC offsets by one thickness, and the wall asked varies otherwise than by height")
    bore_mm = None if asked.bore_radius_mm is None else 2.0 * asked.bore_radius_mm
    return thick_wall(mold.upright, mold.anatomy.finish_face, _zones(asked, mold.anatomy), bore_mm, seconds)


def _by_face(mold: Mold, by_face: ByFace, seconds: float) -> ThickWall:
    if by_face.blends:
        raise GlassWorkbenchError("OCC offsets each face by one thickness, and the wall asked blends across some")
    otherwise = float(by_face.thicknesses_mm[0])
    named = [
        (number, float(thickness)) for number, thickness in enumerate(by_face.thicknesses_mm) if thickness != otherwise
    ]
    try:
        return thick_wall_per_face(mold.upright, mold.anatomy.finish_face, otherwise, named, seconds)
    except InputError as error:
        # There is no such wall by this method; others may make it.
        raise GlassWorkbenchError(str(error)) from error


def _zones(asked: AskedThickness, anatomy: Anatomy) -> list[Zone]:
    low, high = anatomy.stem_top_mm, anatomy.finish_height_mm
    heights = np.linspace(low, high, ZONE_LEVELS)
    thicknesses = asked.over_height.at(heights)
    zones = zones_over_height(heights, thicknesses, ZONE_DEVIATION_SHARE * asked.minimum_mm)
    if len(zones) > MOST_ZONES:
        raise GlassWorkbenchError(
            f"OCC offsets by one thickness, and the wall asked varies so much that it needs {len(zones)} zones"
        )
    if asked.bore_radius_mm is not None:
        start = anatomy.regions["finish"][0]
        below = [(bottom, min(top, start), thickness) for bottom, top, thickness in zones if bottom < start]
        zones = [*below, (start, high, zones[-1][2])]
    return zones
