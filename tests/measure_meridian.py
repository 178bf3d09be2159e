"""What came out of a revolved cavity, measured on its exact meridian, in the half-plane."""

from __future__ import annotations

import numpy as np
from polyline_distance import distance_to_polyline

from glassworkbench.scene import Mesh
from glassworkbench.spatial import NearestTriangles
from glassworkbench.wall.asking.thickness import ThicknessOverHeight
from glassworkbench.wall.measuring.measure import SAMPLES, WallMeasure
from glassworkbench.wall.methods.revolved import clearance
from glassworkbench.wall.turning.bezier import polyline
from glassworkbench.wall.turning.profile import WallMeridian

CHORD_MM = 0.15
"""Length of the chords that stand for the outer meridian."""


def measure_revolved(wall: WallMeridian, cavity: np.ndarray, thickness: ThicknessOverHeight) -> WallMeasure:
    """Measure a revolved cavity, closed by its last segment (n, 4, 3), in the meridian half-plane.

    Where the thickness changes quickly, the outer point that decides is not the nearest one, but the one whose
    thickness reaches farthest in; the deviation is taken there. Points that face the round floor above a stem, or the
    mouth, have no wall before them and are left out.
    """
    inside = _spread_on_meridian(cavity[:-1])
    distance, deviation = np.full((2, len(inside)), np.inf)
    elsewhere = distance_to_polyline(inside, _above_lip(wall, thickness))[0]
    for segment, is_underside, is_outside in zip(wall.segments, wall.underside, wall.outside, strict=True):
        outline = polyline(segment[None], _chords(segment))
        gap, feet = distance_to_polyline(inside, outline)
        if is_outside:
            distance = np.minimum(distance, gap)
            deviation = np.minimum(deviation, gap - thickness.at(feet[:, 1], is_underside))
            if thickness.uniform_mm is None:
                asked = thickness.at(outline[:, 1], is_underside)
                deviation = np.minimum(deviation, clearance(inside, outline, asked))
        else:
            elsewhere = np.minimum(elsewhere, gap)
    mine = distance <= elsewhere + 1e-9
    points = np.column_stack([inside[:, 0], np.zeros(len(inside)), inside[:, 1]])
    return _summary(points[mine], distance[mine], deviation[mine])


def clearance_to_mesh(
    outer: Mesh, cavity: np.ndarray, up_to_height_mm: float, samples: int = 500
) -> tuple[float, np.ndarray]:
    """Return the smallest distance from a revolved cavity (n, 4, 3) to an outside that is not round, and where it is.

    Points are taken below a height; they turn about the axis by the golden angle from one to the next.
    """
    profile = _spread_on_meridian(cavity[:-1])
    profile = profile[profile[:, 1] < up_to_height_mm]
    profile = profile[np.linspace(0, len(profile) - 1, samples).astype(int)]
    angle = np.arange(len(profile)) * np.pi * (3.0 - np.sqrt(5.0))
    inside = np.column_stack([profile[:, 0] * np.cos(angle), profile[:, 0] * np.sin(angle), profile[:, 1]])
    outside = NearestTriangles(outer.vertices_mm[outer.triangles], outer.normals[outer.triangles])
    distance = outside.search(inside).distance_mm
    thinnest = int(np.argmin(distance))
    return float(distance[thinnest]), inside[thinnest]


def _chords(segment: np.ndarray) -> int:
    """Return how many chords follow a segment to about a micrometre, unless it bends more sharply than a fillet."""
    legs = np.linalg.norm(np.diff(segment[:, :2], axis=0), axis=1)
    return int(np.clip(legs.sum() / CHORD_MM, 32, 1024))


def _above_lip(wall: WallMeridian, thickness: ThicknessOverHeight) -> np.ndarray:
    rise = wall.finish_height_mm - wall.lip[1] + 2.0 * thickness.maximum_mm
    # The lip itself is outside; a step away from it lies what is no longer.
    return wall.lip + np.array([[1e-6], [rise]]) * wall.lip_direction


def _spread_on_meridian(chain: np.ndarray) -> np.ndarray:
    """Return points (r, z) that split the area turned through into equal parts."""
    points = polyline(chain, 4096)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    area = np.concatenate([[0.0], np.cumsum(steps * 0.5 * (points[:-1, 0] + points[1:, 0]))])
    shares = (np.arange(SAMPLES) + 0.5) / SAMPLES * area[-1]
    # Chords between the points would lie off the curve: take the curve's own points nearest to each share.
    return points[np.unique(np.searchsorted(area, shares))]


def _summary(points: np.ndarray, distance: np.ndarray, deviation: np.ndarray) -> WallMeasure:
    thinner = float(max(0.0, np.max(-deviation / (distance - deviation))))
    deviation = np.abs(deviation)
    thinnest = int(np.argmin(distance))
    return WallMeasure(
        samples=len(points),
        minimum_mm=float(distance[thinnest]),
        minimum_at_mm=points[thinnest],
        deviation_max_mm=float(deviation.max()),
        deviation_p99_mm=float(np.percentile(deviation, 99.0)),
        deviation_rms_mm=float(np.sqrt(np.mean(deviation**2))),
        thinner_than_asked_max=thinner,
    )
