"""Where straight lines cross a revolved meridian of rational cubic Bezier segments, in numpy.

In the half-plane (r, z) of the meridian a line is one branch of a hyperbola. With o and d its origin and unit
direction, o' and d' their parts across the axis and a = |d'|, the line is at height z at

    r(z) = H(z) / |d_z|,    H(z) = |d_z o' + (z - o_z) d'|,

which is convex in z, has its waist r(z0) = w at the height z0 nearest to the axis, and opens with slope a / |d_z|.
A point (R, Z) of the meridian is *outside* the hyperbola, seen from the axis, where g = |d_z| R - H(Z) > 0, and the
line crosses the surface where g changes sign along the meridian. H needs no division and holds for every direction.
For a horizontal line the hyperbola closes to the double ray z = z0, r > w; so pieces are parted at Z = z0, where
g > 0 means R > w exactly, and each part meets one half of the double ray.

The degree-6 polynomial of the line and the segment is never formed: it turns into a square for horizontal lines.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement, pairwise

import numpy as np
from numpy.polynomial.polynomial import polyder, polymul, polyroots, polysub, polytrim

from glassworkbench.scene import Revolved

PIECES_A_SEGMENT = 4
"""Equal parts in u that a segment is cut into besides its extrema, so that boxes are tight and bounds are sharp."""

SMALLEST_PART = 1e-13
"""Parts of a piece shorter than this in u are decided by the signs at their ends."""

BLUR = 4e-3
"""Changes of g below this share of a piece's slack, some units in the last place, say nothing."""

ROOT_TOLERANCE = 1e-13
"""Of u in [0, 1]; crossings are polished afterwards."""

MOST_STEPS = 200
POLISHING_STEPS = 2


class RevolvedCrosser:
    """The meridian in pieces along which r and z are monotone, and the crossings of lines with them."""

    def __init__(self, surface: Revolved) -> None:
        self.frame = _frame(surface.axis)
        self.base = surface.base_mm
        self.pieces = _Pieces(surface.meridian)
        self.centre_height = 0.5 * (self.pieces.node_z.min() + self.pieces.node_z.max())

    def __call__(
        self, origins: np.ndarray, directions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return line (k,), distance in mm (k,), whether it enters (k,), and outward unit normal (k, 3)."""
        relative = origins - self.base - self.centre_height * self.frame[2]
        # Seen from the point nearest to the body's middle, coordinates are no larger than the body.
        advance = -_dot(relative, directions)
        relative = relative + advance[:, None] * directions
        lines = _Lines.of(relative @ self.frame.T, directions @ self.frame.T, self.centre_height)

        brackets = _isolate(lines, self.pieces)
        u = _refine(lines, self.pieces, brackets)
        line, piece = brackets.line, brackets.piece
        u, distance = _polish(lines.take(line), self.pieces, piece, u, brackets.above)

        across = lines.origin[line] + distance[:, None] * lines.direction[line]
        radius = _length(across)
        radial = across / np.where(radius > 0.0, radius, 1.0)[:, None]
        tangent_r, tangent_z = self.pieces.tangent(piece, u)
        normal = np.column_stack([tangent_z[:, None] * radial, -tangent_r])
        normal /= _length(normal)[:, None]
        # At a crossing n.d has the sign of -d_z g'; the signs around it say that without rounding.
        entering = brackets.outward == (lines.slope[line] >= 0.0)
        return line, advance[line] + distance, entering, normal @ self.frame


def _frame(axis: np.ndarray) -> np.ndarray:
    """Return a right-handed orthonormal frame as rows, the axis last."""
    helper = np.roll(np.eye(3)[np.argmax(np.abs(axis))], 1)
    first = helper - (helper @ axis) * axis
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first), axis])


class _Pieces:
    """Monotone pieces of a meridian; piece k runs from node k to node k + 1."""

    def __init__(self, meridian: np.ndarray) -> None:
        homogeneous = meridian.copy()
        homogeneous[:, :, :2] *= meridian[:, :, 2:]
        controls, nodes = [], []
        for points, segment in zip(homogeneous, meridian, strict=True):
            cuts = _cuts(points)
            nodes.append(segment[0, :2])
            for low, high in pairwise(cuts):
                part = _part(points, low, high)
                controls.append(part)
                if high < 1.0:
                    nodes.append(part[3, :2] / part[3, 2])
        nodes.append(meridian[-1, 3, :2])
        self.powers = np.array([_power_coefficients(part) for part in controls]).transpose(1, 2, 0).copy()
        self.node_r, self.node_z = np.array(nodes).T.copy()
        self.third_r, self.third_z = _third_derivative_bounds(np.array(controls))
        self.least_weight = np.array(controls)[:, :, 2].min(axis=1)
        self.slack = 1e-12 * np.abs(nodes).max()

    def values(self, piece: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return r and z of pieces at parameters u in [0, 1]."""
        c0, c1, c2, c3 = self.powers[:, :, piece]
        x, y, w = ((c3 * u + c2) * u + c1) * u + c0
        return x / w, y / w

    def derivatives(self, piece: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return r, r', r'', z, z', z'' of pieces at parameters u in [0, 1]."""
        c0, c1, c2, c3 = self.powers[:, :, piece]
        value = ((c3 * u + c2) * u + c1) * u + c0
        slope = (3.0 * c3 * u + 2.0 * c2) * u + c1
        bend = 6.0 * c3 * u + 2.0 * c2
        weight = value[2]
        f = value[:2] / weight
        df = (slope[:2] - f * slope[2]) / weight
        ddf = (bend[:2] - 2.0 * df * slope[2] - f * bend[2]) / weight
        return f[0], df[0], ddf[0], f[1], df[1], ddf[1]

    def tangent(self, piece: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return r' and z', or the chord's direction where both vanish (control points may coincide)."""
        _, slope_r, _, _, slope_z, _ = self.derivatives(piece, u)
        chord_r = self.node_r[piece + 1] - self.node_r[piece]
        chord_z = self.node_z[piece + 1] - self.node_z[piece]
        rest = np.hypot(slope_r, slope_z) <= 1e-12 * np.hypot(chord_r, chord_z)
        return np.where(rest, chord_r, slope_r), np.where(rest, chord_z, slope_z)


def _cuts(points: np.ndarray) -> np.ndarray:
    """Return parameters, 0 and 1 among them, between which r and z are monotone."""
    coefficients = _power_coefficients(points)
    weight = coefficients[:, 2]
    cuts = list(np.linspace(0.0, 1.0, PIECES_A_SEGMENT + 1))
    for k in range(2):
        shifted = coefficients[:, k] - points[0, k] / points[0, 2] * weight
        slope = polysub(polymul(polyder(shifted), weight), polymul(shifted, polyder(weight)))
        slope = polytrim(slope, 1e-14 * max(np.abs(slope).max(), 1e-300))
        cuts += [float(root.real) for root in polyroots(slope) if abs(root.imag) < 1e-7 and 0.0 < root.real < 1.0]
    cuts = np.sort(cuts)
    apart = np.append(True, np.diff(cuts) > 1e-9)
    apart[-1] = True
    return cuts[apart]


def _part(points: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return the control points of the part [low, high] of a cubic, by blossoming."""

    def blossom(*parameters: float) -> np.ndarray:
        rest = points
        for u in parameters:
            rest = (1.0 - u) * rest[:-1] + u * rest[1:]
        return rest[0]

    return np.array(
        [blossom(low, low, low), blossom(low, low, high), blossom(low, high, high), blossom(high, high, high)]
    )


def _power_coefficients(points: np.ndarray) -> np.ndarray:
    """Return the coefficients of 1, u, u^2, u^3 of the cubic with control points (4, ...)."""
    p0, p1, p2, p3 = points
    return np.array([p0, 3.0 * (p1 - p0), 3.0 * (p2 - 2.0 * p1 + p0), p3 - 3.0 * p2 + 3.0 * p1 - p0])


def _third_derivative_bounds(controls: np.ndarray) -> np.ndarray:
    """Return bounds of |r'''| and |z'''| on [0, 1], (2, n), for pieces with homogeneous control points (n, 4, 3).

    With f = x / w, f''' = (x''' - 3 f'' w' - 3 f' w'' - f w''') / w, and likewise f'' and f', bounded in turn by the
    control points of their parts; f counts from its value at the start.
    """
    start = controls[:, :1, :2] / controls[:, :1, 2:]
    shifted = np.dstack([controls[:, :, :2] - start * controls[:, :, 2:], controls[:, :, 2:]])
    first = 3.0 * np.diff(shifted, axis=1)
    second = 2.0 * np.diff(first, axis=1)
    third = np.diff(second, axis=1)
    largest = [np.abs(points).max(axis=1).T for points in (shifted, first, second, third)]
    (x, _), (x1, w1), (x2, w2), (x3, w3) = ((points[:2], points[2]) for points in largest)
    least_weight = controls[:, :, 2].min(axis=1)
    bound = x / least_weight
    bound_1 = (x1 + bound * w1) / least_weight
    bound_2 = (x2 + 2.0 * bound_1 * w1 + bound * w2) / least_weight
    return (x3 + 3.0 * bound_2 * w1 + 3.0 * bound_1 * w2 + bound * w3) / least_weight


@dataclass(frozen=True, eq=False)
class _Lines:
    """Lines as hyperbolas in the half-plane (r, z); all arrays have one row a line.

    `origin` (o') and `direction` (d') are the two parts across the axis, `height` is o_z, `slope` d_z, `across`
    a = |d'|; `waist` is the least distance w to the axis, reached at `waist_height` z0 (NaN for lines along the axis).
    """

    origin: np.ndarray
    direction: np.ndarray
    height: np.ndarray
    slope: np.ndarray
    across: np.ndarray
    waist: np.ndarray
    waist_height: np.ndarray

    @classmethod
    def of(cls, origins: np.ndarray, directions: np.ndarray, centre_height: float) -> _Lines:
        """Make them from origins (n, 3), relative to the axis at centre_height, and unit directions (n, 3)."""
        origin, direction, slope = origins[:, :2], directions[:, :2], directions[:, 2]
        across = _length(direction)
        oblique = across > 0.0
        divisor = np.where(oblique, across, 1.0)
        moment = origin[:, 0] * direction[:, 1] - origin[:, 1] * direction[:, 0]
        waist = np.where(oblique, np.abs(moment) / divisor, _length(origin))
        height = origins[:, 2] + centre_height
        waist_height = np.where(oblique, height - slope * _dot(origin, direction) / divisor**2, np.nan)
        return cls(origin, direction, height, slope, across, waist, waist_height)

    def take(self, line: np.ndarray) -> _Lines:
        """Return the lines of the given numbers."""
        return _Lines(*(getattr(self, name)[line] for name in self.__dataclass_fields__))

    def column(self) -> _Lines:
        """Return them with a second axis, to be set against a row of pieces."""
        return self.take((slice(None), None))

    def hyperbola(self, z: np.ndarray) -> np.ndarray:
        """Return H at heights z (n,)."""
        return _length(self.slope[:, None] * self.origin + (z - self.height)[:, None] * self.direction)

    def hyperbola_slope(self, z: np.ndarray, hyperbola: np.ndarray) -> np.ndarray:
        """Return H' = d'.(d_z o' + (z - o_z) d') / H."""
        numerator = self.slope * _dot(self.origin, self.direction) + (z - self.height) * self.across**2
        return numerator / np.where(hyperbola > 0.0, hyperbola, 1.0)

    def hyperbola_bend(self, hyperbola: np.ndarray) -> np.ndarray:
        """Return H'' = (a w d_z)^2 / H^3."""
        # Bounded below, the quotient stays finite for horizontal lines; there only its size matters.
        return (self.across * self.waist * self.slope) ** 2 / np.maximum(hyperbola, 1e-100) ** 3

    def sees_outside(self, r: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return g > 0: whether points (r, z) of the meridian lie outside the hyperbola."""
        return np.where(z == self.waist_height, r > self.waist, np.abs(self.slope) * r > self.hyperbola(z))


@dataclass(frozen=True, eq=False)
class _Brackets:
    """Parts (low, high) of pieces with one crossing each.

    `outward` says that g goes from negative to positive as u grows, `above` that the part lies above the waist.
    """

    line: np.ndarray
    piece: np.ndarray
    low: np.ndarray
    high: np.ndarray
    outward: np.ndarray
    above: np.ndarray


@dataclass(frozen=True, eq=False)
class _Parts:
    """Parts (low, high) of pieces, on one side of the waist, with g's sign at both ends."""

    line: np.ndarray
    piece: np.ndarray
    low: np.ndarray
    high: np.ndarray
    sign_low: np.ndarray
    sign_high: np.ndarray
    above: np.ndarray

    def take(self, chosen: np.ndarray) -> _Parts:
        return _Parts(*(getattr(self, name)[chosen] for name in self.__dataclass_fields__))

    def split(self, u: np.ndarray, sign: np.ndarray) -> _Parts:
        """Return both halves of each part, parted at u where g has the given sign."""
        first = _Parts(self.line, self.piece, self.low, u, self.sign_low, sign, self.above)
        second = _Parts(self.line, self.piece, u, self.high, sign, self.sign_high, self.above)
        return first.with_(second)

    def with_(self, *others: _Parts) -> _Parts:
        names = self.__dataclass_fields__
        return _Parts(*(np.concatenate([getattr(part, name) for part in (self, *others)]) for name in names))


def _isolate(lines: _Lines, pieces: _Pieces) -> _Brackets:
    """Return all crossings, one a bracket.

    A part is settled when g is proved monotone on it, or proved convex or concave (then its extremum decides between
    no crossing and two); else it is halved. The proofs bound g' and g'' from Taylor's theorem and from the ranges of
    H' and H'', both monotone on one side of the waist.
    """
    parts = _candidates(lines, pieces)
    found, bulging = [], []
    while len(parts.line):
        here = lines.take(parts.line)
        mean, half = 0.5 * (parts.low + parts.high), 0.5 * (parts.high - parts.low)
        _, slope_r, bend_r, _, slope_z, bend_z = pieces.derivatives(parts.piece, mean)
        (r_low, z_low), (r_high, z_high) = (pieces.values(parts.piece, u) for u in (parts.low, parts.high))
        h_low, h_high = here.hyperbola(z_low), here.hyperbola(z_high)
        range_bend_r = _around(bend_r, pieces.third_r[parts.piece] * half)
        range_bend_z = _around(bend_z, pieces.third_z[parts.piece] * half)
        range_slope_r = _around(slope_r, half * np.maximum(-range_bend_r[0], range_bend_r[1]))
        range_slope_z = _around(slope_z, half * np.maximum(-range_bend_z[0], range_bend_z[1]))
        range_h_slope = _hull(here.hyperbola_slope(z_low, h_low), here.hyperbola_slope(z_high, h_high))
        range_h_bend = _hull(here.hyperbola_bend(h_low), here.hyperbola_bend(h_high))
        steepness = np.abs(here.slope)
        g_slope = _minus(steepness * range_slope_r, _times(range_h_slope, range_slope_z))
        square = np.square(range_slope_z)
        square = np.stack([np.where(np.prod(range_slope_z, axis=0) < 0.0, 0.0, square.min(axis=0)), square.max(axis=0)])
        g_bend = _minus(
            _minus(steepness * range_bend_r, range_h_bend * square),
            _times(range_h_slope, range_bend_z),
        )

        changes = parts.sign_low != parts.sign_high
        monotone = (g_slope[0] > 0.0) | (g_slope[1] < 0.0)
        convex, concave = g_bend[0] > 0.0, g_bend[1] < 0.0
        # From equal signs at its ends, g cannot reach 0 in between if its slope is too small for there and back.
        g_low, g_high = steepness * r_low - h_low, steepness * r_high - h_high
        most = half * np.abs(g_slope).max(axis=0)
        far = ~changes & (np.abs(g_low + g_high) > 2.0 * most + pieces.slack)
        # A line within a flat face, or along a cone, sees only rounding errors along it.
        bend = range_h_bend.max(axis=0) * (z_high - z_low) ** 2 / 8.0
        largest = _largest(pieces, parts, steepness, (z_low, z_high), (h_low, h_high)) + bend
        blurred = (np.minimum(most, largest) <= BLUR * pieces.slack) | (half <= SMALLEST_PART)
        settled = monotone | convex | concave | far | blurred
        found.append(parts.take(settled & changes))

        # Two crossings may hide where g bulges towards the other sign between its ends.
        bulging.append(parts.take(~changes & ~monotone & ~far & ~blurred & np.where(parts.sign_low, convex, concave)))

        parts = parts.take(~settled)
        middle = mean[~settled]
        r, z = pieces.values(parts.piece, middle)
        parts = parts.split(middle, lines.take(parts.line).sees_outside(r, z))
        parts = parts.take(_may_meet(lines.take(parts.line), pieces, parts))

    parts = parts.with_(*bulging)
    extremum, sign = _extremum(lines.take(parts.line), pieces, parts)
    pairs = sign != parts.sign_low
    parts = parts.take(pairs).split(extremum[pairs], sign[pairs]).with_(*found)
    return _Brackets(parts.line, parts.piece, parts.low, parts.high, parts.sign_high, parts.above)


def _largest(
    pieces: _Pieces,
    parts: _Parts,
    steepness: np.ndarray,
    z: tuple[np.ndarray, np.ndarray],
    h: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:
    """Return a bound of |g| on parts, by their control points, with the chord between its ends (z, h) for H."""
    rise = z[1] - z[0]
    slope = np.where(rise == 0.0, 0.0, (h[1] - h[0]) / np.where(rise == 0.0, 1.0, rise))
    x, y, weight = pieces.powers[:, :, parts.piece].swapaxes(0, 1)
    a0, a1, a2, a3 = steepness * x - slope * y - (h[0] - slope * z[0]) * weight
    control = [
        a0 + a1 * (p + q + r) / 3.0 + a2 * (p * q + q * r + r * p) / 3.0 + a3 * p * q * r
        for p, q, r in combinations_with_replacement((parts.low, parts.high), 3)
    ]
    return np.abs(control).max(axis=0) / pieces.least_weight[parts.piece]


def _candidates(lines: _Lines, pieces: _Pieces) -> _Parts:
    """Return the pieces that each line may meet, parted where they pass the line's waist height."""
    count, nodes = len(lines.height), len(pieces.node_r)
    everywhere = lines.take(np.repeat(np.arange(count), nodes))
    node_r, node_z = np.tile(pieces.node_r, count), np.tile(pieces.node_z, count)
    signs = everywhere.sees_outside(node_r, node_z).reshape(count, nodes)
    h = everywhere.hyperbola(node_z).reshape(count, nodes)
    changes = signs[:, :-1] != signs[:, 1:]
    meets = _boxes_meet(
        lines.column(),
        np.stack([pieces.node_r[:-1], pieces.node_r[1:]])[:, None],
        np.stack([pieces.node_z[:-1], pieces.node_z[1:]])[:, None],
        np.stack([h[:, :-1], h[:, 1:]]),
        pieces.slack,
    )
    line, piece = np.nonzero(meets | changes)
    waist = lines.waist_height[line]
    start, end = pieces.node_z[piece], pieces.node_z[piece + 1]
    above = 0.5 * (start + end) > waist
    parts = _Parts(
        line, piece, np.zeros(len(line)), np.ones(len(line)), signs[line, piece], signs[line, piece + 1], above
    )
    passes = (np.minimum(start, end) < waist) & (waist < np.maximum(start, end))
    passing = parts.take(passes)
    u = _height_reached(pieces, passing.piece, waist[passes])
    r, _ = pieces.values(passing.piece, u)
    halves = passing.split(u, r > lines.waist[passing.line])
    rises = (end > start)[passes]
    halves = replace(halves, above=np.concatenate([~rises, rises]))
    return parts.take(~passes).with_(halves)


def _may_meet(lines: _Lines, pieces: _Pieces, parts: _Parts) -> np.ndarray:
    """Return whether each part changes sign, or its box meets its line's hyperbola."""
    r_low, z_low = pieces.values(parts.piece, parts.low)
    r_high, z_high = pieces.values(parts.piece, parts.high)
    h = np.stack([lines.hyperbola(z_low), lines.hyperbola(z_high)])
    meets = _boxes_meet(lines, np.stack([r_low, r_high]), np.stack([z_low, z_high]), h, pieces.slack)
    return meets | (parts.sign_low != parts.sign_high)


def _boxes_meet(lines: _Lines, r: np.ndarray, z: np.ndarray, h: np.ndarray, slack: float) -> np.ndarray:
    """Return whether hyperbolas meet boxes given by r, z and H at two opposite corners (2, ...)."""
    steepness = np.abs(lines.slope)
    r_low, r_high = r.min(axis=0) - slack, r.max(axis=0) + slack
    z_low, z_high = z.min(axis=0) - slack, z.max(axis=0) + slack
    h_low, h_high = h.min(axis=0) - slack, h.max(axis=0) + slack
    h_low = np.where((z_low <= lines.waist_height) & (lines.waist_height <= z_high), 0.0, h_low)
    return (steepness * r_low <= h_high) & (steepness * r_high >= h_low) & (r_high >= lines.waist)


def _height_reached(pieces: _Pieces, piece: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return where pieces, monotone in z, reach heights between their ends."""

    def rise(u: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        _, _, _, here, slope, _ = pieces.derivatives(piece[chosen], u)
        return here - z[chosen], slope

    ends_above = pieces.node_z[piece + 1] > z
    return _root(rise, np.zeros(len(piece)), np.ones(len(piece)), ends_above)


def _extremum(lines: _Lines, pieces: _Pieces, parts: _Parts) -> tuple[np.ndarray, np.ndarray]:
    """Return where g is least on parts with positive ends, and greatest on those with negative ones, and its sign."""

    def slope(u: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        here = lines.take(chosen)
        _, slope_r, bend_r, z, slope_z, bend_z = pieces.derivatives(parts.piece[chosen], u)
        h = here.hyperbola(z)
        h_slope = here.hyperbola_slope(z, h)
        first = np.abs(here.slope) * slope_r - h_slope * slope_z
        second = np.abs(here.slope) * bend_r - here.hyperbola_bend(h) * slope_z**2 - h_slope * bend_z
        return first, second

    u = _root(slope, parts.low, parts.high, parts.sign_low)
    r, z = pieces.values(parts.piece, u)
    return u, lines.sees_outside(r, z)


def _refine(lines: _Lines, pieces: _Pieces, brackets: _Brackets) -> np.ndarray:
    """Return the parameter of each bracketed crossing.

    Flat lines (a > |d_z|) are followed in r, G = |d_z| sqrt(R^2 - w^2) - a |Z - z0|, steep ones in z, G = g.
    """

    def gap(u: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        here = lines.take(brackets.line[chosen])
        r, slope_r, _, z, slope_z, _ = pieces.derivatives(brackets.piece[chosen], u)
        steepness = np.abs(here.slope)
        flat = here.across > steepness
        side = np.where(brackets.above[chosen], 1.0, -1.0)
        reach = np.sqrt(np.maximum(r - here.waist, 0.0) * (r + here.waist))
        flat_gap = steepness * reach - here.across * side * (z - np.where(flat, here.waist_height, 0.0))
        flat_slope = steepness * r * slope_r / np.where(reach > 0.0, reach, np.inf) - here.across * side * slope_z
        h = here.hyperbola(z)
        steep_gap = steepness * r - h
        steep_slope = steepness * slope_r - here.hyperbola_slope(z, h) * slope_z
        return np.where(flat, flat_gap, steep_gap), np.where(flat, flat_slope, steep_slope)

    return _root(gap, brackets.low, brackets.high, brackets.outward)


def _root(
    function: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]],
    low: np.ndarray,
    high: np.ndarray,
    rises: np.ndarray,
) -> np.ndarray:
    """Return where functions pass through 0 between low and high, by Newton's method kept in a shrinking bracket.

    `function(u, chosen)` gives values and derivatives of the chosen functions; `rises` says that a function goes
    from negative at low to positive at high, which is taken for granted.
    """
    low, high = low.copy(), high.copy()
    u = 0.5 * (low + high)
    last_width = high - low
    active = np.arange(len(u))
    for _ in range(MOST_STEPS):
        if len(active) == 0:
            break
        here = u[active]
        value, slope = function(here, active)
        beyond = (value > 0.0) == rises[active]
        high[active] = np.where(beyond, here, high[active])
        low[active] = np.where(beyond, low[active], here)
        width = high[active] - low[active]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            newton = here - value / slope
        # Where Newton's step leaves the bracket, or shrinks it by less than half, bisection takes its turn.
        inside = (newton >= low[active]) & (newton <= high[active])
        step = np.where(inside, newton, 0.5 * (low[active] + high[active]))
        slow = (width > 0.5 * last_width[active]) & (np.abs(step - here) > 0.25 * last_width[active])
        step = np.where(slow, 0.5 * (low[active] + high[active]), step)
        last_width[active] = width
        u[active] = step
        active = active[np.abs(step - here) > ROOT_TOLERANCE]
    return u


def _polish(
    lines: _Lines, pieces: _Pieces, piece: np.ndarray, u: np.ndarray, above: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return u and the distance along the line, bettered together by Newton's method in both.

    The first distance comes from r for flat lines and from z for steep ones.
    """
    r, z = pieces.values(piece, u)
    steepness = np.abs(lines.slope)
    flat = lines.across > steepness
    across = np.where(flat, lines.across, 1.0)
    forward = above == (lines.slope >= 0.0)
    reach = np.sqrt(np.maximum(r - lines.waist, 0.0) * (r + lines.waist)) / across
    from_r = np.where(forward, reach, -reach) - _dot(lines.origin, lines.direction) / across**2
    from_z = (z - lines.height) / np.where(flat, 1.0, lines.slope)
    distance = np.where(flat, from_r, from_z)

    best_u, best_distance = u, distance
    best_error = np.full(len(u), np.inf)
    for _ in range(POLISHING_STEPS + 1):
        r, slope_r, _, z, slope_z, _ = pieces.derivatives(piece, u)
        point = lines.origin + distance[:, None] * lines.direction
        radius = _length(point)
        gap_r, gap_z = r - radius, z - lines.height - distance * lines.slope
        error = np.hypot(gap_r, gap_z)
        better = error < best_error
        best_u, best_distance = np.where(better, u, best_u), np.where(better, distance, best_distance)
        best_error = np.where(better, error, best_error)
        radius_slope = _dot(point, lines.direction) / np.where(radius > 0.0, radius, 1.0)
        determinant = slope_r * lines.slope - slope_z * radius_slope
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            step_u = (radius_slope * gap_z - lines.slope * gap_r) / determinant
            step_distance = (slope_r * gap_z - slope_z * gap_r) / determinant
        sound = np.isfinite(step_u) & np.isfinite(step_distance) & (np.abs(step_u) < 1e-3)
        u = np.clip(np.where(sound, u + step_u, u), 0.0, 1.0)
        distance = np.where(sound, distance + step_distance, distance)
    return best_u, best_distance


def _around(middle: np.ndarray, radius: np.ndarray) -> np.ndarray:
    return np.stack([middle - radius, middle + radius])


def _hull(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.stack([np.minimum(a, b), np.maximum(a, b)])


def _minus(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.stack([a[0] - b[1], a[1] - b[0]])


def _times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    products = np.stack([a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]])
    return np.stack([products.min(axis=0), products.max(axis=0)])


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...k,...k->...", a, b)


def _length(vectors: np.ndarray) -> np.ndarray:
    return np.sqrt(_dot(vectors, vectors))
