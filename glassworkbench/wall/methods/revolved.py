"""The method for (nearly) round molds: the outer meridian offset inward, and turned."""

from __future__ import annotations

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.mold import Mold
from glassworkbench.scene import Mesh, Revolved
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.asking.bore import Bore
from glassworkbench.wall.asking.limits import THINNEST_MM
from glassworkbench.wall.candidate import Candidate
from glassworkbench.wall.measuring.outside import Outside
from glassworkbench.wall.solids import hollow_solid, revolved_solid
from glassworkbench.wall.turning.envelope import PAST_MOUTH_MM
from glassworkbench.wall.turning.inner_meridian import CavityMeridian, offset_meridian
from glassworkbench.wall.turning.profile import mouth_radius_mm, wall_meridian
from glassworkbench.wall.turning.turned_mesh import turned_mesh
from glassworkbench.wall.turning.unfolding import clearance

__all__ = ["PAST_MOUTH_MM", "CavityMeridian", "clearance", "offset_meridian", "revolved"]

DEVIATION_MM = 0.01
"""Of the inside's mesh; the bulge between its vertices is known a hundred times better."""

THINNEST_SHARE = 0.5
"""Where embossing goes into the body, at least this share of the wall must be left behind it."""


def revolved(mold: Mold, asked: AskedThickness, wall: Outside, seconds: float) -> Candidate:
    """Hollow a mold that is round but for threads and embossing, which do not show inside.

    Raises
    ------
    InputError
        If the wall fills the container, or nothing smooth leads to the bore.
    GlassWorkbenchError
        If the mold or, but for a bore, the wall asked is not round, or embossing goes through the wall.
    """
    anatomy = mold.anatomy
    if asked.over_height is None:
        raise GlassWorkbenchError("revolved: the wall asked varies with angle or face")
    if mold.core is None or not (anatomy.is_revolved or mold.is_nearly_round):
        raise GlassWorkbenchError(
            f"revolved: the mold departs from a body of revolution by {anatomy.departure_mm:.3g} mm"
        )
    if asked.bore is not None:
        _check_mouth(mold, asked.bore)
    meridian = wall_meridian(mold.core, anatomy, asked.over_height)
    cavity = offset_meridian(meridian, asked.over_height, asked.bore)
    inside = turned_mesh(cavity.segments, cavity.smooth_runs, DEVIATION_MM)
    if not anatomy.is_revolved:
        _check_behind_embossing(inside, wall, asked)
    solid = None
    if mold.upright is not None:
        solid = hollow_solid(mold.upright, revolved_solid(cavity), anatomy.finish_face)
    return Candidate(solid, Revolved(cavity.past_mouth), inside, meridian=cavity.segments)


def _check_mouth(mold: Mold, bore: Bore) -> None:
    """Refuse a bore that leaves nothing of the sealing surface."""
    widest = 2.0 * (mouth_radius_mm(mold.core, mold.anatomy.finish_height_mm) - THINNEST_MM)
    if 2.0 * bore.radius_mm > widest:
        raise InputError(
            f"wall bore: {2.0 * bore.radius_mm:g} mm leaves nothing of the sealing surface at height "
            f"{mold.anatomy.finish_height_mm:.1f} mm; ask for at most {widest:.2f} mm"
        )


def _check_behind_embossing(inside: Mesh, wall: Outside, asked: AskedThickness) -> None:
    points = inside.vertices_mm[inside.vertices_mm[:, 2] < wall.finish_height_mm - asked.maximum_mm]
    left = wall.distance(points).distance_mm
    thinnest = int(np.argmin(left))
    if left[thinnest] < THINNEST_SHARE * asked.minimum_mm:
        raise GlassWorkbenchError(
            f"revolved: the outside is not round, and only {left[thinnest]:.2f} mm of wall are left at height "
            f"{points[thinnest, 2]:.1f} mm"
        )
