"""The glass of a container, asked where it begins and ends along lines."""

from __future__ import annotations

import numpy as np

from glassworkbench.flaws.defect import Grain, Site, Thread
from glassworkbench.scene import Body, ContainerGeometry, Medium, Pinhole, Scene
from glassworkbench.tracer import native, reference

NEARBY_MM = 0.02
"""From the point whose normal is asked to the points around that tell it."""

STEP_MM = 1e-6
"""Past a surface, where a ray starts anew."""

LINES = 96
"""From the middle of a defect to points all around on it, to see whether it leaves the glass."""


class GlassWall:
    """Where the glass of a container is; exact, and for many lines at once.

    Parameters
    ----------
    geometry : ContainerGeometry
    """

    def __init__(self, geometry: ContainerGeometry) -> None:
        bodies = [Body("outer", geometry.outer)]
        if geometry.cavity is not None:
            bodies.append(Body("cavity", geometry.cavity))
        self.has_cavity = geometry.cavity is not None
        # Of index 1, glass is met without bending a ray.
        where = "outer and not cavity" if self.has_cavity else "outer"
        scene = Scene(bodies, (Medium(where, 1.0, (1.0, 1.0, 1.0)),), (), Pinhole((0, -1, 0), (0, 0, 0), 0.5), (1, 1))
        self._radiance = native.NativeScene(scene).radiance if native.available() else _reference(scene)
        self._far_mm = 2.0 * float(np.linalg.norm(np.abs([geometry.low_mm, geometry.high_mm]).max(axis=0)))

    def sites(self, heights_mm: np.ndarray, angles_deg: np.ndarray) -> list[Site | None]:
        """Return where the wall is at heights and angles (n,); None where there is no glass towards the axis."""
        angles = np.radians(np.asarray(angles_deg, dtype=np.float64))
        outward = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
        across = np.column_stack([-outward[:, 1], outward[:, 0], np.zeros(len(angles))])
        up = np.array([0.0, 0.0, 1.0])
        axis = np.asarray(heights_mm, dtype=np.float64)[:, None] * up

        def outside(offset: np.ndarray) -> np.ndarray:
            origins = axis + self._far_mm * outward + offset
            return origins - self._first_mm(origins, -outward)[:, None] * outward

        # Where there is no glass, what follows from infinite distances is NaN.
        with np.errstate(invalid="ignore"):
            place = outside(np.zeros(3))
            tangents = [outside(NEARBY_MM * way) - outside(-NEARBY_MM * way) for way in (across, up)]
            normals = np.cross(*tangents)
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        known = np.flatnonzero(np.all(np.isfinite(place), axis=1) & np.all(np.isfinite(normals), axis=1))
        walls = self._first_mm(place[known] - STEP_MM * normals[known], -normals[known]) + STEP_MM
        sites: list[Site | None] = [None] * len(place)
        for k, wall in zip(known, walls, strict=True):
            along = np.cross(up, normals[k])
            along = across[k] if np.linalg.norm(along) < 1e-6 else along / np.linalg.norm(along)
            frame = np.column_stack([along, np.cross(normals[k], along), normals[k]])
            if np.isfinite(wall):
                sites[k] = Site(place[k], frame, float(wall))
        return sites

    def holds(self, grains: list[Grain]) -> np.ndarray:
        """Tell of ellipsoids whose centres lie in the glass whether all of each does, (n,)."""
        if not grains:
            return np.zeros(0, dtype=bool)
        sphere = _sphere(LINES)
        arms = np.array([grain.rotation * grain.semi_axes_mm for grain in grains])
        reach = np.einsum("nij,kj->nki", arms, sphere)
        lengths = np.linalg.norm(reach, axis=2)
        centres = np.repeat([grain.centre_mm for grain in grains], LINES, axis=0)
        first = self._first_mm(centres, (reach / lengths[:, :, None]).reshape(-1, 3))
        return np.all(first.reshape(lengths.shape) > lengths, axis=1)

    def roots(self, thread: Thread) -> bool:
        """Tell whether the ends of a thread lie in the glass to their rims."""
        angles = np.linspace(0.0, 2.0 * np.pi, LINES, endpoint=False)
        axis = thread.surface.axis
        aside = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        aside /= np.linalg.norm(aside)
        ring = np.cos(angles)[:, None] * aside + np.sin(angles)[:, None] * np.cross(axis, aside)
        starts = np.repeat(thread.roots_mm, LINES, axis=0)
        return bool(np.all(self._first_mm(starts, np.tile(ring, (len(thread.roots_mm), 1))) > thread.root_radius_mm))

    def _first_mm(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Return how far it is to the first face of the glass, (n,); infinite where there is none."""
        return self._radiance(np.ascontiguousarray(origins), np.ascontiguousarray(directions)).depth_mm


def _reference(scene: Scene) -> object:
    return lambda origins, directions: reference.radiance(scene, origins, directions)


def _sphere(count: int) -> np.ndarray:
    """Return the ends of the axes and points spread evenly (a golden spiral), on the unit sphere, (count, 3)."""
    k = np.arange(count - 6) + 0.5
    z, turn = 1.0 - 2.0 * k / (count - 6), np.pi * (1.0 + np.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z * z)
    spiral = np.column_stack([r * np.cos(turn), r * np.sin(turn), z])
    return np.concatenate([np.eye(3), -np.eye(3), spiral])
