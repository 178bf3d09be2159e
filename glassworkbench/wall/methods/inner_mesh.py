"""The inside of anything closed, as a mesh: its outside moved inward, overlaps resolved as a level set.

A face of the outside that its neighbours' walls swallow has no counterpart inside, and walls that meet are one: both
follow from the cavity being the set of points that keep their distance from every outer point.
"""

from __future__ import annotations

import time

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, OutOfTimeError
from glassworkbench.freecad import Part
from glassworkbench.mold import Mold
from glassworkbench.scene import Mesh
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.candidate import Candidate
from glassworkbench.wall.levels.cavity_nodes import cavity_nodes, without_border
from glassworkbench.wall.levels.dual_surface import without_ambiguity
from glassworkbench.wall.levels.faceted import faceted_solid, fewer_facets
from glassworkbench.wall.levels.level_mesh import level_mesh
from glassworkbench.wall.levels.level_set import sampled
from glassworkbench.wall.levels.lids import PAST_MOUTH_MM, lifted
from glassworkbench.wall.levels.narrow import no_room
from glassworkbench.wall.levels.room import Room
from glassworkbench.wall.measuring.outside import Outside
from glassworkbench.wall.measuring.surface import facets
from glassworkbench.wall.worker import run_in_worker

TOLERANCE_SHARE, TOLERANCE_MM = 0.01, 0.01
"""No side of a triangle is farther from the surface than this share of the thinnest wall, or this."""

TRIANGLES = 90_000
"""Triangles that an outside's area is cut into, before those on bends and creases are halved."""

COARSEST_SHARE = 0.9
"""The grid's step, as a share of the thinnest wall, at most: no cell may reach from one side of a wall to the other."""

SEARCHES = 38.0
"""Searches for nearest points that one square step of the outside takes in all."""

TIME_SHARE = 0.4
"""The share of the time given that a grid finer than the coarsest is planned for: the machine may have other work, and
numbers are to be juggled between the searches."""

SURE_SHARE = 0.5
"""The searches have been seen to take this share of what the pilot makes of them: with less time it is not tried."""

PILOT, PILOTS = 8000, 2
"""Points that the time of a search is taken from, and how often: the quickest counts, for caches have to be filled.

They lie on the wanted surface and near each other, as those of the grid do: elsewhere a search takes several times as
long, and a wall would be refused for want of time that there is."""


def inner_mesh(mold: Mold, asked: AskedThickness, wall: Outside, seconds: float) -> Candidate:
    """Return the cavity of a mold as a mesh, whatever its shape; the less time there is, the coarser.

    Raises
    ------
    InputError
        If the wall asked leaves no cavity that reaches the mouth.
    OutOfTimeError
        If the time is certainly too short for a grid that tells the two sides of the wall apart.
    """
    begin = time.monotonic()
    deviation = max(TOLERANCE_SHARE * asked.minimum_mm, TOLERANCE_MM)
    inside, notes = cavity_mesh(mold, asked, wall, _step(wall, asked, seconds), deviation)
    solid, told, off = _solid(mold, wall, inside, seconds - (time.monotonic() - begin))
    cavity = lifted(inside, wall.finish_height_mm, PAST_MOUTH_MM)
    return Candidate(solid, cavity, inside, (*notes, told), facets_off_mm=off)


def _solid(mold: Mold, wall: Outside, inside: Mesh, seconds: float) -> tuple[Part.Shape | None, str, float]:
    """Return the solid with a faceted inside if it can be made, how good it is or why there is none, and its error.

    The error (mm) is how far the facets are off the smooth inside, 0 without a solid.
    """
    only_mesh = "so it can be saved as STL only"
    if mold.upright is None:
        return None, f"the mold is a mesh, {only_mesh}", 0.0
    points, triangles = fewer_facets(inside, wall.finish_height_mm)
    arguments = {
        "finish_face": mold.anatomy.finish_face,
        "points": points.tolist(),
        "triangles": triangles.tolist(),
    }
    try:
        (solid,) = run_in_worker(faceted_solid, [mold.upright], arguments, seconds)
    except GlassWorkbenchError as error:
        return None, f"no solid could be made of the mesh ({error}), {only_mesh}", 0.0
    middles = points[triangles].mean(axis=1)
    off = float(np.abs(wall.clearance(middles).clearance_mm).max())
    return solid, f"the solid's inside has {len(triangles)} flat facets, up to {off:.2g} mm off the smooth one", off


def cavity_mesh(
    mold: Mold, asked: AskedThickness, wall: Outside, step_mm: float, deviation_mm: float
) -> tuple[Mesh, tuple[str, ...]]:
    """Return the cavity, closed level at the finish plane, and notes on what stays solid.

    Parameters
    ----------
    mold : Mold
    asked : AskedThickness
    wall : Outside
    step_mm : float
        Of the grid, about the length of the triangles' sides.
    deviation_mm : float
        Sides are halved where their middles are farther from the surface.

    Raises
    ------
    InputError
        As `inner_mesh`.
    """
    anatomy, notes = mold.anatomy, []
    floor = -np.inf
    if anatomy.stem_top_mm > 0.0:
        foot = np.array([[0.0, 0.0, anatomy.stem_top_mm]])
        floor = anatomy.stem_top_mm + float(asked.at(foot, np.zeros(1, dtype=int))[0])
        notes.append(f"below {floor:.1f} mm, above its stem, the glass stays solid")
    room = Room(wall, wall.finish_height_mm, floor)
    low, high = _box(wall, asked, step_mm)
    if np.any(high < low + 3.0 * step_mm):
        raise no_room(wall, asked.maximum_mm)
    grid = sampled(room.value, low, high, step_mm)
    positive = without_ambiguity(without_border(grid.bound_mm > 0.0), grid.bound_mm)
    cavity, pockets = cavity_nodes(grid, positive, room.ceiling_mm, anatomy.finish_outer_radius_mm)
    if not cavity.any():
        raise no_room(wall, asked.maximum_mm)
    if pockets == 1:
        notes.append("the walls part it from a hollow that stays solid")
    elif pockets:
        notes.append(f"the walls part it from {pockets} hollows that stay solid")
    return level_mesh(room, grid, cavity, deviation_mm), tuple(notes)


def _box(wall: Outside, asked: AskedThickness, step_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of a box about the cavity, at least a step wider, from which the grid's nodes are counted.

    The finish plane lies in the middle between two layers of nodes, and so that flat sides do not fall on nodes, they
    lie by a quarter of a step or more away from them.
    """
    corners = wall.corners_mm[~wall.collar]
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    middle, half = 0.5 * (low + high), 0.5 * (high - low) - asked.minimum_mm
    steps = half / step_mm
    aside = np.where(np.abs(steps % 1.0 - 0.5) > 0.25, 0.5, 0.0)
    low = middle - (np.ceil(steps) + 1.0 + aside) * step_mm
    high = middle + (steps + 2.0) * step_mm
    layers = np.ceil((wall.finish_height_mm - low[2]) / step_mm) + 0.5
    low[2], high[2] = wall.finish_height_mm - layers * step_mm, wall.finish_height_mm + 1.5 * step_mm
    return low, high


def _step(wall: Outside, asked: AskedThickness, seconds: float) -> float:
    glass = np.flatnonzero(~wall.collar)
    area = float(np.linalg.norm(facets(wall.corners_mm[glass]), axis=1).sum())
    wanted = min(np.sqrt(3.0 * area / TRIANGLES), COARSEST_SHARE * asked.minimum_mm)
    chosen = glass[np.linspace(0, len(glass) - 1, PILOT).astype(int)]
    depth = wall.thickness_mm[chosen].mean(axis=1)[:, None]
    inward = wall.corners_mm[chosen].mean(axis=1) - depth * wall.normals[chosen].mean(axis=1)
    # The first search also builds the tree.
    wall.clearance(inward[:1])
    searching = SEARCHES * area * min(_pilot(wall, inward) for _ in range(PILOTS))
    coarsest = COARSEST_SHARE * asked.minimum_mm
    if SURE_SHARE * searching / coarsest**2 > seconds:
        raise OutOfTimeError(
            f"a wall of {asked.minimum_mm:.3g} mm needs a grid that takes about "
            f"{searching / coarsest**2 / TIME_SHARE:.0f} s; give it more time"
        )
    affordable = np.sqrt(searching / (TIME_SHARE * seconds))
    return min(max(wanted, affordable), coarsest)


def _pilot(wall: Outside, points: np.ndarray) -> float:
    """Return how long a search takes, in seconds."""
    begin = time.monotonic()
    wall.clearance(points)
    return (time.monotonic() - begin) / len(points)
