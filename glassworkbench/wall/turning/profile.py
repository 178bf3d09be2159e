"""The part of the outer meridian that has a wall behind it: not the mouth, and not a stem."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.wall.asking.bore import Bore
from glassworkbench.wall.asking.limits import LAND_SHARE
from glassworkbench.wall.asking.over_height import ThicknessOverHeight
from glassworkbench.wall.turning.bezier import cut, evaluate, line, polyline, unit

if TYPE_CHECKING:
    from glassworkbench.mold import Anatomy

LIP_ZONE_MM = 5.0
"""How far below the finish plane a rounded lip may begin."""

UPRIGHT = 0.02
"""A lip that leans inward by less than this (rad) is upright."""


FLOOR_ROUNDING = 4.0
"""The floor of a bowl starts from an arc of at least this many walls' radius, so that it has no dimple."""


@dataclass(frozen=True, eq=False)
class WallMeridian:
    """Where the wall starts outside: a chain from the axis at the bottom to the lip.

    Parameters
    ----------
    segments : array (n, 4, 3)
        Rational cubic Bezier segments (r mm, z mm, weight), the body to the left of travel.
    underside : bool array (n,)
        True for segments of the base inside the ring the container stands on.
    outside : bool array (n,)
        True for segments that lie on the container's outer surface; the others are the floor above a stem, and the
        step that keeps the sealing surface wide enough.
    lip_direction : array (2,)
        Unit vector: the straight line on which the wall goes on above the chain's end.
    finish_height_mm : float
        The sealing surface; the lip may end below it, where its rounding begins.
    """

    segments: np.ndarray
    underside: np.ndarray
    outside: np.ndarray
    lip_direction: np.ndarray
    finish_height_mm: float

    @property
    def lip(self) -> np.ndarray:
        """The upper end of the chain (2,)."""
        return self.segments[-1, 3, :2]


def wall_meridian(outer: np.ndarray, anatomy: Anatomy, thickness: ThicknessOverHeight) -> WallMeridian:
    """Return the part of an outer meridian that has a wall behind it.

    Parameters
    ----------
    outer : array (n, 4, 3)
        From the axis at the base up the outside to the axis at the finish plane.
    anatomy : Anatomy
        Its stem top, below which the body stays solid, and its finish height.
    thickness : ThicknessOverHeight
        Decides how round the floor above a stem is, and how wide the sealing surface stays.

    Raises
    ------
    InputError
        If the meridian does not reach above the stem.
    """
    segments = np.array(outer, dtype=np.float64)
    stem = anatomy.stem_top_mm > 0.0
    if stem:
        segments = _above_stem(segments, anatomy.stem_top_mm, float(thickness.at(anatomy.stem_top_mm)))
    underside_count = 0 if stem else _lowest_joint(segments)
    segments, direction = _below_lip(segments, anatomy.finish_height_mm)
    step = _step_to_land(segments[-1, 3, :2], direction, outer, anatomy, thickness)
    if step is not None:
        segments, direction = np.concatenate([segments, step]), np.array([0.0, 1.0])
    number = np.arange(len(segments))
    outside = (number >= int(stem)) & (number < len(segments) - (step is not None))
    return WallMeridian(segments, number < underside_count, outside, direction, float(anatomy.finish_height_mm))


def mouth_radius_mm(outer: np.ndarray, finish_height_mm: float) -> float:
    """Return how far the finish plane reaches from the axis in an outer meridian (n, 4, 3)."""
    outline = polyline(outer, 64)
    return float(outline[outline[:, 1] >= finish_height_mm - 1e-6 * finish_height_mm, 0].max())


def below_bore(wall: WallMeridian, bore: Bore) -> WallMeridian:
    """Return what of a wall lies below a bore's cylinder; above, the inside goes straight up."""
    u = np.linspace(0.0, 1.0, 65)
    for number in reversed(range(len(wall.segments))):
        below = np.flatnonzero(evaluate(wall.segments[number], u)[0][:, 1] < bore.full_from_mm)
        if len(below):
            break
    low = u[below[-1]]
    high = u[min(below[-1] + 1, len(u) - 1)]
    for _ in range(60):
        middle = 0.5 * (low + high)
        is_below = evaluate(wall.segments[number], np.array([middle]))[0][0, 1] < bore.full_from_mm
        low, high = (middle, high) if is_below else (low, middle)
    segments = np.array([*wall.segments[:number], cut(wall.segments[number], 0.0, high)])
    return replace(
        wall,
        segments=segments,
        underside=wall.underside[: number + 1],
        outside=wall.outside[: number + 1],
        lip_direction=np.array([0.0, 1.0]),
    )


def _above_stem(segments: np.ndarray, stem_top_mm: float, wall_mm: float) -> np.ndarray:
    u = np.linspace(0.0, 1.0, 65)
    first = max((k for k in range(len(segments)) if segments[k, 0, 1] <= stem_top_mm), default=len(segments))
    for number in range(first, len(segments)):
        points, slopes = evaluate(segments[number], np.clip(u, 1e-9, 1.0))
        tangents = unit(slopes)
        with np.errstate(divide="ignore", invalid="ignore"):
            rounding = points[:, 0] / tangents[:, 1]
        fits = (points[:, 1] >= stem_top_mm) & (tangents[:, 0] > 0.0) & (tangents[:, 1] > 0.0)
        fits = np.flatnonzero(fits & (rounding >= FLOOR_ROUNDING * wall_mm))
        if len(fits) and fits[0] < len(u) - 1:
            rest = np.array([cut(segments[number], u[fits[0]], 1.0), *segments[number + 1 :]])
            return np.array([_round_floor(rest[0]), *rest])
    raise InputError(
        f"wall: {wall_mm:g} mm leave no room for a floor above the stem's top at {stem_top_mm:.1f} mm; "
        "ask for a thinner wall"
    )


def _round_floor(first: np.ndarray) -> np.ndarray:
    """Return the arc (4, 3) from the axis, where it is level, that runs tangentially into a segment."""
    point = first[0, :2]
    tangent = unit(evaluate(first, np.array([1e-9]))[1])[0]
    angle = np.arctan2(tangent[1], tangent[0])
    radius = point[0] / np.sin(angle)
    centre = np.array([0.0, point[1] + point[0] / np.tan(angle)])
    # The handles of a cubic that stays within 3e-4 of a quarter circle; the floor of a bowl is a free choice anyway.
    handle = 4.0 / 3.0 * np.tan(angle / 4.0) * radius
    bottom = centre - np.array([0.0, radius])
    points = [bottom, bottom + np.array([handle, 0.0]), point - handle * tangent, point]
    return np.column_stack([points, np.ones(4)])


def _lowest_joint(segments: np.ndarray) -> int:
    """Return how many segments lie before the outermost of the lowest points."""
    lowest = polyline(segments, 32)[:, 1].min()
    slack = 1e-6 * np.abs(segments[:, :, :2]).max()
    ends = segments[:, 3, 1] <= lowest + slack
    return int(np.flatnonzero(ends)[-1]) + 1 if np.any(ends) else 0


def _below_lip(segments: np.ndarray, finish_height_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Cut the mouth plane off, and the rounding that leads into it; return the direction in which the bore goes on."""
    u = np.linspace(0.0, 1.0, 65)
    places, points, tangents = [], [], []
    for number, segment in enumerate(segments):
        p, slope = evaluate(segment, np.clip(u, 1e-9, 1.0 - 1e-9))
        places += [(number, parameter) for parameter in u]
        points.append(p)
        tangents.append(unit(slope))
    points, tangents = np.concatenate(points), np.concatenate(tangents)
    zone = min(LIP_ZONE_MM, 0.2 * finish_height_mm)
    candidates = np.flatnonzero(points[:, 1] >= finish_height_mm - zone)
    upright = candidates[(tangents[candidates, 0] > -UPRIGHT) & (tangents[candidates, 1] > 0.0)]
    if len(upright):
        end = upright[-1]
    else:
        steepness = tangents[candidates, 1]
        end = candidates[np.flatnonzero(steepness >= steepness.max() - UPRIGHT**2)[-1]]
    number, parameter = places[end]
    if parameter == 0.0:
        return segments[:number], tangents[end]
    return np.array([*segments[:number], cut(segments[number], 0.0, parameter)]), tangents[end]


def _step_to_land(
    lip: np.ndarray, direction: np.ndarray, outer: np.ndarray, anatomy: Anatomy, thickness: ThicknessOverHeight
) -> np.ndarray | None:
    """Return the level line (1, 4, 3) inward from the lip, above which the sealing surface is wide enough; or None."""
    height = anatomy.finish_height_mm
    widest = mouth_radius_mm(outer, height) + (1.0 - LAND_SHARE) * float(thickness.at(height))
    if lip[0] + (height - lip[1]) * direction[0] / direction[1] <= widest:
        return None
    return line(lip, np.array([min(widest, lip[0] - 1e-6), lip[1]]))[None]
