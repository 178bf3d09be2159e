"""The wall that came out, at many points of the inside, against the wall that was asked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.scene import Mesh
from glassworkbench.spatial import NearestTriangles
from glassworkbench.wall.measuring.outside import LIP_ZONE_MM, Outside
from glassworkbench.wall.measuring.surface import facets, spread
from glassworkbench.wall.turning.profile import FLOOR_ROUNDING

SAMPLES = 3000
"""Points on the inner surface that are measured."""

LEVEL_MM = 1e-4
"""What is this close to the finish plane lies in it."""

BEHIND_MM = 1e-3
"""Where embossing decides about the wall to this, the inner point lies behind it."""


@dataclass(frozen=True, eq=False)
class WallMeasure:
    """How the wall came out.

    Parameters
    ----------
    samples : int
        Points measured, spread evenly over the inner surface by area. The lip and a stem are not wall.
    minimum_mm : float
        The thinnest wall found anywhere: there, at the inside's vertices, and inward from the outside's.
    minimum_at_mm : array (3,)
        The inner point of the thinnest wall, upright.
    deviation_max_mm, deviation_p99_mm, deviation_rms_mm : float
        Of the distance to an outer point, from the thickness asked there; the largest anywhere, as the minimum.
    thinner_than_asked_max : float
        By which share of the thickness asked the wall is thinner where that is worst, anywhere; 0 if it is nowhere.
    """

    samples: int
    minimum_mm: float
    minimum_at_mm: np.ndarray
    deviation_max_mm: float
    deviation_p99_mm: float
    deviation_rms_mm: float
    thinner_than_asked_max: float = 0.0


@dataclass(frozen=True, eq=False)
class WallAtPoints:
    """The wall at points of the inside.

    Parameters
    ----------
    points_mm : array (n, 3)
        Upright.
    distance_mm : array (n,)
        To the outside: the thickness got.
    asked_mm : array (n,)
        At the outer point that decides.
    deviation_mm : array (n,)
        Above 0 where the wall, toward the outer point that decides, is thicker than asked. Where it is free that is no
        deviation: 0 there.
    free : bool array (n,)
        Where the wall may be thicker than asked: behind embossing, under a rounded lip and over a stem.
    """

    points_mm: np.ndarray
    distance_mm: np.ndarray
    asked_mm: np.ndarray
    deviation_mm: np.ndarray
    free: np.ndarray

    def below_lip(self, wall: Outside) -> np.ndarray:
        """Return which points (n,) a lip's rounding, which has no wall of its own, does not reach."""
        return self.points_mm[:, 2] < wall.lip_height_mm - self.asked_mm


def measure_wall(inside: Mesh, wall: Outside, *, stem_top_mm: float = 0.0, samples: int = SAMPLES) -> WallMeasure:
    """Measure the inside of a container against its outside, whatever made it.

    Where the thickness changes quickly, the outer point that decides is not the nearest one, but the one whose
    thickness reaches farthest in; the deviation is taken there, and is two-sided.

    Parameters
    ----------
    inside : Mesh
        The cavity, upright, closed level at the finish plane; its vertices, with their normals, lie on its surface.
    wall : Outside
    stem_top_mm : float
        `Anatomy.stem_top_mm`: below it the glass is solid, and the bowl's floor over it is a free choice.
    samples : int

    Raises
    ------
    GlassWorkbenchError
        If all of the inside lies in the finish plane or the lip.
    """
    found = wall_at(points_on_wall(inside, samples), wall, stem_top_mm=stem_top_mm)
    below_lip = found.below_lip(wall)
    if not np.any(below_lip):
        raise GlassWorkbenchError("the cavity does not reach below the lip; ask for a thinner wall")
    thin = wall_at(_thin_places(inside, wall), wall, stem_top_mm=stem_top_mm)
    thin_below_lip = thin.below_lip(wall)
    points, distance, deviation, asked = (
        np.concatenate([of_samples[below_lip], of_thin[thin_below_lip]])
        for of_samples, of_thin in (
            (found.points_mm, thin.points_mm),
            (found.distance_mm, thin.distance_mm),
            (found.deviation_mm, thin.deviation_mm),
            (found.asked_mm, thin.asked_mm),
        )
    )
    thinnest = int(np.argmin(distance))
    size = np.abs(found.deviation_mm[below_lip])
    return WallMeasure(
        samples=len(size),
        minimum_mm=float(distance[thinnest]),
        minimum_at_mm=points[thinnest],
        deviation_max_mm=float(np.abs(deviation).max()),
        deviation_p99_mm=float(np.percentile(size, 99.0)),
        deviation_rms_mm=float(np.sqrt(np.mean(size**2))),
        thinner_than_asked_max=float(max(0.0, np.max(-deviation / asked))),
    )


def _thin_places(inside: Mesh, wall: Outside) -> np.ndarray:
    """Return the points (n, 3) of the inside where samples may have missed that the wall is thinner than asked.

    They are the vertices that lie in the glass that was asked for, and what is nearest to the corners of the outside
    that have less than they ask, or least of all: a sharp edge comes nearest to a smooth inside, and the other way.
    """
    vertices = inside.vertices_mm[np.unique(inside.triangles[~in_finish_plane(inside)])]
    vertices = vertices[wall.clearance(vertices).clearance_mm < 0.0]
    outer, first = np.unique(wall.corners_mm[~wall.collar].reshape(-1, 3), axis=0, return_index=True)
    into = NearestTriangles(inside.vertices_mm[inside.triangles], inside.normals[inside.triangles]).search(outer)
    lacking = into.distance_mm < wall.thickness_mm[~wall.collar].ravel()[first]
    lacking[np.argmin(into.distance_mm)] = True
    return np.concatenate([vertices, into.feet_mm[lacking]])


def points_on_wall(inside: Mesh, count: int) -> np.ndarray:
    """Return points (count, 3) of the inner surface, evenly by area, without the plane that closes the mouth."""
    return spread(inside, ~in_finish_plane(inside), count)


def in_finish_plane(inside: Mesh) -> np.ndarray:
    """Return which triangles (m,) close a cavity at the finish plane."""
    corners = inside.vertices_mm[inside.triangles]
    return np.all(corners[:, :, 2] > inside.vertices_mm[:, 2].max() - LEVEL_MM, axis=1) & (facets(corners)[:, 2] > 0.0)


def wall_at(points_mm: np.ndarray, wall: Outside, *, stem_top_mm: float = 0.0) -> WallAtPoints:
    """Return the wall at points (n, 3) of the inside, upright."""
    decisive = wall.clearance(points_mm)
    asked = decisive.distance_mm - decisive.clearance_mm
    deviation = decisive.clearance_mm
    free = np.zeros(len(points_mm), dtype=bool)
    embossing = wall.embossing()
    if embossing is not None:
        free |= embossing.clearance(points_mm).clearance_mm <= deviation + BEHIND_MM
    if wall.lip_height_mm < wall.finish_height_mm - LEVEL_MM:
        # A rounded lip leaves less land to seal on than a thin wall needs: near it the wall may be thicker.
        free |= points_mm[:, 2] > wall.finish_height_mm - LIP_ZONE_MM - asked
    if stem_top_mm > 0.0:
        free |= decisive.feet_mm[:, 2] < _bowl_from(wall, stem_top_mm)
    deviation = np.where(free, np.minimum(deviation, 0.0), deviation)
    return WallAtPoints(points_mm, wall.distance(points_mm).distance_mm, asked, deviation, free)


def _bowl_from(wall: Outside, stem_top_mm: float) -> float:
    """Return the height above a stem from which on a round floor fits in: below it, no inside can follow the outside.

    A ball on the axis that touches the outside has the radius r / n_r, n_r the outward part of the normal there.
    """
    points, normals = wall.corners_mm.reshape(-1, 3), wall.normals.reshape(-1, 3)
    radius = np.hypot(points[:, 0], points[:, 1])
    outward = np.einsum("ij,ij->i", points[:, :2], normals[:, :2]) / np.maximum(radius, 1e-300)
    fits = radius >= FLOOR_ROUNDING * wall.thickness_mm.ravel() * np.maximum(outward, 0.0)
    fits &= (normals[:, 2] < 0.0) & (outward > 0.0) & (points[:, 2] >= stem_top_mm)
    return float(points[fits, 2].min()) if np.any(fits) else stem_top_mm
