"""Surfaces turned and moved."""

from __future__ import annotations

import numpy as np

from glassworkbench.scene.bodies import Ellipsoid, Revolved, Surface


def placed(surface: Surface, turn: np.ndarray, shift_mm: np.ndarray) -> Surface:
    """Return the surface turned by a rotation (3, 3) about the origin, then moved."""
    if isinstance(surface, Revolved):
        return Revolved(surface.meridian, shift_mm + turn @ surface.base_mm, turn @ surface.axis)
    if isinstance(surface, Ellipsoid):
        return Ellipsoid(shift_mm + turn @ surface.centre_mm, surface.semi_axes_mm, turn @ surface.rotation)
    return surface.placed(turn, shift_mm)


def rotation(axis: np.ndarray, angle_rad: float) -> np.ndarray:
    """Return the matrix (3, 3) of Rodrigues' rotation about a unit vector."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle_rad) * cross + (1.0 - np.cos(angle_rad)) * cross @ cross
