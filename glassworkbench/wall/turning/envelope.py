"""The envelope of circles about the outer meridian, whose radius is the thickness asked there.

Its pieces follow the outside, folds and all; `unfolding` tells which stretches of it bound the cavity.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from glassworkbench.wall.turning.along_meridian import AlongMeridian
from glassworkbench.wall.turning.bezier import cut, evaluate, unit
from glassworkbench.wall.turning.profile import WallMeridian

SAMPLES = 4000
"""Samples along the outside; they find the folds, whose ends are then computed exactly."""

HALVINGS = 6
"""How often the samples' spacing is halved toward the ends of a piece."""

SLIVER_MM = 1e-6
"""A knot of the thickness this close to the height at which a segment ends does not cut it."""

PAST_MOUTH_MM = 5.0
"""How far the tracer's cavity reaches above the finish."""


@dataclass(frozen=True, eq=False)
class Trace:
    """Points of the envelope (m, 2), the outside points they come from, the thickness there, and p - s as a unit."""

    points: np.ndarray
    feet: np.ndarray
    thickness: np.ndarray
    directions: np.ndarray

    @property
    def tangents(self) -> np.ndarray:
        """Unit tangents (m, 2) of the envelope."""
        return np.column_stack([self.directions[:, 1], -self.directions[:, 0]])


@dataclass(frozen=True, eq=False)
class _Offset:
    """The envelope along one segment of the outside."""

    segment: np.ndarray
    thickness: AlongMeridian
    underside: bool
    length_mm: float

    def trace(self, u: np.ndarray) -> Trace:
        feet = evaluate(self.segment, u)[0]
        # A segment whose first handle has no length still has a tangent next to its end.
        tangent = unit(evaluate(self.segment, np.clip(u, 1e-9, 1.0 - 1e-9))[1])
        # And the thickness, whose knots lie near ends, has one slope there.
        end = min(2.0 * SLIVER_MM / self.length_mm, 0.5)
        within = evaluate(self.segment, np.clip(u, end, 1.0 - end))[0]
        radius = self.thickness.at(feet, self.underside)
        growth = self.thickness.growth(within, tangent, self.underside)
        return _on_circles(feet, tangent, radius, growth)


@dataclass(frozen=True, eq=False)
class _Extension:
    """The envelope along the straight line on which the wall goes on above the lip."""

    start: np.ndarray
    tangent: np.ndarray
    length_mm: float
    thickness_mm: float
    growth: float

    def trace(self, u: np.ndarray) -> Trace:
        along = np.asarray(u) * self.length_mm
        tangent = np.broadcast_to(self.tangent, (len(along), 2))
        growth = np.full(len(along), self.growth)
        radius = np.maximum(self.thickness_mm + growth * along, 0.0)
        return _on_circles(self.start + along[:, None] * tangent, tangent, radius, growth)


@dataclass(frozen=True, eq=False)
class _Fan:
    """The circle about a re-entrant corner, swept clockwise from one angle (rad) to another."""

    centre: np.ndarray
    radius: float
    first: float
    last: float

    def trace(self, u: np.ndarray) -> Trace:
        angle = self.first + np.asarray(u) * (self.last - self.first)
        directions = np.column_stack([np.cos(angle), np.sin(angle)])
        feet = np.broadcast_to(self.centre, directions.shape)
        return Trace(feet + self.radius * directions, feet, np.full(len(angle), self.radius), directions)


def _on_circles(feet: np.ndarray, tangent: np.ndarray, radius: np.ndarray, growth: np.ndarray) -> Trace:
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    # Where the thickness grows faster than the arc length, circles lie inside their neighbours: no envelope (NaN).
    with np.errstate(invalid="ignore"):
        across = np.sqrt(1.0 - growth**2)
    directions = -growth[:, None] * tangent + across[:, None] * normal
    return Trace(feet + radius[:, None] * directions, feet, radius, directions)


class Envelope:
    """The pieces in order; a place on them is one number, piece index + parameter.

    `places` are samples all along, `trace` what is there.
    """

    def __init__(self, pieces: list, lengths_mm: list[float]) -> None:
        self.pieces = pieces
        spacing = sum(lengths_mm) / SAMPLES
        grids = [number + _samples(int(length / spacing) + 2) for number, length in enumerate(lengths_mm)]
        # The same place is the end of one piece and the start of the next; a tiny step keeps the two apart.
        self.places = np.concatenate([np.append(grid[:-1], np.nextafter(grid[-1], 0.0)) for grid in grids])
        self.trace = self.at(self.places)

    def at(self, places: np.ndarray) -> Trace:
        """Return what is at places (m,)."""
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
        return Trace(*parts)


def _samples(count: int) -> np.ndarray:
    """Return parameters from 0 to 1 in equal steps, halved toward both ends, where folds can be small."""
    even = np.linspace(0.0, 1.0, max(17, count))
    closer = even[1] * 0.5 ** np.arange(1, HALVINGS + 1)
    return np.sort(np.concatenate([even, closer, 1.0 - closer]))


def envelope_of(wall: WallMeridian, thickness: AlongMeridian) -> Envelope:
    """Return the envelope along a wall's outside, the circles about re-entrant corners, and the line above the lip.

    Notes
    -----
    For a centre s(l), l the arc length, T its tangent, N the inward normal and t(l) the radius, the circles' envelope
    is p = s + t (-t' T + sqrt(1 - t'^2) N). At corners where the body is re-entrant the circle itself closes the gap.
    """
    pieces, lengths = [], []
    direction = np.array([0.0, 1.0])
    for piece, length in _outside(wall, thickness):
        trace = piece.trace(np.array([0.0, 1.0]))
        turn = turn_between(direction, trace.directions[0])
        if turn < -1e-6:
            first = np.arctan2(direction[1], direction[0])
            pieces.append(_Fan(trace.feet[0], float(trace.thickness[0]), first, first + turn))
            lengths.append(-turn * float(trace.thickness[0]))
        pieces.append(piece)
        lengths.append(length)
        direction = trace.directions[1]
    return Envelope(pieces, lengths)


def turn_between(before: np.ndarray, after: np.ndarray) -> float:
    """Return the angle (rad) from one direction to the next, counter-clockwise positive; 0 where there is none."""
    angle = np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after)
    return float(np.nan_to_num(angle))


def _outside(wall: WallMeridian, thickness: AlongMeridian) -> list[tuple]:
    """Return the offsets of all segments, cut at the table's heights, and of the line above the lip; with lengths."""
    pieces = []
    for segment, underside in zip(wall.segments, wall.underside, strict=True):
        for part in _cut_at_heights(segment, thickness):
            points = evaluate(part, np.linspace(0.0, 1.0, 17))[0]
            length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
            pieces.append((_Offset(part, thickness, bool(underside), length), length))
    point, tangent = wall.lip, wall.lip_direction
    at_lip = float(thickness.at(point[None])[0])
    growth = float(thickness.growth(point[None] - np.array([0.0, 1e-9]), tangent[None])[0])
    rise = wall.finish_height_mm - point[1] + 2.0 * at_lip + PAST_MOUTH_MM
    length = rise / max(float(tangent[1]), 0.2)
    pieces.append((_Extension(point, tangent, length, at_lip, growth), length))
    return pieces


def _cut_at_heights(segment: np.ndarray, thickness: AlongMeridian) -> list[np.ndarray]:
    """Cut a segment where the thickness has a knot: within each part the envelope is as smooth as the segment."""
    u = np.linspace(0.0, 1.0, 65)
    z = evaluate(segment, u)[0][:, 1]
    knots = thickness.knots_mm
    knots = knots[(knots > z.min() + SLIVER_MM) & (knots < z.max() - SLIVER_MM)]
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
