"""Walls that vary by zones: cavities of one thickness each, cut level and put on one another, and a bore in the finish.

What varies smoothly over the height becomes a stair of zones, each off by no more than a stated deviation.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.wall.methods.revolved import PAST_MOUTH_MM
from glassworkbench.wall.offsetting.offset_check import check_solid, facets, facets_volume
from glassworkbench.wall.offsetting.offset_solid import hollowed
from glassworkbench.wall.offsetting.offset_ways import above, below

Zone = tuple[float, float, float]
"""From a height to a height, the thickness there; all in mm."""

LOST_SHARE = 1e-3
"""Share of their volume that pieces may lose when they are joined, by the coarseness of their meshes."""


def zones_over_height(heights_mm: np.ndarray, thicknesses_mm: np.ndarray, deviation_mm: float) -> list[Zone]:
    """Return the zones that stand for a thickness that varies over the height.

    Parameters
    ----------
    heights_mm, thicknesses_mm : array (n,)
        The thickness asked, at ascending heights close enough to each other to interpolate linearly.
    deviation_mm : float
        No zone is farther than this from the thickness asked within it.
    """
    bounds = [0]
    for k in range(1, len(heights_mm)):
        if np.ptp(thicknesses_mm[bounds[-1] : k + 1]) > 2.0 * deviation_mm and k - 1 > bounds[-1]:
            bounds.append(k - 1)
    bounds.append(len(heights_mm) - 1)
    zones = []
    for first, last in itertools.pairwise(bounds):
        within = thicknesses_mm[first : last + 1]
        zones.append((float(heights_mm[first]), float(heights_mm[last]), float(0.5 * (within.min() + within.max()))))
    return zones


def check_zones(zones: Sequence[Zone], finish_height_mm: float) -> None:
    """Raise unless zones stand on one another, up to the finish.

    Raises
    ------
    InputError
        If there are none, or they leave a gap, overlap, end below the finish, or have an impossible thickness.
    """
    if not zones:
        raise InputError("wall: it has no zone; give at least one")
    for low, high, thickness in zones:
        if not (low < high and 0.0 < thickness < np.inf):
            raise InputError(f"wall zone {low:g} to {high:g} mm, {thickness:g} mm thick: it is none; correct it")
    for (_, high, _), (low, _, _) in itertools.pairwise(zones):
        if abs(high - low) > 1e-6:
            raise InputError(f"wall: a zone ends at {high:g} mm and the next begins at {low:g} mm; let them meet")
    if abs(zones[-1][1] - finish_height_mm) > 1e-3:
        raise InputError(f"wall: the zones end at {zones[-1][1]:g} mm; let them end at {finish_height_mm:g} mm")


def join_zones(
    outer: Part.Shape,
    *cavities: Part.Shape,
    finish_face: int,
    zones: Sequence[Zone],
    thicknesses_mm: Sequence[float],
    bore_mm: float | None = None,
) -> list[Part.Shape]:
    """Return the hollow solid, its cavity up to the finish plane, and the cavity reaching past the mouth.

    Parameters
    ----------
    outer : Part.Shape
        Upright solid.
    *cavities : Part.Shape
        Cavities of uniform walls that reach past the mouth.
    finish_face : int
        1-based number of the planar face at the mouth.
    zones : sequence of (low_mm, high_mm, thickness_mm)
        Bottom to top, up to the finish. Below the first one all is glass: so the floor is raised, or a stem kept full.
        Where two zones meet, the cavity has a ledge as wide as their thicknesses differ.
    thicknesses_mm : sequence of float
        The wall that each of the cavities leaves.
    bore_mm : float, optional
        Diameter of a straight bore about the axis that is the cavity in the topmost zone, whatever its thickness.

    Raises
    ------
    GlassWorkbenchError
        If the pieces do not join to one valid, closed cavity.
    """
    height = outer.Faces[finish_face - 1].CenterOfMass.z
    past_mouth_height = height + PAST_MOUTH_MM
    pieces = []
    for number, (low, high, thickness) in enumerate(zones, start=1):
        is_top = number == len(zones)
        if is_top and bore_mm is not None:
            pieces.append(Part.makeCylinder(0.5 * bore_mm, past_mouth_height - low, FreeCAD.Vector(0, 0, low)))
            continue
        piece = cavities[list(thicknesses_mm).index(thickness)]
        pieces += _piece(piece, low, past_mouth_height if is_top else high)
    past_mouth = _joined(pieces)
    cavity = below(past_mouth, height)
    check_solid(cavity)
    return [hollowed(outer, cavity, past_mouth, finish_face), cavity, past_mouth]


def _piece(cavity: Part.Shape, low_mm: float, high_mm: float) -> list[Part.Shape]:
    """Return what of a cavity lies between two heights: one solid, or none where the floor is thicker."""
    corners = facets(cavity, 0.1)
    bottom, top = corners[:, :, 2].min(), corners[:, :, 2].max()
    if bottom >= high_mm:
        return []
    if bottom < low_mm:
        cavity = above(cavity, low_mm)
    return [below(cavity, high_mm)] if top > high_mm else [cavity]


def _joined(pieces: Sequence[Part.Shape]) -> Part.Shape:
    whole = pieces[0]
    for piece in pieces[1:]:
        whole = whole.fuse(piece)
    if len(whole.Solids) != 1:
        raise GlassWorkbenchError(f"the zones join to {len(whole.Solids)} cavities, where one must be")
    volume, parts = (sum(facets_volume(facets(shape, 0.05)) for shape in shapes) for shapes in ([whole], pieces))
    if abs(volume - parts) > LOST_SHARE * parts:
        raise GlassWorkbenchError(f"the joined zones hold {1e-3 * volume:.1f} ml, their parts {1e-3 * parts:.1f} ml")
    return whole.Solids[0]
