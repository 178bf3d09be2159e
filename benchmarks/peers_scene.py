"""The bottle on which renderers were compared: a panel behind it, or a dim sky with bright soft boxes around it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

WIDTH, HEIGHT = 480, 640
FIELD_OF_VIEW_RAD = 2.0 * np.arctan(0.16)
REFRACTIVE_INDEX = 1.52
ABSORPTION_PER_MM = (0.02, 0.004, 0.015)
CAMERAS = {
    "panel": ((0.0, -1000.0, 150.0), (0.0, 0.0, 150.0)),
    "environment": ((0.0, -950.0, 450.0), (0.0, 0.0, 148.0)),
}
PANEL = ((-100.0, 100.0, -50.0), (200.0, 0.0, 0.0), (0.0, 0.0, 400.0))
MAP_SIZE = (1024, 2048)
SOFT_BOXES = (
    (-150.0, 20.0, 22.0, 35.0, (6.0, 6.0, 6.0)),
    (35.0, 25.0, 14.0, 40.0, (9.0, 8.4, 7.6)),
    (110.0, 10.0, 30.0, 12.0, (3.0, 3.2, 3.6)),
)
"""Azimuth and elevation of the middle, half width and half height in degrees, radiance."""


def meridian() -> np.ndarray:
    """Return the bottle's cubic segments (n, 4, 2), r and z in mm."""
    return np.loadtxt(Path(__file__).parent / "data" / "bottle_meridian.csv", delimiter=",").reshape(-1, 4, 2)


def sky(directions: np.ndarray) -> np.ndarray:
    """Return the radiance (..., 3) from unit directions (..., 3), z up."""
    half = np.clip(0.5 + 0.5 * directions[..., 2], 0.0, 1.0)
    mix = (half * half * (3.0 - 2.0 * half))[..., None]
    radiance = (1.0 - mix) * np.array([0.18, 0.17, 0.16]) + mix * np.array([0.75, 0.85, 1.0])
    azimuth = np.degrees(np.arctan2(directions[..., 1], directions[..., 0]))
    elevation = np.degrees(np.arcsin(np.clip(directions[..., 2], -1.0, 1.0)))
    for middle, height, half_width, half_height, colour in SOFT_BOXES:
        beside = np.abs((azimuth - middle + 180.0) % 360.0 - 180.0)
        inside = _soft_step(half_width - beside) * _soft_step(half_height - np.abs(elevation - height))
        radiance = radiance + inside[..., None] * np.array(colour)
    return radiance


def _soft_step(degrees: np.ndarray) -> np.ndarray:
    return 1.0 / (1.0 + np.exp(-np.clip(degrees, -900.0, 900.0) / 1.5))
