"""One method's try at a wall: made, measured and judged. It runs in a worker process."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from glassworkbench.freecad import Part
from glassworkbench.mold import Mold, tessellate
from glassworkbench.mold.faults import near
from glassworkbench.mold.self_intersection import faces_cross, intersections, self_intersections
from glassworkbench.mold.tessellation import outside_mesh
from glassworkbench.scene import Mesh
from glassworkbench.wall.asking.given_way import notes_on_what_gives_way
from glassworkbench.wall.asking.narrow_regions import notes_on_narrow_regions
from glassworkbench.wall.asking.thickness import Thickness
from glassworkbench.wall.candidate import Candidate, HopelessError, Method
from glassworkbench.wall.container import SolidFacts
from glassworkbench.wall.measuring.measure import WallMeasure, in_finish_plane, measure_wall
from glassworkbench.wall.measuring.outside import DEVIATION_MM, is_mouth, outside_as_meshed
from glassworkbench.wall.measuring.surface import surface_area
from glassworkbench.wall.measuring.swallowed import note_on_swallowed
from glassworkbench.wall.measuring.volumes import Volume, mesh_volume, revolved_volume
from glassworkbench.wall.methods.csg import csg
from glassworkbench.wall.methods.inner_mesh import inner_mesh
from glassworkbench.wall.methods.lofted import lofted
from glassworkbench.wall.methods.revolved import revolved
from glassworkbench.wall.methods.scaled import scaled, scaled_per_axis
from glassworkbench.wall.methods.thick_solid import thick_solid

MAKERS: dict[str, Method] = {
    "revolved": revolved,
    "thick_solid": thick_solid,
    "lofted": lofted,
    "inner_mesh": inner_mesh,
    "csg": csg,
    "scaled": scaled,
    "scaled_per_axis": scaled_per_axis,
}

MAKING_SHARE = 0.7
"""What a method may use of the time that is left once the outside is meshed; the rest is for measuring."""

THINNER_SHARE = 0.05
"""Nowhere may the wall be thinner than asked by more than this share of it."""

VOLUME_SHARE = 0.005
"""The solid's volume must agree this well with outside minus inside."""

COARSE_MM = 1.0
"""Deviation of the mesh that the solid's volume is taken from where OCC's integral does not do."""

DEVIATION_SHARE = 0.02
"""The outside's triangles keep this close to it, as a share of the thinnest wall, where that is closer than usual."""


@dataclass(frozen=True, eq=False)
class Attempted:
    """What a method made, and how good it is.

    Parameters
    ----------
    candidate : Candidate
    outer : Mesh
    outer_faces : int array (m,)
        The outside and its triangles' faces, as `outside_mesh` gives them: what the wall was measured from.
    wall : WallMeasure
    solid : SolidFacts
    capacity, glass : Volume
        Of the cavity up to the finish plane, and of the glass; upright.
    area_outside_mm2, area_inside_mm2 : float
        Of the glass, as far as the finish plane.
    fault : str
        Why it is not good enough; empty if it is.
    """

    candidate: Candidate
    outer: Mesh
    outer_faces: np.ndarray
    wall: WallMeasure
    solid: SolidFacts
    capacity: Volume
    glass: Volume
    area_outside_mm2: float
    area_inside_mm2: float
    fault: str


def attempt(mold: Mold, thickness: Thickness, method: str, tolerance_mm: float, seconds: float) -> Attempted:
    """Return what one method makes of a mold, measured.

    Raises
    ------
    HopelessError
        If the mold crosses itself, or the wall asked swallows too much of itself.
    InputError
        If the wall cannot be: the message says where, and how much fits.
    GlassWorkbenchError
        If the method fails.
    """
    begin = time.monotonic()
    asked = thickness.on(mold)
    outer, faces = outside_mesh(mold, min(DEVIATION_MM, DEVIATION_SHARE * asked.minimum_mm))
    _check_simple(mold, outer)
    wall = outside_as_meshed(mold, outer, faces, asked.at)
    told = (
        *notes_on_narrow_regions(thickness, mold.anatomy),
        *notes_on_what_gives_way(thickness, asked, mold),
        *note_on_swallowed(wall, mold.anatomy.stem_top_mm),
    )
    candidate = MAKERS[method](mold, asked, wall, MAKING_SHARE * (seconds - (time.monotonic() - begin)))
    candidate = replace(candidate, notes=(*candidate.notes, *told))
    measured = measure_wall(candidate.inside, wall, stem_top_mm=mold.anatomy.stem_top_mm)
    capacity = _capacity(candidate)
    glass = _outer_volume(mold, outer).minus(capacity)
    solid = _facts(candidate, outer)
    return Attempted(
        candidate,
        outer,
        faces,
        measured,
        solid,
        capacity,
        glass,
        surface_area(outer, ~is_mouth(mold, faces)),
        surface_area(candidate.inside, ~in_finish_plane(candidate.inside)),
        _fault(candidate, measured, solid, capacity, glass, tolerance_mm),
    )


def _check_simple(mold: Mold, outer: Mesh) -> None:
    """Refuse a mold that crosses itself below its finish, where threads that do are left aside like embossing."""
    places = np.zeros((0, 3)) if mold.upright is None else self_intersections(outer)
    if len(places):
        places = places[places[:, 2] < mold.anatomy.regions["finish"][0]]
    if len(places) and faces_cross(mold.upright):
        place = mold.placement[:3, :3] @ places[0] + mold.placement[:3, 3]
        raise HopelessError(
            f"{mold.name}: the mold crosses itself {near(place)}, so inside and outside cannot be told apart; "
            "mend it in the CAD program"
        )


def _capacity(candidate: Candidate) -> Volume:
    if candidate.meridian is not None:
        return revolved_volume(candidate.meridian)
    return mesh_volume(candidate.inside)


def _outer_volume(mold: Mold, outer: Mesh) -> Volume:
    if mold.anatomy.is_revolved and mold.core is not None:
        return revolved_volume(mold.core)
    return mesh_volume(outer)


def _facts(candidate: Candidate, outer: Mesh) -> SolidFacts:
    crossing = len(self_intersections(candidate.inside)) > 0 or len(intersections(candidate.inside, outer)) > 0
    solid = candidate.solid
    if solid is None:
        return SolidFacts(True, True, crossing, len(candidate.inside.triangles))
    closed = len(solid.Solids) == 1 and all(shell.isClosed() for shell in solid.Shells)
    return SolidFacts(solid.isValid(), closed, crossing, len(solid.Faces), candidate.facets_off_mm)


def _fault(
    candidate: Candidate,
    wall: WallMeasure,
    solid: SolidFacts,
    capacity: Volume,
    glass: Volume,
    tolerance_mm: float,
) -> str:
    if wall.deviation_p99_mm > tolerance_mm:
        return (
            f"99 % of the wall is within {wall.deviation_p99_mm:.3g} mm of what was asked, "
            f"but the tolerance is {tolerance_mm:.3g} mm"
        ) + (f", as {candidate.limit}" if candidate.limit else "")
    if wall.thinner_than_asked_max > THINNER_SHARE:
        x, y, z = wall.minimum_at_mm
        angle = np.degrees(np.arctan2(y, x))
        return (
            f"it is {100.0 * wall.thinner_than_asked_max:.0f} % thinner than asked somewhere; its thinnest place, "
            f"{wall.minimum_mm:.3g} mm, is at height {z:.1f} mm, {angle:.0f} degrees"
        )
    if solid.self_intersecting:
        return "the inside crosses itself or the outside"
    if not (solid.valid and solid.closed):
        return "OCC calls the solid invalid or open"
    if candidate.solid is not None:
        slack = VOLUME_SHARE * (glass.volume_mm3 + capacity.volume_mm3)
        for volume in _volumes(candidate.solid):
            if abs(volume - glass.volume_mm3) <= slack:
                return ""
        return f"the solid holds {volume:.0f} mm3, but outside minus inside is {glass.volume_mm3:.0f} mm3"
    return ""


def _volumes(solid: Part.Shape) -> Iterator[float]:
    """Yield a solid's volume, first by the quickest way, last by the surest.

    OCC's integral is wrong on some long faces, and its fine mesh of a lofted one takes minutes. A coarse one does
    nearly always, as its vertices and normals are exact.
    """
    yield solid.Volume
    for deviation in (COARSE_MM, DEVIATION_MM):
        yield mesh_volume(tessellate(solid, deviation)).volume_mm3
