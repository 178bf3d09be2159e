"""What came out: wall thickness against the thickness asked, volumes, weight, capacity, centre of gravity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.scene import Mesh
from glassworkbench.wall.bezier import evaluate, polyline
from glassworkbench.wall.distance import distance_to_polyline, nearest_on_mesh
from glassworkbench.wall.profile import WallMeridian
from glassworkbench.wall.revolved import clearance
from glassworkbench.wall.thickness import ThicknessOverHeight

SAMPLES = 3000
"""Points on the inner surface that are measured."""

CHORD_MM = 0.15
"""Length of the chords that stand for the outer meridian."""

DENSITY_G_PER_CM3 = 2.5
"""Of soda-lime container glass."""

SEED = 20240229


@dataclass(frozen=True, eq=False)
class WallMeasure:
    """How the wall came out.

    Parameters
    ----------
    samples : int
        Points measured, spread evenly over the inner surface by area. The lip and a stem are not wall.
    minimum_mm : float
    minimum_at_mm : array (3,)
        The inner point of the thinnest wall, upright.
    deviation_max_mm, deviation_p99_mm, deviation_rms_mm : float
        Of the distance to an outer point, from the thickness asked there.
    """

    samples: int
    minimum_mm: float
    minimum_at_mm: np.ndarray
    deviation_max_mm: float
    deviation_p99_mm: float
    deviation_rms_mm: float


@dataclass(frozen=True, eq=False)
class Volume:
    """Volume (mm^3) and centroid (3,) (mm) of a body."""

    volume_mm3: float
    centroid_mm: np.ndarray

    def minus(self, other: Volume) -> Volume:
        """Return this body without another that lies inside it."""
        volume = self.volume_mm3 - other.volume_mm3
        moment = self.volume_mm3 * self.centroid_mm - other.volume_mm3 * other.centroid_mm
        return Volume(volume, moment / volume)


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


def measure_mesh(
    outer: Mesh, cavity: Mesh, finish_height_mm: float, thickness: ThicknessOverHeight, samples: int = SAMPLES
) -> WallMeasure:
    """Measure a cavity against the outside in space, both upright; the cavity is closed at the finish plane.

    Points within one wall of the finish plane are left out: a lip's rounding makes the wall thinner there.
    """
    inside = _spread_on_mesh(cavity, samples)
    inside = inside[inside[:, 2] < finish_height_mm - thickness.maximum_mm]
    distance, feet = _distance_to_surface(inside, outer, finish_height_mm)
    return _summary(inside, distance, distance - thickness.at(feet[:, 2]))


def _distance_to_surface(points: np.ndarray, mesh: Mesh, finish_height_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Return distances to the surface behind a mesh, its mouth left out, and the nearest points."""
    corners = mesh.vertices_mm[mesh.triangles]
    walls = ~np.all(corners[:, :, 2] > finish_height_mm - 1e-4, axis=1)
    triangles = mesh.triangles[walls]
    feet, numbers, shares = nearest_on_mesh(points, corners[walls])
    height, normals = _bulge(mesh, triangles[numbers], shares)
    feet = feet + height[:, None] * normals
    return np.linalg.norm(points - feet, axis=1), feet


def _bulge(mesh: Mesh, triangles: np.ndarray, shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return how far (m,) the surface stands out from points of triangles, and its normals (m, 3) there.

    Notes
    -----
    Between two vertices i and j the surface turns by their normals' difference, so to second order it stands
    b_i b_j (n_j - n_i) . (p_j - p_i) / 2 above the chord at the barycentric coordinates b. So corrected it is as good
    as one with many times the triangles.
    """
    normals = np.einsum("ij,ijk->ik", shares, mesh.normals[triangles])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    height = np.zeros(len(triangles))
    for (i, j), sag in zip(_SIDES, _sags(mesh, triangles), strict=True):
        height += shares[:, i] * shares[:, j] * sag
    return height, normals


_SIDES = ((0, 1), (1, 2), (2, 0))


def _sags(mesh: Mesh, triangles: np.ndarray) -> list[np.ndarray]:
    points, normals = mesh.vertices_mm[triangles], mesh.normals[triangles]
    return [0.5 * np.einsum("ij,ij->i", normals[:, j] - normals[:, i], points[:, j] - points[:, i]) for i, j in _SIDES]


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
    distance, _ = _distance_to_surface(inside, outer, np.inf)
    thinnest = int(np.argmin(distance))
    return float(distance[thinnest]), inside[thinnest]


def revolved_volume(chain: np.ndarray) -> Volume:
    """Return the volume that a meridian chain (n, 4, 3) from axis to axis turns through.

    Notes
    -----
    V = pi int r^2 dz and V z_c = pi int r^2 z dz along the chain, by Gauss's rule with 16 points a segment.
    """
    nodes, weights = np.polynomial.legendre.leggauss(16)
    u, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    volume = moment = 0.0
    for segment in chain:
        points, slopes = evaluate(segment, u)
        slice_volume = np.pi * weights * points[:, 0] ** 2 * slopes[:, 1]
        volume += float(slice_volume.sum())
        moment += float(slice_volume @ points[:, 1])
    return Volume(volume, np.array([0.0, 0.0, moment / volume]))


def mesh_volume(mesh: Mesh) -> Volume:
    """Return the volume inside the surface behind a closed mesh.

    The divergence theorem gives that of the mesh; on each triangle the surface adds the mean of its bulge.
    """
    a, b, c = (mesh.vertices_mm[mesh.triangles[:, k]] for k in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    added = areas * sum(_sags(mesh, mesh.triangles)) / 12.0
    moment = volumes @ (a + b + c) / 4.0 + added @ (a + b + c) / 3.0
    volume = volumes.sum() + added.sum()
    return Volume(float(volume), moment / volume)


def weight_g(glass_volume_mm3: float) -> float:
    """Return the weight of a glass volume."""
    return DENSITY_G_PER_CM3 * 1e-3 * glass_volume_mm3


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


def _spread_on_mesh(mesh: Mesh, samples: int) -> np.ndarray:
    """Return points (samples, 3), spread evenly by area, the same at each call."""
    random = np.random.default_rng(SEED)
    a, b, c = (mesh.vertices_mm[mesh.triangles[:, k]] for k in range(3))
    area = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
    shares = (np.arange(samples) + random.random(samples)) / samples * area[-1]
    number = np.minimum(np.searchsorted(area, shares), len(area) - 1)
    u, v = random.random((2, samples))
    flip = u + v > 1.0
    u, v = np.where(flip, 1.0 - u, u), np.where(flip, 1.0 - v, v)
    shares = np.column_stack([1.0 - u - v, u, v])
    triangles = mesh.triangles[number]
    height, normals = _bulge(mesh, triangles, shares)
    return np.einsum("ij,ijk->ik", shares, mesh.vertices_mm[triangles]) + height[:, None] * normals


def _summary(points: np.ndarray, distance: np.ndarray, deviation: np.ndarray) -> WallMeasure:
    deviation = np.abs(deviation)
    thinnest = int(np.argmin(distance))
    return WallMeasure(
        samples=len(points),
        minimum_mm=float(distance[thinnest]),
        minimum_at_mm=points[thinnest],
        deviation_max_mm=float(deviation.max()),
        deviation_p99_mm=float(np.percentile(deviation, 99.0)),
        deviation_rms_mm=float(np.sqrt(np.mean(deviation**2))),
    )
