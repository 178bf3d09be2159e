"""Directions in station coordinates, and the part of a container that something looks at."""

from __future__ import annotations

import itertools

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene import ContainerGeometry, Mesh, Patches, Revolved
from glassworkbench.settings import unknown_name

VIEWS = ("all", "finish", "base")

END_SHARE = 0.06
"""Part of the height that finish and base are taken to have where only one of them is looked at."""


def towards(azimuth_deg: float, elevation_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the unit vectors (3,) to where something stands, and upwards along its meridian.

    Azimuth counts from +x towards +y. Both are rounded: what stands at -90 degrees has x = 0 exactly, or a scene would
    miss its mirror symmetry by 1e-14.
    """
    azimuth, elevation = np.radians([azimuth_deg, elevation_deg])
    outwards = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    there = np.cos(elevation) * outwards + np.array([0.0, 0.0, np.sin(elevation)])
    up = -np.sin(elevation) * outwards + np.array([0.0, 0.0, np.cos(elevation)])
    return np.round(there, 15), np.round(up, 15)


def corners(geometry: ContainerGeometry, view: str, where: str) -> np.ndarray:
    """Return the corners (n, 3) of a box around what is looked at: all of the container, its finish or its base.

    Raises
    ------
    InputError
        If the view is not known; `where` it is asked goes before the message.
    """
    if view not in VIEWS:
        raise unknown_name(f"{where}: view", view, VIEWS)
    low, high = geometry.low_mm, geometry.high_mm
    if view == "all":
        return np.array(list(itertools.product(*zip(low, high, strict=True))))
    finish = geometry.finish_height_mm
    bottom, top = (0.0, END_SHARE * finish) if view == "base" else ((1.0 - END_SHARE) * finish, finish)
    radius = _radius_between(geometry, bottom, top)
    height = bottom if view == "base" else top
    return np.array([(x, y, height) for x in (-radius, radius) for y in (-radius, radius)])


def _radius_between(geometry: ContainerGeometry, bottom_mm: float, top_mm: float) -> float:
    """Return the largest distance of the outside from the axis between two heights."""
    surface = geometry.outer
    if isinstance(surface, Revolved):
        r, z = along_meridian(surface.meridian)
    elif isinstance(surface, Mesh | Patches):
        mesh = surface.mesh if isinstance(surface, Patches) else surface
        r, z = np.hypot(mesh.vertices_mm[:, 0], mesh.vertices_mm[:, 1]), mesh.vertices_mm[:, 2]
    else:
        raise InputError(f"container: {type(surface).__name__} is no outside that a station can measure")
    inside = (z >= bottom_mm) & (z <= top_mm) & (r > 0.0)
    return float(r[inside].max()) if np.any(inside) else float(r.max())


def along_meridian(meridian: np.ndarray, points: int = 33) -> tuple[np.ndarray, np.ndarray]:
    """Return r and z (mm, in a row each) of points along a meridian, `points` to a segment."""
    u = np.linspace(0.0, 1.0, points)
    basis = np.stack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
    weights = meridian[:, :, 2] @ basis
    r, z = ((meridian[:, :, k] * meridian[:, :, 2]) @ basis / weights for k in (0, 1))
    return r.ravel(), z.ravel()
