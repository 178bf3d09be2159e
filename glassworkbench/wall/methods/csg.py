"""A container without any inner B-rep: its outside minus another body, resolved ray by ray by the tracer."""

from __future__ import annotations

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.mold import Mold
from glassworkbench.scene import Mesh, Revolved, Surface
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.candidate import Candidate
from glassworkbench.wall.levels.level_cut import below
from glassworkbench.wall.levels.lids import PAST_MOUTH_MM, lifted
from glassworkbench.wall.levels.narrow import no_room
from glassworkbench.wall.levels.room import Room
from glassworkbench.wall.levels.round_level import RoundRoom, chain_of, trace
from glassworkbench.wall.measuring.outside import Outside
from glassworkbench.wall.turning.bezier import line
from glassworkbench.wall.turning.turned_mesh import turned_mesh

HALF_PLANES = 48
"""Where the outside is not round, its narrowest of so many half-planes decides."""

POINTS = 500
"""Steps along the meridian, of the height of the container."""

DEVIATION_MM = 0.02
"""Of the mesh that is measured; the tracer has the curves."""

LEVEL_MM = 1e-3
"""A cavity that ends this near to the finish plane ends in it."""

NOT_SAVED = "it is an outside minus another body, without a solid of its own, so it cannot be saved as STEP"


def csg(mold: Mold, asked: AskedThickness, wall: Outside, seconds: float) -> Candidate:
    """Give any outside, a mesh too, a round inside: the largest that leaves the wall asked everywhere."""
    anatomy, height = mold.anatomy, wall.finish_height_mm
    floor = anatomy.stem_top_mm + asked.maximum_mm if anatomy.stem_top_mm > 0.0 else -np.inf
    room = Room(wall, height, floor)
    start = np.array([0.0, height - 1e-3 * anatomy.height_mm])
    if room.value(np.array([[0.0, 0.0, start[1]]]))[0] <= 0.0:
        raise no_room(wall, asked.maximum_mm)
    round_room = RoundRoom(room, 1 if anatomy.is_revolved else HALF_PLANES)
    points, tangents = trace(round_room, start, anatomy.height_mm / POINTS)
    chain, runs = chain_of(points, tangents)
    end = points[-1]
    lid = line(end, np.array([0.0, end[1]]))
    inside = turned_mesh(np.concatenate([chain, lid[None]]), (*runs, (len(chain), len(chain) + 1)), DEVIATION_MM)
    top = height + PAST_MOUTH_MM
    above = [line(end, np.array([end[0], top])), line(np.array([end[0], top]), np.array([0.0, top]))]
    cavity = Revolved(np.concatenate([chain, above]))
    if anatomy.is_revolved:
        return Candidate(None, cavity, inside, (NOT_SAVED,))
    return Candidate(None, cavity, inside, (_told_thicker(wall, inside), NOT_SAVED), limit=_told_limit(mold))


def _told_limit(mold: Mold) -> str:
    """Return how far the outside is from round, which a round inside cannot follow, and what to do."""
    anatomy = mold.anatomy
    source = "give a finer mesh or the CAD solid" if mold.mesh is not None else "give a round mold"
    return (
        f"its inside is round and the outside departs from that by up to {anatomy.departure_mm:.2g} mm, "
        f"most at height {anatomy.departure_at_mm[2]:.1f} mm ({source}, or take the method auto, whose inside follows "
        "the outside)"
    )


def _told_thicker(wall: Outside, inside: Mesh) -> str:
    """Return how much thicker than asked the wall is, at most, as the outside is not as round as the inside."""
    points = inside.vertices_mm[inside.vertices_mm[:, 2] < wall.lip_height_mm - LEVEL_MM]
    excess = wall.clearance(points).clearance_mm
    thickest = int(np.argmax(excess))
    return (
        f"the inside is round and the outside is not: the wall is up to {excess[thickest]:.2g} mm thicker than asked, "
        f"most at height {points[thickest, 2]:.1f} mm"
    )


def csg_with(mold: Mold, cavity: Surface) -> Candidate:
    """Take a given body away from a mold.

    Parameters
    ----------
    mold : Mold
    cavity : Mesh or Revolved
        Upright, standing in the mold, closed; it ends level in the finish plane, or reaches above it.

    Raises
    ------
    InputError
        If it is of another kind, reaches out of the mold's sides or base, or does not open its mouth.
    """
    if isinstance(cavity, Revolved):
        runs = tuple((k, k + 1) for k in range(len(cavity.meridian)))
        body = turned_mesh(cavity.meridian, runs, DEVIATION_MM)
    elif isinstance(cavity, Mesh):
        body = cavity
    else:
        raise InputError("cavity: it must be a mesh or a body of revolution")
    height = mold.anatomy.finish_height_mm
    low, high = body.vertices_mm.min(axis=0), body.vertices_mm.max(axis=0)
    if low[2] <= 0.0 or np.abs(np.stack([low, high])[:, :2]).max() >= mold.anatomy.maximum_radius_mm:
        raise InputError(f"cavity: it reaches out of {mold.name}; place it where the mold stands in its own file")
    if high[2] < height - LEVEL_MM:
        raise InputError(
            f"cavity: it ends at height {high[2]:.2f} mm, below the mouth at {height:.2f} mm; make it reach the mouth"
        )
    try:
        if high[2] > height + LEVEL_MM:
            return Candidate(None, cavity, below(body, height), (NOT_SAVED,))
        return Candidate(None, lifted(body, float(high[2]), PAST_MOUTH_MM), body, (NOT_SAVED,))
    except GlassWorkbenchError as error:
        raise InputError(f"cavity: {error}; close it by a flat face there") from error
