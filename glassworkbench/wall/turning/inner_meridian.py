"""The meridian of the inside of a container of revolution: the outside's, offset inward, in numbers.

The inside is the envelope of circles whose centres run along the outside and whose radius is the thickness asked
there: no point of the inside is nearer to any outside point than that point's thickness.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.wall.asking.bore import Bore
from glassworkbench.wall.asking.thickness import ThicknessOverHeight
from glassworkbench.wall.turning.along_meridian import AlongMeridian
from glassworkbench.wall.turning.bezier import crossings, evaluate, fit_cubic, line, polyline
from glassworkbench.wall.turning.envelope import PAST_MOUTH_MM, SAMPLES, Envelope, envelope_of, turn_between
from glassworkbench.wall.turning.profile import WallMeridian, below_bore
from glassworkbench.wall.turning.unfolding import clearance, unfolded, up_to

FIT_TOLERANCE_MM = 1e-3
FIT_TOLERANCE_SHARE = 1e-4
"""The fitted cavity keeps this close to the exact envelope (mm, and as a share of the thinnest wall)."""

STEEPEST_BLEND = 1.0
"""Below a bore the inside may come inward, or go outward, by this much per mm of height: 45 degrees."""

SMOOTH = 1e-4
"""Neighbouring segments whose tangents differ by less (rad) join smoothly."""


@dataclass(frozen=True, eq=False)
class CavityMeridian:
    """The inside as rational cubic Bezier chains, from the axis at the bottom to the axis at the top.

    Parameters
    ----------
    segments : array (n, 4, 3)
        Ends level at the finish plane: what the solid's cavity is made of.
    past_mouth : array (m, 4, 3)
        The same below the finish, but reaching past the mouth: what the tracer takes away from the outer body.
    smooth_runs : tuple of (int, int)
        Half-open ranges of `segments` within which the tangent is continuous; the last is the mouth plane.
    fit_error_mm : float
        Largest distance of the chain from the exact envelope.
    """

    segments: np.ndarray
    past_mouth: np.ndarray
    smooth_runs: tuple[tuple[int, int], ...]
    fit_error_mm: float


def offset_meridian(wall: WallMeridian, over_height: ThicknessOverHeight, bore: Bore | None = None) -> CavityMeridian:
    """Offset the outside inward by a thickness that may vary over height, and in the finish leave a prescribed bore.

    Raises
    ------
    InputError
        If the wall fills the container somewhere, or nothing smooth leads to the bore; the message says where, and how
        much fits.
    GlassWorkbenchError
        If the result does not pass its own check (it crosses itself, or has a gap).

    Notes
    -----
    Where the offset folds over itself, min over s of |p - s| - t(s) is negative, and that part is taken away.
    """
    thickness = AlongMeridian(over_height, bore)
    if bore is not None:
        wall = below_bore(wall, bore)
        _check_blend(wall, thickness)
    _check_room(wall, thickness)
    tolerance = min(FIT_TOLERANCE_MM, FIT_TOLERANCE_SHARE * over_height.minimum_mm)
    envelope = envelope_of(wall, thickness)
    stretches = unfolded(envelope)
    past_lip = min(0.5 * over_height.minimum_mm, 0.2 * PAST_MOUTH_MM)
    below = up_to(envelope, stretches, wall.finish_height_mm)
    above = up_to(envelope, stretches, wall.finish_height_mm + past_lip)

    chain, runs, error = _fitted(envelope, below, tolerance)
    chain[0][0, 0] = 0.0
    mouth = chain[-1, 3, :2].copy()
    segments = np.concatenate([chain, line(mouth, np.array([0.0, mouth[1]]))[None]])
    runs = (*runs, (len(chain), len(chain) + 1))

    rest, _, _ = _fitted(envelope, _beyond(above, below[-1][1]), tolerance)
    rest[0, :2, :2] += mouth - rest[0, 0, :2]
    end = rest[-1, 3, :2].copy()
    top = wall.finish_height_mm + PAST_MOUTH_MM
    lid = [line(end, np.array([end[0], top])), line(np.array([end[0], top]), np.array([0.0, top]))]
    cavity = CavityMeridian(segments, np.concatenate([chain, rest, lid]), runs, error)
    _check_simple(cavity)
    return cavity


def _check_room(wall: WallMeridian, thickness: AlongMeridian) -> None:
    """Refuse a wall that fills the container: the axis must be free from the floor to the mouth."""
    u = np.linspace(0.0, 1.0, max(17, SAMPLES // len(wall.segments)))
    parts = [evaluate(segment, u)[0] for segment in wall.segments]
    asked = [thickness.at(part, underside) for part, underside in zip(parts, wall.underside, strict=True)]
    feet, asked = np.concatenate(parts), np.concatenate(asked)
    height = np.linspace(wall.segments[0, 0, 1], wall.lip[1], 1001)
    axis = np.column_stack([np.zeros_like(height), height])
    free = clearance(axis, feet, asked)
    floor = np.flatnonzero(free > 0.0)
    blocked = np.flatnonzero(free[floor[0] :] <= 0.0) + floor[0] if len(floor) else np.arange(len(height))
    if len(blocked) == 0:
        return
    # Below the widest place there is a floor, which blocks nothing: where the wall is too thick everywhere, too.
    above = blocked[blocked >= np.argmax(free)]
    worst = min(above if len(above) else blocked, key=free.__getitem__)
    distances = np.linalg.norm(feet - axis[worst], axis=1)
    tightest = int(np.argmin(distances - asked))
    raise InputError(
        f"wall: {asked[tightest]:g} mm fills the container at height {height[worst]:.1f} mm, "
        f"where less than {distances[tightest]:.2f} mm fits; ask for a thinner wall there"
    )


def _beyond(stretches: list[tuple[float, float]], place: float) -> list[tuple[float, float]]:
    """Return what of the stretches lies after a place."""
    return [(max(start, place), end) for start, end in stretches if end > place]


def _check_blend(wall: WallMeridian, thickness: AlongMeridian) -> None:
    """Refuse a bore that is too far from what the wall leaves below it."""
    u = np.linspace(0.0, 1.0, 65)
    points = np.concatenate([evaluate(segment, u)[0] for segment in wall.segments])
    slope = np.abs(thickness.blend_slope(points))
    worst = int(np.argmax(slope))
    if slope[worst] > STEEPEST_BLEND:
        inside = points[worst, 0] - float(thickness.over_height.at(points[worst, 1]))
        raise InputError(
            f"wall bore: {2.0 * thickness.bore.radius_mm:g} mm is too far from the {2.0 * inside:.2f} mm that the "
            f"wall leaves at height {points[worst, 1]:.1f} mm, where the inside must lead to it smoothly; "
            "ask for a bore nearer to that, or another wall there"
        )


def _fitted(
    envelope: Envelope, stretches: list[tuple[float, float]], tolerance_mm: float
) -> tuple[np.ndarray, tuple[tuple[int, int], ...], float]:
    """Return the chain of cubics through the stretches, its smooth runs, and the largest fit error (mm)."""
    chain: list[np.ndarray] = []
    corners = [0]
    worst = 0.0
    tangent = None
    for start, end in stretches:
        bounds = [start, *range(int(start) + 1, int(np.ceil(end))), end]
        for low, high in itertools.pairwise(bounds):
            high = min(high, np.nextafter(np.floor(low) + 1.0, 0.0))
            ends = envelope.at(np.array([low, high]))
            if np.linalg.norm(ends.points[1] - ends.points[0]) <= 0.1 * tolerance_mm:
                continue
            if tangent is not None and abs(turn_between(tangent, ends.tangents[0])) > SMOOTH:
                corners.append(len(chain))
            pieces, error = _fit_between(envelope, low, high, tolerance_mm)
            chain += pieces
            worst = max(worst, error)
            tangent = ends.tangents[1]
    for before, after in itertools.pairwise(chain):
        after[:2, :2] += before[3, :2] - after[0, :2]
    runs = tuple(zip(corners, [*corners[1:], len(chain)], strict=True))
    return np.array(chain), runs, worst


def _fit_between(envelope: Envelope, low: float, high: float, tolerance_mm: float) -> tuple[list[np.ndarray], float]:
    """Fit cubics between two places, halving until each is within the tolerance; return them and the error (mm)."""
    trace = envelope.at(np.linspace(low, high, 17))
    segment, error = fit_cubic(trace.points, trace.tangents[0], trace.tangents[-1])
    if error <= tolerance_mm or high - low < 1e-4:
        return [segment], error
    middle = 0.5 * (low + high)
    first, first_error = _fit_between(envelope, low, middle, tolerance_mm)
    second, second_error = _fit_between(envelope, middle, high, tolerance_mm)
    return first + second, max(first_error, second_error)


def _check_simple(cavity: CavityMeridian) -> None:
    for chain in (cavity.segments, cavity.past_mouth):
        places = crossings(polyline(chain, 12))
        if len(places):
            raise GlassWorkbenchError(f"revolved: the cavity's meridian crosses itself at height {places[0][1]:.2f} mm")
