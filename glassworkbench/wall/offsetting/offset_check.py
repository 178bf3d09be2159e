"""Whether an offset by OCC is what it claims to be: it can be valid, closed, and wrong."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import Part
from glassworkbench.spatial import NearestTriangles

SAMPLES = 250
"""Points of the inside that are compared with the outside, and the other way round."""

COLUMNS_PER_SIDE, POINTS_PER_COLUMN = 11, 5
"""Points in the body, from which the cavity's volume is estimated."""

WALL_SHARE, GOOD_SHARE = 0.04, 0.95
"""The wall must be right within this share of it, on this share of the samples."""

THINNEST_SHARE = 0.93
"""Nowhere below the lip may the wall be thinner than this share of what was asked."""

VOLUME_SHARE = 0.08
"""How well the cavity's volume must agree with the estimate, whose own error is about half of this."""

FACET_SHARE, FACET_MM = 0.05, 0.1
"""Deviation of the meshes that stand for the surfaces: this share of the wall, at most this."""

SEED = 20240229


def check_solid(solid: Part.Shape) -> None:
    """Raise if a solid is not one valid closed body, or crosses itself.

    Raises
    ------
    GlassWorkbenchError
        In a designer's words.
    """
    if len(solid.Shells) != 1 or not solid.isValid() or not solid.Shells[0].isClosed():
        raise GlassWorkbenchError("the cavity is not a valid closed solid")
    try:
        solid.check(True)
    except ValueError as error:
        crosses = "SelfIntersect" in str(error)
        raise GlassWorkbenchError(f"the offset surface {'crosses itself' if crosses else 'is faulty'}") from error


def check_offset(
    outer: Part.Shape, cavity: Part.Shape, finish_height_mm: float, thickness_mm: float, lip_height_mm: float
) -> None:
    """Raise if a cavity is not the offset of an outside by a thickness.

    Parameters
    ----------
    outer, cavity : Part.Shape
        Upright solids; the cavity ends at the finish plane.
    finish_height_mm, thickness_mm : float
    lip_height_mm : float
        Within this height of the finish the bore may run straight behind a rounded lip.

    Raises
    ------
    GlassWorkbenchError
        If the cavity's surface is not a wall away from the outside, if a part of the outside has no wall behind it, or
        if the cavity's volume is not that of the points of the body that are a wall away from the outside.
    """
    deviation = min(FACET_SHARE * thickness_mm, FACET_MM)
    outside, inside = facets(outer, deviation), facets(cavity, deviation)
    walls = outside[~np.all(outside[:, :, 2] > finish_height_mm - 1e-4, axis=1)]
    below_lip = finish_height_mm - lip_height_mm
    slack = WALL_SHARE * thickness_mm + deviation

    points, _ = _spread(inside)
    points = points[points[:, 2] < below_lip]
    distance = _distance(points, walls)
    if np.mean(np.abs(distance - thickness_mm) > slack) > 1.0 - GOOD_SHARE:
        raise GlassWorkbenchError("the offset's wall is not what was asked")
    if len(distance) and distance.min() < THINNEST_SHARE * thickness_mm - deviation:
        raise GlassWorkbenchError(f"the offset's wall is as thin as {distance.min():.2f} mm")

    points, normals = _spread(outside)
    points = (points - thickness_mm * normals)[points[:, 2] < below_lip]
    due = points[_distance(points, walls) > thickness_mm - deviation - 1e-3 * thickness_mm]
    due = due[due[:, 2] < below_lip]
    if len(due) and np.mean(_distance(due, inside) > slack) > 1.0 - GOOD_SHARE:
        raise GlassWorkbenchError("the offset leaves out a part of the inside")

    volume, estimate = facets_volume(inside), _estimate(outside, walls, finish_height_mm, thickness_mm)
    if abs(volume - estimate) > VOLUME_SHARE * estimate:
        raise GlassWorkbenchError(f"the cavity holds {1e-3 * volume:.1f} ml, where {1e-3 * estimate:.1f} ml must be")


def check_faces(
    outer: Part.Shape, cavity: Part.Shape, finish_face: int, thicknesses_mm: Sequence[float], lip_height_mm: float
) -> None:
    """Raise unless a cavity leaves each face of the outside its own wall.

    Parameters
    ----------
    outer, cavity : Part.Shape
        Upright solids; the cavity ends at the finish plane.
    finish_face : int
        1-based number of the planar face at the mouth.
    thicknesses_mm : sequence of float
        Of each face of the outside, in their order.
    lip_height_mm : float
        As in `check_offset`.

    Raises
    ------
    GlassWorkbenchError
        If a face has less than its wall, or a part of the inside is farther than it must be from all faces.
    """
    thinnest = min(thicknesses_mm)
    deviation = min(FACET_SHARE * thinnest, FACET_MM)
    points, _ = _spread(facets(cavity, deviation))
    points = points[points[:, 2] < outer.Faces[finish_face - 1].CenterOfMass.z - lip_height_mm]
    excess = np.full(len(points), np.inf)
    for number, (face, thickness) in enumerate(zip(outer.Faces, thicknesses_mm, strict=True), start=1):
        if number != finish_face:
            excess = np.minimum(excess, _distance(points, facets(face, deviation)) - thickness)
    if len(excess) and excess.min() < -(1.0 - THINNEST_SHARE) * thinnest - deviation:
        raise GlassWorkbenchError(f"a face's wall is {-excess.min():.2f} mm thinner than what was asked")
    if np.mean(excess > WALL_SHARE * thinnest + deviation) > 1.0 - GOOD_SHARE:
        raise GlassWorkbenchError("a face's wall is thicker than what was asked")


def facets(solid: Part.Shape, deviation_mm: float) -> np.ndarray:
    """Return the corners (m, 3, 3) of the triangles of a solid's mesh, turned as its faces are."""
    vertices, triangles = solid.copy(True, False).tessellate(deviation_mm)
    if not triangles:
        raise GlassWorkbenchError("the offset is empty")
    return np.array([tuple(vertex) for vertex in vertices])[np.array(triangles)]


def facets_volume(corners: np.ndarray) -> float:
    """Return the volume within closed facets (m, 3, 3), negative if they are turned inward.

    OCC's own volume can be wrong by a factor on long faces.
    """
    a, b, c = (corners[:, k] - corners[0, 0] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def _distance(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    # Without normals the triangles are flat.
    return NearestTriangles(corners, np.zeros_like(corners)).search(points).distance_mm


def _spread(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points (SAMPLES, 3) of facets, spread evenly by area, and the unit normals there."""
    random = np.random.default_rng(SEED)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(normals, axis=1)
    area = np.cumsum(doubled)
    places = (np.arange(SAMPLES) + random.random(SAMPLES)) / SAMPLES * area[-1]
    numbers = np.minimum(np.searchsorted(area, places), len(area) - 1)
    shares = random.dirichlet([1.0, 1.0, 1.0], SAMPLES)
    return np.einsum("ij,ijk->ik", shares, corners[numbers]), normals[numbers] / doubled[numbers, None]


def _estimate(outside: np.ndarray, walls: np.ndarray, finish_height_mm: float, thickness_mm: float) -> float:
    """Return the volume (mm^3) of the points that lie inside, a wall away from the outside.

    Vertical lines, one in each cell of a grid, are cut with the mesh; points are spread over what lies inside.
    """
    random = np.random.default_rng(SEED)
    low, high = outside.min(axis=(0, 1)), outside.max(axis=(0, 1))
    side = COLUMNS_PER_SIDE
    cells = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)
    places = low[:2] + (cells + random.random(cells.shape)) / side * (high - low)[:2]
    smallest, largest = outside[:, :, :2].min(axis=1), outside[:, :, :2].max(axis=1)
    points, lengths = [], []
    for place in places:
        near = np.all((smallest <= place) & (place <= largest), axis=1)
        heights = np.sort(_heights(outside[near], place))
        for bottom, top in zip(heights[0::2], np.minimum(heights[1::2], finish_height_mm), strict=False):
            shares = (np.arange(POINTS_PER_COLUMN) + random.random(POINTS_PER_COLUMN)) / POINTS_PER_COLUMN
            z = bottom + shares * (top - bottom)
            points.append(np.column_stack([np.tile(place, (len(z), 1)), z]))
            lengths.append(np.full_like(z, (top - bottom) / POINTS_PER_COLUMN))
    inside = _distance(np.concatenate(points), walls) > thickness_mm
    return float(np.concatenate(lengths)[inside].sum() * np.prod((high - low)[:2]) / side**2)


def _heights(corners: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return where the vertical line through a place (x, y) crosses triangles (m, 3, 3)."""
    a, b, c = (corners[:, k] for k in range(3))
    ab, ac, ap = b - a, c - a, place - a[:, :2]
    doubled = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        v = (ap[:, 0] * ac[:, 1] - ap[:, 1] * ac[:, 0]) / doubled
        w = (ab[:, 0] * ap[:, 1] - ab[:, 1] * ap[:, 0]) / doubled
        hit = (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0)
        return (a[:, 2] + v * ab[:, 2] + w * ac[:, 2])[hit]
