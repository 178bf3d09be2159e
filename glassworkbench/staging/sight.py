"""Whether a station's camera sees the container at all: asked before the rendering."""

from __future__ import annotations

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene import Camera, ContainerGeometry, Light, Panel
from glassworkbench.staging.directions import corners
from glassworkbench.staging.pose import Pose

GRID = 96
"""Rays along each side of the image that look for the container."""


def check_sight(
    camera: Camera, size: tuple[int, int], geometry: ContainerGeometry, pose: Pose, lights: tuple[Light, ...]
) -> None:
    """Check that some ray of the image meets the box around the container before any panel.

    Raises
    ------
    InputError
        If none does; tells whether the container is out of the picture or hidden.
    """
    box = corners(geometry, "all", "camera")
    steps = (np.arange(GRID) + 0.5) / GRID
    x, y = np.meshgrid((2.0 * steps - 1.0) * size[0] / size[1], 1.0 - 2.0 * steps)
    origins, directions = camera.rays(x.ravel(), y.ravel())
    # The box is upright in the container's own coordinates.
    near, met = _meet_box(
        (origins - np.array(pose.offset_mm)) @ pose.turn, directions @ pose.turn, box.min(axis=0), box.max(axis=0)
    )
    if not np.any(met):
        raise InputError(
            "camera: it does not see the container, which lies outside the image or behind it; aim at it, move it "
            "away, or take a shorter focal length"
        )
    blocked = np.zeros(len(near), dtype=bool)
    for light in lights:
        if isinstance(light, Panel):
            blocked |= _distance(light, origins, directions) < near
    if np.all(blocked[met]):
        raise InputError("camera: a light stands between it and the container; move the light or the camera")


def _meet_box(
    origins: np.ndarray, directions: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return where rays (n, 3) enter a box, and which meet it in front of them."""
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (low - origins) / directions, (high - origins) / directions
    near = np.fmax.reduce(np.fmin(first, second), axis=1)
    far = np.fmin.reduce(np.fmax(first, second), axis=1)
    return np.maximum(near, 0.0), (near <= far) & (far > 0.0)


def _distance(panel: Panel, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return where rays (n, 3) meet a panel, infinity where they do not."""
    normal = np.cross(panel.u_mm, panel.v_mm)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (panel.origin_mm - origins) @ normal / (directions @ normal)
        place = origins + distance[:, None] * directions - panel.origin_mm
        across = np.cross(place, panel.v_mm) @ normal / (normal @ normal)
        along = np.cross(panel.u_mm, place) @ normal / (normal @ normal)
    inside = (across >= 0.0) & (across <= 1.0) & (along >= 0.0) & (along <= 1.0) & (distance > 0.0)
    return np.where(inside, distance, np.inf)
