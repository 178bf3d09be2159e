"""Colour spaces: linear sRGB for screens, L*a*b* for differences."""

from __future__ import annotations

import numpy as np

_FROM_XYZ = np.array(
    [
        [3.2406255, -1.5372080, -0.4986286],
        [-0.9689307, 1.8757561, 0.0415175],
        [0.0557101, -0.2040211, 1.0569959],
    ]
)
"""IEC 61966-2-1:1999, with the digits of its amendment 1."""


def linear_srgb(xyz: np.ndarray) -> np.ndarray:
    """Return linear sRGB of X, Y, Z (..., 3) under D65; beyond 0 or 1 where a screen cannot show the colour."""
    return np.asarray(xyz) @ _FROM_XYZ.T


def lab(xyz: np.ndarray, white: np.ndarray) -> np.ndarray:
    """Return CIE L*, a*, b* (ISO/CIE 11664-4).

    Parameters
    ----------
    xyz : array (..., 3)
    white : array (3,)
        X, Y, Z of the illuminant, to the scale of `xyz`.
    """
    ratio = np.asarray(xyz, dtype=np.float64) / white
    knee = 6.0 / 29.0
    root = np.where(ratio > knee**3, np.cbrt(ratio), ratio / (3.0 * knee**2) + 4.0 / 29.0)
    x, y, z = np.moveaxis(root, -1, 0)
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=-1)
