"""The exact meridian of a body of revolution, as rational cubic Bezier segments (r, z, weight)."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from functools import partial

import numpy as np

from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold.anatomy import REVOLVED_MM

JOINT_MM = 1e-4
"""Ends of neighbouring faces' profiles that lie closer are one point; CAD programs sew faces this far apart."""

ROUND_MM = 0.02
"""CAD kernels write fillets as splines that are round, and meet their neighbours, only to about this."""

APPROXIMATION_MM = 1e-6
"""Largest distance between a profile of degree above 3 and the cubics that stand for it."""


def face_profiles(faces: Iterable[Part.Face], round_mm: float = REVOLVED_MM) -> list[np.ndarray | None]:
    """Return each face's profile (n, 4, 3) in the half-plane of the z axis, None where it is not turned about z.

    Lines, circular arcs and splines up to degree 3 are exact; higher degrees are within `APPROXIMATION_MM`. Splines
    whose radii differ around the axis by less than `round_mm` count as turned.
    """
    return [_face_profile(face, round_mm) for face in faces]


def chain(profiles: list[np.ndarray | None], joint_mm: float = JOINT_MM) -> np.ndarray | None:
    """Return the profiles (each (n, 4, 3)) joined from the lowest point on the axis to the highest, or None.

    Profiles of partial faces that repeat each other are taken once; those that lead nowhere are left out. Ends that lie
    closer than `joint_mm` are one point.
    """
    pieces = _distinct([profile for profile in profiles if profile is not None])
    if not pieces:
        return None
    ends = np.array([[piece[0, 0, :2], piece[-1, 3, :2]] for piece in pieces])
    on_axis = [(z, k, side) for k, pair in enumerate(ends) for side, (r, z) in enumerate(pair) if r < JOINT_MM]
    if len(on_axis) < 2:
        return None
    _, first, side = min(on_axis)
    top = max(on_axis)[0]
    path = _walk(ends, first, side, top, joint_mm)
    if path is None:
        return None
    joined = [pieces[k] if side == 0 else pieces[k][::-1, ::-1] for k, side in path]
    return _snapped(joined)


def _walk(ends: np.ndarray, first: int, side: int, top: float, joint_mm: float) -> list[tuple[int, int]] | None:
    stack = [[(first, side)]]
    while stack:
        path = stack.pop()
        last, entered = path[-1]
        here = ends[last, 1 - entered]
        if here[0] < JOINT_MM and abs(here[1] - top) < JOINT_MM:
            return path
        used = {k for k, _ in path}
        near = np.abs(ends - here).max(axis=2) < joint_mm
        stack += [[*path, (int(k), int(s))] for k, s in np.argwhere(near) if int(k) not in used]
    return None


def _distinct(profiles: list[np.ndarray]) -> list[np.ndarray]:
    kept: list[np.ndarray] = []
    for profile in profiles:
        probe = points(profile, 3)
        if not any(_same(probe, points(other, 3)) for other in kept):
            kept.append(profile)
    return kept


def _same(probe: np.ndarray, other: np.ndarray) -> bool:
    if probe.shape != other.shape:
        return False
    return min(np.abs(probe - other).max(), np.abs(probe - other[::-1]).max()) < JOINT_MM


def _snapped(pieces: list[np.ndarray]) -> np.ndarray:
    segments = np.concatenate(pieces).copy()
    joints = 0.5 * (segments[:-1, 3, :2] + segments[1:, 0, :2])
    segments[:-1, 3, :2] = joints
    segments[1:, 0, :2] = joints
    segments[0, 0, 0] = segments[-1, 3, 0] = 0.0
    return segments


def points(segments: np.ndarray, per_segment: int) -> np.ndarray:
    """Return points (r, z) on rational cubic segments (n, 4, 3): `per_segment` equal parameter steps, ends once."""
    u = np.linspace(0.0, 1.0, per_segment + 1)
    basis = np.stack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
    weights = segments[:, :, 2] @ basis
    each = np.stack([(segments[:, :, k] * segments[:, :, 2]) @ basis / weights for k in range(2)], axis=2)
    return np.concatenate([each[:, :-1].reshape(-1, 2), segments[-1:, 3, :2]])


def flattened(segments: np.ndarray, spacing_mm: float) -> np.ndarray:
    """Return points (n, 2) on segments (m, 4, 3), at most `spacing_mm` apart and turning at most 2 degrees."""
    pieces = []
    for segment in segments:
        legs = np.diff(segment[:, :2], axis=0)
        legs = legs[np.linalg.norm(legs, axis=1) > 0.0]
        turns = np.diff(np.unwrap(np.arctan2(legs[:, 1], legs[:, 0])))
        steps = max(np.linalg.norm(legs, axis=1).sum() / spacing_mm, np.abs(turns).sum() / np.radians(2.0), 1.0)
        pieces.append(points(segment[None], int(np.ceil(steps)))[:-1])
    return np.concatenate([*pieces, segments[-1:, 3, :2]])


def _face_profile(face: Part.Face, round_mm: float) -> np.ndarray | None:
    make: dict[str, Callable[[Part.Face], np.ndarray | None]] = {
        "Plane": partial(_plane, round_mm=round_mm),
        "Cylinder": _ruled,
        "Cone": _ruled,
        "Toroid": _torus,
        "Sphere": _sphere,
        "SurfaceOfRevolution": _revolution,
        "BSplineSurface": partial(_spline_surface, round_mm=round_mm),
        "BezierSurface": partial(_spline_surface, round_mm=round_mm),
    }
    kind = "Plane" if face.Surface.isPlanar() else type(face.Surface).__name__
    profile = make[kind](face) if kind in make else None
    return None if profile is None else np.concatenate(list(_right_of_axis(profile)))


def _stands_on_axis(direction: FreeCAD.Vector, point: FreeCAD.Vector, reach_mm: float) -> bool:
    tilt = np.hypot(direction.x, direction.y) / direction.Length
    return np.hypot(point.x, point.y) < REVOLVED_MM and tilt * reach_mm < REVOLVED_MM


def _reach(face: Part.Face) -> float:
    return face.BoundBox.DiagonalLength


def _radius_height(point: FreeCAD.Vector) -> tuple[float, float]:
    return float(np.hypot(point.x, point.y)), float(point.z)


def _plane(face: Part.Face, round_mm: float) -> np.ndarray | None:
    axis = face.findPlane().Axis
    if np.hypot(axis.x, axis.y) * _reach(face) > REVOLVED_MM:
        return None
    radii = []
    for edge in face.Edges:
        low, high = edge.ParameterRange
        ring = [_radius_height(edge.valueAt(low + share * (high - low)))[0] for share in (0.0, 0.3, 0.6, 1.0)]
        if np.ptp(ring) < round_mm:
            radii.append(float(edge.Curve.Radius) if type(edge.Curve).__name__ == "Circle" else ring[0])
        elif not _is_radial(edge):
            return None
    height = face.Vertexes[0].Z
    if face.isInside(FreeCAD.Vector(0, 0, height), JOINT_MM, True):
        radii.append(0.0)
    if len(radii) < 2:
        return None
    return line((min(radii), height), (max(radii), height))


def _is_radial(edge: Part.Edge) -> bool:
    start, end = (edge.valueAt(parameter) for parameter in edge.ParameterRange)
    area = abs(start.x * end.y - start.y * end.x)
    return type(edge.Curve).__name__ in ("Line", "LineSegment") and area < REVOLVED_MM * edge.Length


def _ruled(face: Part.Face) -> np.ndarray | None:
    surface = face.Surface
    if not _stands_on_axis(surface.Axis, surface.Center, _reach(face)):
        return None
    u, _, low, high = face.ParameterRange
    return line(*(_radius_height(surface.value(u, v)) for v in (low, high)))


def _torus(face: Part.Face) -> np.ndarray | None:
    surface = face.Surface
    if not _stands_on_axis(surface.Axis, surface.Center, _reach(face)):
        return None
    _, _, low, high = face.ParameterRange
    sense = np.sign(surface.Axis.z)
    return arc((surface.MajorRadius, surface.Center.z), surface.MinorRadius, sense * low, sense * high)


def _sphere(face: Part.Face) -> np.ndarray | None:
    surface = face.Surface
    if not _stands_on_axis(surface.Axis, surface.Center, _reach(face)):
        return None
    _, _, low, high = face.ParameterRange
    sense = np.sign(surface.Axis.z)
    return arc((0.0, surface.Center.z), surface.Radius, sense * low, sense * high)


def _revolution(face: Part.Face) -> np.ndarray | None:
    surface = face.Surface
    if not _stands_on_axis(surface.Direction, surface.Location, _reach(face)):
        return None
    u, _, low, high = face.ParameterRange
    return _curve_profile(surface.uIso(u), low, high)


def _spline_surface(face: Part.Face, round_mm: float) -> np.ndarray | None:
    u0, u1, v0, v1 = face.ParameterRange
    surface = face.Surface
    shares = np.linspace(0.0, 1.0, 9)
    grid = np.array(
        [[_radius_height(surface.value(u0 + s * (u1 - u0), v0 + t * (v1 - v0))) for t in shares] for s in shares]
    )
    if np.ptp(grid, axis=0).max() < round_mm:
        return _curve_profile(surface.uIso(u0), v0, v1)
    if np.ptp(grid, axis=1).max() < round_mm:
        return _curve_profile(surface.vIso(v0), u0, u1)
    return None


def _curve_profile(curve: object, low: float, high: float) -> np.ndarray:
    """Return the part of a curve between two parameters, turned about z into the meridian half-plane."""
    middle = curve.value(0.5 * (low + high))
    length = np.hypot(middle.x, middle.y)
    outward = np.array([middle.x, middle.y]) / length

    def flat(point: FreeCAD.Vector) -> tuple[float, float]:
        return float(point.x * outward[0] + point.y * outward[1]), float(point.z)

    kind = type(curve).__name__
    if kind in ("Line", "LineSegment"):
        return line(flat(curve.value(low)), flat(curve.value(high)))
    if kind in ("Circle", "ArcOfCircle"):
        circle = curve.Circle if kind == "ArcOfCircle" else curve
        centre = flat(circle.Center)
        angles = np.unwrap([_angle(flat(curve.value(t)), centre) for t in np.linspace(low, high, 9)])
        return arc(centre, circle.Radius, angles[0], angles[-1])
    spline = curve.toBSpline(low, high)
    segments = [_bezier(bezier, flat) for bezier in spline.toBezier()]
    return np.concatenate(segments)


def _angle(point: tuple[float, float], centre: tuple[float, float]) -> float:
    return float(np.arctan2(point[1] - centre[1], point[0] - centre[0]))


def _bezier(bezier: object, flat: Callable[[FreeCAD.Vector], tuple[float, float]]) -> np.ndarray:
    if bezier.Degree > 3:
        return _cubics(bezier, flat)
    bezier.increase(3)
    return np.array(
        [[[*flat(pole), weight] for pole, weight in zip(bezier.getPoles(), bezier.getWeights(), strict=True)]]
    )


def _cubics(bezier: object, flat: Callable[[FreeCAD.Vector], tuple[float, float]]) -> np.ndarray:
    """Return cubics (n, 4, 3) that share points and derivatives with a Bezier of higher degree at their ends."""

    def hermite(a: float, b: float) -> np.ndarray:
        start, end = (np.array(flat(bezier.value(t))) for t in (a, b))
        slopes = [np.array(flat(bezier.getD1(t)[1])) * (b - a) / 3.0 for t in (a, b)]
        return np.column_stack([np.array([start, start + slopes[0], end - slopes[1], end]), np.ones(4)])

    parts = 1
    while True:
        knots = np.linspace(0.0, 1.0, parts + 1)
        segments = np.array([hermite(a, b) for a, b in itertools.pairwise(knots)])
        between = np.array([flat(bezier.value(t)) for t in np.linspace(0.0, 1.0, 4 * parts + 1)])
        if np.abs(points(segments, 4) - between).max() < APPROXIMATION_MM:
            return segments
        parts *= 2


def line(start: tuple[float, float], end: tuple[float, float]) -> np.ndarray:
    """Return the straight segment (1, 4, 3) from start to end (r, z)."""
    share = np.linspace(0.0, 1.0, 4)[:, None]
    return np.column_stack([(1.0 - share) * np.array(start) + share * np.array(end), np.ones(4)])[None]


def arc(centre: tuple[float, float], radius: float, start_rad: float, end_rad: float) -> np.ndarray:
    """Return the circular arc (n, 4, 3) about `centre` (r, z), exact, in pieces of at most a right angle."""
    pieces = max(1, int(np.ceil(abs(end_rad - start_rad) / (0.5 * np.pi) - 1e-9)))
    angles = np.linspace(start_rad, end_rad, pieces + 1)
    half = 0.5 * (angles[1] - angles[0])
    weight = np.cos(half)
    segments = []
    for a, b in itertools.pairwise(angles):
        ends = [np.array(centre) + radius * np.array([np.cos(t), np.sin(t)]) for t in (a, b)]
        middle = np.array(centre) + radius / weight * np.array([np.cos(0.5 * (a + b)), np.sin(0.5 * (a + b))])
        inner = (1.0 + 2.0 * weight) / 3.0
        controls = [(end + 2.0 * weight * middle) / (3.0 * inner) for end in ends]
        segments.append(np.column_stack([[ends[0], *controls, ends[1]], [1.0, inner, inner, 1.0]]))
    return np.array(segments)


def _right_of_axis(segments: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the segments, halved until no control point lies left of the axis."""
    for segment in segments:
        segment = segment.copy()
        ends = segment[[0, 3]]
        ends[np.abs(ends[:, 0]) < JOINT_MM, 0] = 0.0
        segment[[0, 3]] = ends
        if np.all(segment[:, 0] >= 0.0) or np.ptp(segment[:, :2], axis=0).max() < JOINT_MM:
            segment[:, 0] = np.maximum(segment[:, 0], 0.0)
            yield segment[None]
        else:
            yield from _right_of_axis(np.array(_halves(segment)))


def _halves(segment: np.ndarray) -> list[np.ndarray]:
    weighted = np.column_stack([segment[:, :2] * segment[:, 2:], segment[:, 2]])
    levels = [weighted]
    while len(levels[-1]) > 1:
        levels.append(0.5 * (levels[-1][:-1] + levels[-1][1:]))
    left = np.array([level[0] for level in levels])
    right = np.array([level[-1] for level in levels[::-1]])
    return [np.column_stack([half[:, :2] / half[:, 2:], half[:, 2]]) for half in (left, right)]
