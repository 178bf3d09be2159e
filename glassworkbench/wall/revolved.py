"""The cavity of a container of revolution: its meridian offset inward, in numbers.

The inside is the envelope of circles whose centres run along the outside and whose radius is the thickness asked
there: no point of the inside is nearer to any outside point than that point's thickness.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.wall.bezier import crossings, cut, evaluate, fit_cubic, intersection, line, polyline, unit
from glassworkbench.wall.profile import WallMeridian
from glassworkbench.wall.thickness import ThicknessOverHeight

SAMPLES = 4000
"""Samples along the outside; they find the folds, whose ends are then computed exactly."""

FIT_TOLERANCE_MM = 1e-3
FIT_TOLERANCE_SHARE = 1e-4
"""The fitted cavity keeps this close to the exact envelope (mm, and as a share of the thinnest wall)."""

CLEARANCE_MM = 1e-6
"""A point of the envelope that is this much too near to the outside lies in a fold."""

SMOOTH = 1e-4
"""Neighbouring segments whose tangents differ by less (rad) join smoothly."""

CORNER = 1e-5
"""Pieces of the outside that turn inward by less (rad) count as one; CAD files are seldom smoother."""

PAST_MOUTH_MM = 5.0
"""How far the tracer's cavity reaches above the finish."""


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


def offset_meridian(wall: WallMeridian, thickness: ThicknessOverHeight) -> CavityMeridian:
    """Offset the outside inward by a thickness that may vary over height.

    Raises
    ------
    InputError
        If the wall fills the container somewhere; the message says where, and how much fits.
    GlassWorkbenchError
        If the result does not pass its own check (it crosses itself, or has a gap).

    Notes
    -----
    For a centre s(l), l the arc length, T its tangent, N the inward normal and t(l) the radius, the circles' envelope
    is p = s + t (-t' T + sqrt(1 - t'^2) N). At corners where the body is re-entrant the circle itself closes the gap;
    where the offset folds over itself, min over l of |p - s(l)| - t(l) is negative, and that part is taken away.
    """
    _check_room(wall, thickness)
    tolerance = min(FIT_TOLERANCE_MM, FIT_TOLERANCE_SHARE * thickness.minimum_mm)
    envelope = _envelope(wall, thickness)
    stretches = _unfolded(envelope)
    past_lip = min(0.5 * thickness.minimum_mm, 0.2 * PAST_MOUTH_MM)
    below = _up_to(envelope, stretches, wall.finish_height_mm)
    above = _up_to(envelope, stretches, wall.finish_height_mm + past_lip)

    chain, runs, error = _fitted(envelope, below, tolerance)
    mouth = chain[-1, 3, :2].copy()
    segments = np.concatenate([chain, line(mouth, np.array([0.0, mouth[1]]))[None]])
    runs = (*runs, (len(chain), len(chain) + 1))

    chain, _, _ = _fitted(envelope, above, tolerance)
    end = chain[-1, 3, :2].copy()
    top = wall.finish_height_mm + PAST_MOUTH_MM
    lid = [line(end, np.array([end[0], top])), line(np.array([end[0], top]), np.array([0.0, top]))]
    cavity = CavityMeridian(segments, np.concatenate([chain, lid]), runs, error)
    _check_simple(cavity)
    return cavity


@dataclass(frozen=True, eq=False)
class _Trace:
    """Points of the envelope (m, 2), the outside points they come from, the thickness there, and p - s as a unit."""

    points: np.ndarray
    feet: np.ndarray
    thickness: np.ndarray
    directions: np.ndarray

    @property
    def tangents(self) -> np.ndarray:
        return np.column_stack([self.directions[:, 1], -self.directions[:, 0]])


@dataclass(frozen=True, eq=False)
class _Offset:
    """The envelope along one segment of the outside; thickness and its slope are functions of the height."""

    segment: np.ndarray
    thickness: ThicknessOverHeight
    underside: bool

    def trace(self, u: np.ndarray) -> _Trace:
        feet = evaluate(self.segment, u)[0]
        # A segment whose first handle has no length still has a tangent next to its end.
        tangent = unit(evaluate(self.segment, np.clip(u, 1e-9, 1.0 - 1e-9))[1])
        radius = self.thickness.at(feet[:, 1], self.underside)
        growth = self.thickness.slope(feet[:, 1], self.underside) * tangent[:, 1]
        return _on_circles(feet, tangent, radius, growth)


@dataclass(frozen=True, eq=False)
class _Extension:
    """The envelope along the straight line on which the wall goes on above the lip."""

    start: np.ndarray
    tangent: np.ndarray
    length_mm: float
    thickness_mm: float
    slope: float

    def trace(self, u: np.ndarray) -> _Trace:
        along = np.asarray(u) * self.length_mm
        tangent = np.broadcast_to(self.tangent, (len(along), 2))
        growth = np.full(len(along), self.slope * self.tangent[1])
        radius = np.maximum(self.thickness_mm + growth * along, 0.0)
        return _on_circles(self.start + along[:, None] * tangent, tangent, radius, growth)


@dataclass(frozen=True, eq=False)
class _Fan:
    """The circle about a re-entrant corner, swept clockwise from one angle (rad) to another."""

    centre: np.ndarray
    radius: float
    first: float
    last: float

    def trace(self, u: np.ndarray) -> _Trace:
        angle = self.first + np.asarray(u) * (self.last - self.first)
        directions = np.column_stack([np.cos(angle), np.sin(angle)])
        feet = np.broadcast_to(self.centre, directions.shape)
        return _Trace(feet + self.radius * directions, feet, np.full(len(angle), self.radius), directions)


def _on_circles(feet: np.ndarray, tangent: np.ndarray, radius: np.ndarray, growth: np.ndarray) -> _Trace:
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    # Where the thickness grows faster than the arc length, circles lie inside their neighbours: no envelope (NaN).
    with np.errstate(invalid="ignore"):
        across = np.sqrt(1.0 - growth**2)
    directions = -growth[:, None] * tangent + across[:, None] * normal
    return _Trace(feet + radius[:, None] * directions, feet, radius, directions)


class _Envelope:
    """The pieces in order; a place on them is one number, piece index + parameter."""

    def __init__(self, pieces: list, lengths_mm: list[float]) -> None:
        self.pieces = pieces
        spacing = sum(lengths_mm) / SAMPLES
        grids = [
            number + np.linspace(0.0, 1.0, max(17, int(length / spacing) + 2))
            for number, length in enumerate(lengths_mm)
        ]
        # The same place is the end of one piece and the start of the next; a tiny step keeps the two apart.
        self.places = np.concatenate([np.append(grid[:-1], np.nextafter(grid[-1], 0.0)) for grid in grids])
        self.trace = self.at(self.places)

    def at(self, places: np.ndarray) -> _Trace:
        number = np.clip(places.astype(int), 0, len(self.pieces) - 1)
        parts = [
            np.zeros((len(places), 2)),
            np.zeros((len(places), 2)),
            np.zeros(len(places)),
            np.zeros((len(places), 2)),
        ]
        for k in np.unique(number):
            here = number == k
            trace = self.pieces[k].trace(places[here] - k)
            for part, value in zip(parts, (trace.points, trace.feet, trace.thickness, trace.directions), strict=True):
                part[here] = value
        return _Trace(*parts)


def _envelope(wall: WallMeridian, thickness: ThicknessOverHeight) -> _Envelope:
    pieces, lengths = [], []
    direction = np.array([0.0, 1.0])
    for piece, length in _outside(wall, thickness):
        trace = piece.trace(np.array([0.0, 1.0]))
        turn = _turn(direction, trace.directions[0])
        if turn < -1e-6:
            first = np.arctan2(direction[1], direction[0])
            pieces.append(_Fan(trace.feet[0], float(trace.thickness[0]), first, first + turn))
            lengths.append(-turn * float(trace.thickness[0]))
        pieces.append(piece)
        lengths.append(length)
        direction = trace.directions[1]
    return _Envelope(pieces, lengths)


def _turn(before: np.ndarray, after: np.ndarray) -> float:
    """Return the angle (rad) from one direction to the next, counter-clockwise positive; 0 where there is none."""
    angle = np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after)
    return float(np.nan_to_num(angle))


def _outside(wall: WallMeridian, thickness: ThicknessOverHeight) -> list[tuple]:
    """Return the offsets of all segments, cut at the table's heights, and of the line above the lip; with lengths."""
    pieces = []
    for segment, underside in zip(wall.segments, wall.underside, strict=True):
        for part in _cut_at_heights(segment, thickness):
            points = evaluate(part, np.linspace(0.0, 1.0, 17))[0]
            length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
            pieces.append((_Offset(part, thickness, bool(underside)), length))
    point, tangent = wall.lip, wall.lip_direction
    at_lip = float(thickness.at(point[1]))
    slope = float(thickness.slope(point[1] - 1e-9))
    rise = wall.finish_height_mm - point[1] + 2.0 * at_lip + PAST_MOUTH_MM
    length = rise / max(float(tangent[1]), 0.2)
    pieces.append((_Extension(point, tangent, length, at_lip, slope), length))
    return pieces


def _cut_at_heights(segment: np.ndarray, thickness: ThicknessOverHeight) -> list[np.ndarray]:
    """Cut a segment where the thickness has a knot: within each part the envelope is as smooth as the segment."""
    u = np.linspace(0.0, 1.0, 65)
    z = evaluate(segment, u)[0][:, 1]
    knots = thickness.heights_mm
    knots = knots[(knots > z.min()) & (knots < z.max())] if len(knots) > 1 else knots[:0]
    places = {0.0, 1.0}
    for knot in knots:
        for k in np.flatnonzero((z[:-1] - knot) * (z[1:] - knot) < 0.0):
            low, high = u[k], u[k + 1]
            for _ in range(50):
                middle = 0.5 * (low + high)
                rising = evaluate(segment, np.array([middle]))[0][0, 1] > knot
                low, high = (low, middle) if rising == (z[k + 1] > knot) else (middle, high)
            places.add(0.5 * (low + high))
    ordered = sorted(places)
    return [cut(segment, low, high) for low, high in itertools.pairwise(ordered) if high - low > 1e-9]


def clearance(points: np.ndarray, feet: np.ndarray, thickness: np.ndarray) -> np.ndarray:
    """Return min over feet of |p - s| - t for each point (n, 2): how much too far inside (mm), negative if too near."""
    nearest = np.empty(len(points))
    for start in range(0, len(points), 256):
        group = slice(start, start + 256)
        gap = np.linalg.norm(points[group, None] - feet[None], axis=2) - thickness
        nearest[group] = gap.min(axis=1)
    return nearest


def _check_room(wall: WallMeridian, thickness: ThicknessOverHeight) -> None:
    """Refuse a wall that fills the container: the axis must be free from the floor to the mouth."""
    u = np.linspace(0.0, 1.0, max(17, SAMPLES // len(wall.segments)))
    feet = np.concatenate([evaluate(segment, u)[0] for segment in wall.segments])
    asked = np.concatenate(
        [
            thickness.at(evaluate(segment, u)[0][:, 1], underside)
            for segment, underside in zip(wall.segments, wall.underside, strict=True)
        ]
    )
    height = np.linspace(wall.segments[0, 0, 1], wall.lip[1], 1001)
    axis = np.column_stack([np.zeros_like(height), height])
    free = clearance(axis, feet, asked)
    floor = np.flatnonzero(free > 0.0)
    blocked = np.flatnonzero(free[floor[0] :] <= 0.0) + floor[0] if len(floor) else np.arange(len(height))
    if len(blocked) == 0:
        return
    worst = blocked[np.argmin(free[blocked])] if len(floor) else int(np.argmax(free))
    distances = np.linalg.norm(feet - axis[worst], axis=1)
    tightest = int(np.argmin(distances - asked))
    raise InputError(
        f"wall: {asked[tightest]:g} mm fills the container at height {height[worst]:.1f} mm, "
        f"where less than {distances[tightest]:.2f} mm fits; ask for a thinner wall there"
    )


def _unfolded(envelope: _Envelope) -> list[tuple[float, float]]:
    """Return the stretches (first place, last place) of the envelope that bound the cavity, in order, joined."""
    trace, places = envelope.trace, envelope.places
    kept = np.isfinite(trace.points[:, 0]) & (trace.points[:, 0] >= -1e-9)
    kept[kept] = clearance(trace.points[kept], trace.feet, trace.thickness) >= -CLEARANCE_MM
    for end in _convex_corners(envelope):
        # The fold behind a blunt corner can be smaller than the samples' spacing, but it is there.
        kept[end : end + 2] = False
    edges = np.flatnonzero(np.diff(np.concatenate([[False], kept, [False]]).astype(int)))
    runs = [(first, last - 1) for first, last in edges.reshape(-1, 2)]
    runs = [run for run in runs if run[1] > run[0]]
    if not runs:
        raise GlassWorkbenchError("revolved: no part of the offset meridian bounds a cavity")
    first = min(range(len(runs)), key=lambda k: trace.points[runs[k][0], 0])
    stretches = [(_axis_place(envelope, runs[first][0]), places[runs[first][1]])]
    last = runs[first][1]
    for start, end in runs[first + 1 :]:
        joint = _joint(envelope, last, start)
        # A run that does not touch the chain bounds a pocket of its own, which stays solid.
        if joint is not None:
            stretches[-1] = (stretches[-1][0], joint[0])
            stretches.append((joint[1], places[end]))
            last = end
    return stretches


def _convex_corners(envelope: _Envelope) -> np.ndarray:
    """Return the samples that end a piece where the next starts turned toward the inside."""
    directions = envelope.trace.directions
    before, after = directions[:-1], directions[1:]
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.flatnonzero((np.diff(np.floor(envelope.places)) > 0) & (turn > CORNER))


def _axis_place(envelope: _Envelope, first: int) -> float:
    """Return the place where the run that starts at a sample meets the axis."""
    r = envelope.trace.points[:, 0]
    if first == 0 or not r[first - 1] < 0.0:
        return float(envelope.places[first])
    low, high = envelope.places[first - 1], envelope.places[first]
    for _ in range(60):
        middle = 0.5 * (low + high)
        if envelope.at(np.array([middle])).points[0, 0] < 0.0:
            low = middle
        else:
            high = middle
    return float(high)


def _joint(envelope: _Envelope, last: int, first: int) -> tuple[float, float] | None:
    """Return the places where the branch that ends at sample `last` meets the one that starts at `first`."""
    places = envelope.places
    # Each branch is followed into its fold, but not past the end of its piece, where the next may start elsewhere.
    a_end = np.nextafter(np.floor(places[last]) + 1.0, 0.0)
    a = places[max(last - 2, 0)], min(places[min(last + 3, len(places) - 1)], a_end)
    b = max(places[max(first - 3, 0)], np.floor(places[first])), places[min(first + 2, len(places) - 1)]
    found = False
    # Ten rounds of a sixteenth each come down to the last digits of a place; there the test itself may miss.
    for _ in range(10):
        grids = np.linspace(*a, 17), np.linspace(*b, 17)
        p, q = (envelope.at(grid).points for grid in grids)
        i, j = (index.ravel() for index in np.indices((16, 16)))
        hits = np.flatnonzero(np.isfinite(intersection(p[i], p[i + 1], q[j], q[j + 1])))
        if len(hits) == 0:
            break
        found = True
        i, j = i[hits[0]], j[hits[0]]
        a, b = (grids[0][i], grids[0][i + 1]), (grids[1][j], grids[1][j + 1])
    if found:
        return 0.5 * (a[0] + a[1]), 0.5 * (b[0] + b[1])
    # Branches that meet at a grazing angle may miss each other by rounding; ends that all but touch are as good.
    pairs = [(a[1], b[0]), (float(places[last]), float(places[first]))]
    gaps = [np.linalg.norm(np.diff(envelope.at(np.array(pair)).points, axis=0)) for pair in pairs]
    points = envelope.trace.points
    spacing = np.linalg.norm(points[last] - points[last - 1]) + np.linalg.norm(points[first + 1] - points[first])
    return pairs[int(np.argmin(gaps))] if min(gaps) <= spacing else None


def _up_to(envelope: _Envelope, stretches: list[tuple[float, float]], height_mm: float) -> list[tuple[float, float]]:
    """Return the stretches up to where they first reach a height."""
    for number, (start, end) in enumerate(stretches):
        inside = envelope.places[(envelope.places > start) & (envelope.places < end)]
        places = np.concatenate([[start], inside, [end]])
        above = np.flatnonzero(envelope.at(places).points[:, 1] >= height_mm)
        if len(above) and above[0] > 0:
            low, high = places[above[0] - 1], places[above[0]]
            for _ in range(60):
                middle = 0.5 * (low + high)
                if envelope.at(np.array([middle])).points[0, 1] >= height_mm:
                    high = middle
                else:
                    low = middle
            return [*stretches[:number], (start, high)]
    raise GlassWorkbenchError(
        f"revolved: the offset meridian breaks off before it reaches {height_mm:.2f} mm, where the mouth is"
    )


def _fitted(
    envelope: _Envelope, stretches: list[tuple[float, float]], tolerance_mm: float
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
            if tangent is not None and abs(_turn(tangent, ends.tangents[0])) > SMOOTH:
                corners.append(len(chain))
            pieces, error = _fit_between(envelope, low, high, tolerance_mm)
            chain += pieces
            worst = max(worst, error)
            tangent = ends.tangents[1]
    for before, after in itertools.pairwise(chain):
        after[:2, :2] += before[3, :2] - after[0, :2]
    chain[0][0, 0] = 0.0
    runs = tuple(zip(corners, [*corners[1:], len(chain)], strict=True))
    return np.array(chain), runs, worst


def _fit_between(envelope: _Envelope, low: float, high: float, tolerance_mm: float) -> tuple[list[np.ndarray], float]:
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
