"""Hollows a mold by the first method whose result, measured, is what was asked."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import Part
from glassworkbench.mold import Mold, tessellate
from glassworkbench.mold.mold import moved
from glassworkbench.mold.tessellation import outside_mesh
from glassworkbench.scene import Mesh, Revolved
from glassworkbench.scene.validate import positive
from glassworkbench.settings import unknown_name
from glassworkbench.wall.container import Attempt, Container, SolidFacts, WallReport
from glassworkbench.wall.contents import centre_of_gravity, weight_g
from glassworkbench.wall.measure import WallMeasure, in_finish_plane, measure_wall
from glassworkbench.wall.measure_meridian import clearance_to_mesh, measure_revolved
from glassworkbench.wall.outside import Outside, outside
from glassworkbench.wall.profile import wall_meridian
from glassworkbench.wall.revolved import offset_meridian
from glassworkbench.wall.solids import hollow_solid, revolved_solid
from glassworkbench.wall.surface import surface_area
from glassworkbench.wall.thick_solid import thick_solid
from glassworkbench.wall.thickness import Thickness, ThicknessOverHeight, UniformThickness, parse_thickness
from glassworkbench.wall.volumes import Volume, mesh_volume, revolved_volume
from glassworkbench.wall.worker import run_in_worker

METHODS = ("auto", "revolved", "thick_solid")

TOLERANCE_SHARE, TOLERANCE_MM = 0.02, 0.02
"""Unless told otherwise, 99 % of the wall must come out within this share of the thinnest wall, or this."""

VOLUME_SHARE = 0.005
"""The solid's volume, from its mesh, must agree this well with outside minus inside."""

MEASURED_DEVIATION_MM = 0.05
"""Deviation of the meshes that are measured; `measure` corrects for their facets."""

THINNEST_SHARE = 0.5
"""Where embossing goes into the body, at least this share of the wall must be left behind it."""


@dataclass(frozen=True, eq=False)
class _Candidate:
    """What a method made: upright solid, cavity past the mouth, the same up to the finish, and their measures."""

    solid: Part.Shape
    cavity: Revolved | Part.Shape
    inside: Mesh
    wall: WallMeasure
    capacity: Volume
    glass: Volume


def hollow(
    mold: Mold,
    thickness: Thickness | str | float,
    *,
    method: str = "auto",
    tolerance_mm: float | None = None,
    seconds: float = 120.0,
) -> Container:
    """Return the container that a mold makes with a given wall.

    Parameters
    ----------
    mold : Mold
    thickness : Thickness, str or float
        A wall specification as `parse_thickness` reads it, or mm.
    method : {"auto", "revolved", "thick_solid"}
        Auto tries `revolved` first for (nearly) round molds, then `thick_solid`.
    tolerance_mm : float, optional
        What 99 % of the inner surface may deviate from the wall asked; 2 % of the thinnest wall, at least 0.02 mm,
        if not given.
    seconds : float
        Time for all methods together; OCC's offset is stopped when it is over.

    Raises
    ------
    InputError
        If the wall cannot be, or does not fit into the mold, or the method is unknown.
    GlassWorkbenchError
        If no method's result is good enough; the message says what was tried.
    """
    start = time.monotonic()
    thickness = as_thickness(thickness)
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    asked = thickness.over_height(mold.anatomy)
    _check_fits(mold, asked)
    tolerance = (
        max(TOLERANCE_SHARE * asked.minimum_mm, TOLERANCE_MM)
        if tolerance_mm is None
        else positive(tolerance_mm, "tolerance_mm")
    )
    limit = positive(seconds, "seconds")

    attempts: list[Attempt] = []
    for name, make in _MAKERS.items():
        if method not in ("auto", name):
            continue
        begin = time.monotonic()
        candidate = None
        unsuitable = _UNSUITABLE[name](mold, asked)
        if unsuitable:
            outcome, why = "unsuitable", unsuitable
        else:
            try:
                candidate = make(mold, asked, limit - (begin - start))
                fault = _fault(candidate, tolerance)
                outcome, why = ("rejected", fault) if fault else ("accepted", "")
            except InputError:
                raise
            except GlassWorkbenchError as error:
                outcome, why = "failed", str(error)
        attempts.append(Attempt(name, outcome, why, time.monotonic() - begin))
        if outcome == "accepted":
            return _container(mold, thickness, name, candidate, attempts, tolerance, time.monotonic() - start)
    story = "; ".join(f"{attempt.method}: {attempt.why}" for attempt in attempts)
    raise GlassWorkbenchError(
        f"{mold.name}: no method gives a wall of {thickness} mm within {tolerance:.3g} mm ({story}); "
        "ask for another wall, a larger tolerance or more time"
    )


def as_thickness(value: Thickness | str | float) -> Thickness:
    """Return a thickness as data, whether it is given so, as text, or as a number of mm."""
    if isinstance(value, str):
        return parse_thickness(value)
    return value if isinstance(value, Thickness) else UniformThickness(value)


def _check_fits(mold: Mold, asked: ThicknessOverHeight) -> None:
    anatomy = mold.anatomy
    room = 0.5 * min(anatomy.smallest_width_mm, anatomy.height_mm)
    if asked.minimum_mm >= room:
        raise InputError(
            f"wall: {asked.minimum_mm:g} mm is thicker than {mold.name} allows; it must be below {room:.2f} mm"
        )
    at_finish = float(asked.at(anatomy.finish_height_mm))
    if at_finish >= anatomy.finish_outer_radius_mm:
        raise InputError(
            f"wall: {at_finish:g} mm closes the mouth at height {anatomy.finish_height_mm:.1f} mm, where it must be "
            f"below {anatomy.finish_outer_radius_mm:.2f} mm"
        )


def _revolved(mold: Mold, asked: ThicknessOverHeight, seconds: float) -> _Candidate:
    wall = wall_meridian(mold.core, mold.anatomy, asked)
    cavity = offset_meridian(wall, asked)
    inside = revolved_solid(cavity)
    solid = hollow_solid(mold.upright, inside, mold.anatomy.finish_face)
    capacity = revolved_volume(cavity.segments)
    surface = Revolved(cavity.past_mouth)
    if mold.anatomy.is_revolved:
        glass = revolved_volume(mold.core).minus(capacity)
    else:
        outer = tessellate(mold.upright, MEASURED_DEVIATION_MM)
        glass = mesh_volume(outer).minus(capacity)
        _check_behind_embossing(outer, cavity.segments, mold, asked)
    inside = tessellate(inside, MEASURED_DEVIATION_MM)
    return _Candidate(solid, surface, inside, measure_revolved(wall, cavity.segments, asked), capacity, glass)


def _check_behind_embossing(outer: Mesh, cavity: np.ndarray, mold: Mold, asked: ThicknessOverHeight) -> None:
    thinnest, place = clearance_to_mesh(outer, cavity, mold.anatomy.finish_height_mm - asked.maximum_mm)
    if thinnest < THINNEST_SHARE * asked.minimum_mm:
        raise GlassWorkbenchError(
            f"the outside is not round: only {thinnest:.2f} mm of wall are left at height {place[2]:.1f} mm"
        )


def _thick_solid(mold: Mold, asked: ThicknessOverHeight, seconds: float) -> _Candidate:
    arguments = {"finish_face": mold.anatomy.finish_face, "thickness_mm": asked.uniform_mm}
    solid, cavity, past_mouth = run_in_worker(thick_solid, [mold.upright], arguments, seconds)
    cavity_mesh = tessellate(cavity, MEASURED_DEVIATION_MM)
    capacity = mesh_volume(cavity_mesh)
    wall = measure_wall(cavity_mesh, _outside(mold, asked))
    glass = mesh_volume(tessellate(mold.upright, MEASURED_DEVIATION_MM)).minus(capacity)
    return _Candidate(solid, past_mouth, cavity_mesh, wall, capacity, glass)


def _outside(mold: Mold, asked: ThicknessOverHeight) -> Outside:
    return outside(mold, lambda points, faces: asked.at(points[:, 2]))


def _not_round(mold: Mold, asked: ThicknessOverHeight) -> str:
    if mold.anatomy.is_revolved or mold.is_nearly_round:
        return ""
    return f"the mold departs from a body of revolution by {mold.anatomy.departure_mm:.3g} mm"


def _not_offsettable(mold: Mold, asked: ThicknessOverHeight) -> str:
    if asked.uniform_mm is None:
        return "OCC offsets by one thickness only, and the wall asked varies"
    return "a stem would be hollowed too" if mold.anatomy.stem_top_mm > 0.0 else ""


_MAKERS: dict[str, Callable[[Mold, ThicknessOverHeight, float], _Candidate]] = {
    "revolved": _revolved,
    "thick_solid": _thick_solid,
}
_UNSUITABLE = {"revolved": _not_round, "thick_solid": _not_offsettable}


def _fault(candidate: _Candidate, tolerance_mm: float) -> str:
    """Return what is wrong with a candidate, nothing if it is good."""
    if candidate.wall.deviation_p99_mm > tolerance_mm:
        return (
            f"99 % of the wall is within {candidate.wall.deviation_p99_mm:.3g} mm of what was asked, "
            f"but the tolerance is {tolerance_mm:.3g} mm"
        )
    facts = _facts(candidate.solid)
    if not (facts.valid and facts.closed):
        return "OCC calls the solid invalid or open"
    volume = mesh_volume(tessellate(candidate.solid, MEASURED_DEVIATION_MM)).volume_mm3
    expected = candidate.glass.volume_mm3
    if abs(volume - expected) > VOLUME_SHARE * (expected + candidate.capacity.volume_mm3):
        return f"the solid holds {volume:.0f} mm3, but outside minus inside is {expected:.0f} mm3"
    return ""


def _facts(solid: Part.Shape) -> SolidFacts:
    closed = len(solid.Solids) == 1 and all(shell.isClosed() for shell in solid.Shells)
    # A cavity that crosses itself never becomes a candidate: each method checks its own.
    return SolidFacts(solid.isValid(), closed, False, len(solid.Faces))


def _container(
    mold: Mold,
    thickness: Thickness,
    method: str,
    candidate: _Candidate,
    attempts: list[Attempt],
    tolerance_mm: float,
    seconds: float,
) -> Container:
    solid = moved(candidate.solid, mold.placement)
    outer, faces = outside_mesh(mold, MEASURED_DEVIATION_MM)
    report = WallReport(
        method=method,
        tried=tuple(attempts),
        asked=str(thickness),
        wall=replace(candidate.wall, minimum_at_mm=_in_cad(mold, candidate.wall.minimum_at_mm)),
        tolerance_mm=tolerance_mm,
        solid=_facts(solid),
        glass_volume_mm3=candidate.glass.volume_mm3,
        weight_g=weight_g(candidate.glass.volume_mm3),
        brimful_ml=1e-3 * candidate.capacity.volume_mm3,
        centre_of_gravity_mm=_in_cad(mold, candidate.glass.centroid_mm),
        centre_of_gravity_filled_mm=_in_cad(mold, centre_of_gravity(candidate.glass, candidate.capacity)),
        area_outside_mm2=surface_area(outer, faces != mold.anatomy.finish_face),
        area_inside_mm2=surface_area(candidate.inside, ~in_finish_plane(candidate.inside)),
        seconds=seconds,
    )
    wall = _outside(mold, thickness.over_height(mold.anatomy))
    return Container(mold, thickness, method, solid, candidate.cavity, report, candidate.inside, wall)


def _in_cad(mold: Mold, point_mm: np.ndarray) -> np.ndarray:
    return mold.placement[:3, :3] @ point_mm + mold.placement[:3, 3]
