"""The exact surface of a CAD face as rational Bezier patches, and where on them a point lies."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from math import comb

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import Part

ROUND = 1e-9
"""A parameter range that lacks no more than this share of the period goes all the way round."""

SAMPLES = 40
"""Offset surfaces are compared with their approximation at this many parameters a side."""

SAFETY = 2.0
"""The error between samples is at most this many times the largest at a sample: it has many waves less than samples."""

SAME_PARAMETERS_MM = 1e-3
"""An approximation that is farther off at equal parameters has other parameters."""

NEWTON_STEPS = 12

STILL = 1e-13
"""Steps shorter than this share of a patch change nothing."""

STARTS = 4000
"""Without given parameters, a search for the closest point starts from about so many samples, at least 9 a patch."""

FOUND_MM = 1e-4
"""A point that is farther than this from where Newton's steps led is searched again from samples."""


@dataclass(frozen=True, eq=False)
class FacePatches:
    """A face's underlying surface, not trimmed by the face's edges, as patches of one degree.

    The parameters of the rectangles are those of the surface's B-spline form. They are the CAD face's own for planes,
    B-splines, Bezier surfaces and along straight generators. Around circles, ellipses and hyperbolas a rational form
    runs otherwise: it meets the CAD's parameter (an angle) at the ends of the patches, lies below a hundredth of their
    width off between them, and always has the same sense; `locate` gives the place of a point exactly.

    Parameters
    ----------
    controls : array (n, degree_u + 1, degree_v + 1, 4)
        Homogeneous control points (x w, y w, z w, w) in mm; the second index runs along u, the third along v.
    rectangles : array (n, 4)
        The parameters u0, u1, v0, v1 that each patch covers.
    period : (float, float)
        After which the surface's u and v repeat, 0 where they do not; the rectangles may lie whole periods off.
    error_mm : float
        Largest distance from the CAD surface: 0 for all but offset surfaces, which have no exact rational form.
    reversed : bool
        Whether d/du x d/dv points into the solid that the face bounds.
    """

    controls: np.ndarray
    rectangles: np.ndarray
    period: tuple[float, float]
    error_mm: float
    reversed: bool

    @property
    def degrees(self) -> tuple[int, int]:
        """The degrees along u and v."""
        return self.controls.shape[1] - 1, self.controls.shape[2] - 1

    def points(self, numbers: np.ndarray, uv: np.ndarray) -> np.ndarray:
        """Return the points (n, 3) at parameters (n, 2), each in [0, 1], of the patches with the given numbers (n,)."""
        return _evaluated(self.controls[numbers], uv)[0]


def face_patches(face: Part.Face) -> FacePatches:
    """Return the patches of a CAD face's surface, those that its parameter range touches.

    OCC converts elementary, swept and turned surfaces exactly; knots are inserted until each span is a patch of its
    own.

    Raises
    ------
    GlassWorkbenchError
        If OCC cannot convert the surface.
    """
    surface = face.Surface
    bounds = _within_period(surface, face.ParameterRange)
    try:
        spline = surface.toShape(*bounds).toNurbs().Faces[0].Surface
    except Part.OCCError as error:
        raise GlassWorkbenchError(
            f"a face of type {type(surface).__name__} could not be converted to a B-spline ({error}); "
            "repair the file in the CAD program"
        ) from error
    error_mm = _error_mm(surface, spline) if type(surface).__name__ == "OffsetSurface" else 0.0
    period = (
        surface.UPeriod() if surface.isUPeriodic() else 0.0,
        surface.VPeriod() if surface.isVPeriodic() else 0.0,
    )
    controls, rectangles = _bezier(spline)
    kept = _touched(rectangles[:, :2], bounds[:2], period[0]) & _touched(rectangles[:, 2:], bounds[2:], period[1])
    return FacePatches(controls[kept], rectangles[kept], period, error_mm, face.Orientation == "Reversed")


def locate(
    patches: FacePatches, points_mm: np.ndarray, parameters: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the number (n,) of the patch nearest to each point (n, 3), and the place (n, 2) in it, in [0, 1].

    Parameters
    ----------
    patches : FacePatches
    points_mm : array (n, 3)
        On the face, or near it.
    parameters : array (n, 2), optional
        The CAD face's own u and v there, from which the search starts; without, it starts from samples of all patches.
    """
    points_mm = np.asarray(points_mm, dtype=float)
    if parameters is None:
        return _stepped(patches, points_mm, *_nearest_sample(patches, points_mm))
    numbers, uv = _stepped(patches, points_mm, *_place(patches, np.asarray(parameters, dtype=float)))
    far = np.linalg.norm(patches.points(numbers, uv) - points_mm, axis=1) > FOUND_MM + patches.error_mm
    if np.any(far):
        again = _stepped(patches, points_mm[far], *_nearest_sample(patches, points_mm[far]))
        distances = [
            np.linalg.norm(patches.points(*found) - points_mm[far], axis=1)
            for found in ((numbers[far], uv[far]), again)
        ]
        better = np.flatnonzero(far)[distances[1] < distances[0]]
        numbers[better], uv[better] = (array[distances[1] < distances[0]] for array in again)
    return numbers, uv


def _within_period(surface: object, bounds: tuple[float, ...]) -> tuple[float, ...]:
    """Return a parameter range, or the whole period: sewing leaves ranges that reach round by a hair more."""
    ranges = [list(bounds[:2]), list(bounds[2:])]
    if surface.isUPeriodic() and np.diff(ranges[0])[0] > (1.0 - ROUND) * surface.UPeriod():
        ranges[0] = [surface.bounds()[0], surface.bounds()[0] + surface.UPeriod()]
    if surface.isVPeriodic() and np.diff(ranges[1])[0] > (1.0 - ROUND) * surface.VPeriod():
        ranges[1] = [surface.bounds()[2], surface.bounds()[2] + surface.VPeriod()]
    return (*ranges[0], *ranges[1])


def _error_mm(surface: object, spline: object) -> float:
    u0, u1, v0, v1 = spline.bounds()
    grid = list(itertools.product(np.linspace(u0, u1, SAMPLES), np.linspace(v0, v1, SAMPLES)))
    error = max((surface.value(u, v) - spline.value(u, v)).Length for u, v in grid)
    if error > SAME_PARAMETERS_MM:
        # The offset of a torus is a torus, converted exactly, but with other parameters: feet are slow, so take few.
        places = [spline.value(u, v) for u, v in grid[:: SAMPLES // 2 + 1]]
        error = max((surface.value(*surface.parameter(place)) - place).Length for place in places)
    return SAFETY * error


def _bezier(spline: object) -> tuple[np.ndarray, np.ndarray]:
    """Return the control points (n, p + 1, q + 1, 4) of a B-spline surface's spans and their rectangles (n, 4)."""
    spline = spline.copy()
    # Cut to its own bounds, a periodic surface is no longer periodic, and its end knots are as multiple as the others.
    spline.segment(*spline.bounds())
    p, q = spline.UDegree, spline.VDegree
    u_knots, v_knots = spline.getUKnots(), spline.getVKnots()
    if len(u_knots) > 2:
        spline.increaseUMultiplicity(2, len(u_knots) - 1, p)
    if len(v_knots) > 2:
        spline.increaseVMultiplicity(2, len(v_knots) - 1, q)
    poles = np.array([[tuple(pole) for pole in row] for row in spline.getPoles()])
    weights = np.array(spline.getWeights(), dtype=float)
    homogeneous = np.concatenate([poles * weights[:, :, None], weights[:, :, None]], axis=2)
    spans = list(itertools.product(range(len(u_knots) - 1), range(len(v_knots) - 1)))
    controls = [homogeneous[i * p : i * p + p + 1, j * q : j * q + q + 1] for i, j in spans]
    rectangles = [[u_knots[i], u_knots[i + 1], v_knots[j], v_knots[j + 1]] for i, j in spans]
    return np.array(controls), np.array(rectangles)


def _touched(intervals: np.ndarray, wanted: tuple[float, float], period: float) -> np.ndarray:
    """Return which intervals (n, 2) share more than an end with the wanted one, or with it moved by whole periods."""
    slack = 1e-9 * (wanted[1] - wanted[0])
    low, high = wanted[0] + slack, wanted[1] - slack
    shifts = period * np.arange(-2, 3) if period else np.zeros(1)
    starts, ends = intervals[:, :1] + shifts, intervals[:, 1:] + shifts
    return np.any((starts < high) & (ends > low), axis=1)


def _place(patches: FacePatches, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the patch number (n,) and the place (n, 2) in it of B-spline parameters (n, 2), clipped to the patches."""
    numbers, places = np.zeros(len(parameters), dtype=np.int64), np.empty((len(parameters), 2))
    for axis in range(2):
        # The patches fill a grid, u outside, v inside.
        spans = np.unique(patches.rectangles[:, 2 * axis : 2 * axis + 2], axis=0)
        start, width = spans[:, 0], np.diff(spans, axis=1)[:, 0]
        value = parameters[:, axis, None]
        if patches.period[axis]:
            # As near as whole periods bring it to the middle of the span.
            value = value - patches.period[axis] * np.round((value - start - 0.5 * width) / patches.period[axis])
        share = (value - start) / width
        span = np.argmin(np.maximum(-share, share - 1.0).clip(0.0) * width, axis=1)
        places[:, axis] = np.clip(share[np.arange(len(span)), span], 0.0, 1.0)
        numbers = numbers * len(spans) + span
    return numbers, places


def _nearest_sample(patches: FacePatches, points_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    count = max(3, round(np.sqrt(STARTS / len(patches.controls))))
    steps = (np.arange(count) + 0.5) / count
    grid = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.repeat(np.arange(len(patches.controls)), len(grid))
    uv = np.tile(grid, (len(patches.controls), 1))
    samples = patches.points(number, uv)
    nearest = np.concatenate(
        [
            np.argmin(((block[:, None] - samples) ** 2).sum(axis=2), axis=1)
            for block in np.array_split(points_mm, max(1, len(points_mm) * len(samples) // 2_000_000))
        ]
    )
    return number[nearest], uv[nearest]


def _stepped(
    patches: FacePatches, points_mm: np.ndarray, numbers: np.ndarray, uv: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return where Gauss and Newton's steps to the closest point lead, across the borders of patches."""
    numbers, uv = numbers.copy(), uv.copy()
    moving = np.arange(len(numbers))
    for _ in range(NEWTON_STEPS):
        here, start = numbers[moving], uv[moving]
        place, along_u, along_v = _evaluated(patches.controls[here], start)
        moved = start + np.clip(_step(points_mm[moving] - place, along_u, along_v), -0.5, 0.5)
        inside = np.clip(moved, 0.0, 1.0)
        leaves = np.any(moved != inside, axis=1)
        uv[moving] = inside
        if np.any(leaves):
            rectangles = patches.rectangles[here[leaves]]
            low, width = rectangles[:, ::2], rectangles[:, 1::2] - rectangles[:, ::2]
            numbers[moving[leaves]], uv[moving[leaves]] = _place(patches, low + moved[leaves] * width)
        moving = moving[np.any((numbers[moving] != here)[:, None] | (np.abs(uv[moving] - start) > STILL), axis=1)]
        if len(moving) == 0:
            break
    return numbers, uv


def _step(gap: np.ndarray, along_u: np.ndarray, along_v: np.ndarray) -> np.ndarray:
    """Return the least-squares step (n, 2) along two tangents (n, 3) that closes a gap (n, 3)."""
    uu, uv, vv = (np.einsum("ij,ij->i", a, b) for a, b in ((along_u,) * 2, (along_u, along_v), (along_v,) * 2))
    # Damped by no more than rounding, for where a tangent vanishes (a sphere's pole).
    damping = 1e-15 * (uu + vv) + 1e-300
    uu, vv = uu + damping, vv + damping
    toward_u, toward_v = np.einsum("ij,ij->i", gap, along_u), np.einsum("ij,ij->i", gap, along_v)
    determinant = uu * vv - uv**2
    determinant = np.where(determinant > 0.0, determinant, np.inf)
    return np.column_stack([vv * toward_u - uv * toward_v, uu * toward_v - uv * toward_u]) / determinant[:, None]


def _evaluated(controls: np.ndarray, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the points and the derivatives by u and v, each (n, 3), of one patch (p + 1, q + 1, 4) for each of uv."""
    bases = [_bernstein(controls.shape[axis + 1] - 1, uv[:, axis]) for axis in range(2)]
    (along_u, slope_u), (along_v, slope_v) = bases
    whole, by_u, by_v = (
        np.einsum("ni,nj,nijk->nk", a, b, controls, optimize=True)
        for a, b in ((along_u, along_v), (slope_u, along_v), (along_u, slope_v))
    )
    place = whole[:, :3] / whole[:, 3:]
    return place, *((rate[:, :3] - place * rate[:, 3:]) / whole[:, 3:] for rate in (by_u, by_v))


def _bernstein(degree: int, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the Bernstein polynomials (n, degree + 1) at t (n,) and their derivatives."""

    def basis(d: int) -> np.ndarray:
        k = np.arange(d + 1)
        return np.array([comb(d, i) for i in k]) * t[:, None] ** k * (1.0 - t[:, None]) ** (d - k)

    lower = np.pad(basis(degree - 1), ((0, 0), (1, 1)))
    return basis(degree), degree * (lower[:, :-1] - lower[:, 1:])
