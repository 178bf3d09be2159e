"""The tone curve between scene-referred radiance and an 8-bit picture: exposure, clipping, sRGB (IEC 61966-2-1)."""

from __future__ import annotations

import numpy as np

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Share of linear R, G and B (Rec. ITU-R BT.709) in the luminance."""

BAND = 64
"""Rows that are encoded at a time, so that a large picture needs little memory beside itself."""


def to_display(radiance: np.ndarray, exposure: float = 0.0) -> np.ndarray:
    """Return the uint8 picture of linear radiance: times 2 ** exposure, clipped to 0..1, sRGB encoded."""
    radiance = np.asarray(radiance)
    picture = np.empty(radiance.shape, dtype=np.uint8)
    for first in range(0, len(radiance), BAND):
        rows = slice(first, first + BAND)
        linear = np.clip(radiance[rows].astype(np.float64) * 2.0**exposure, 0.0, 1.0)
        encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
        picture[rows] = np.rint(255.0 * encoded)
    return picture


def from_display(encoded: np.ndarray, exposure: float = 0.0) -> np.ndarray:
    """Return the linear radiance of sRGB values in 0..1; what was clipped stays clipped."""
    encoded = np.asarray(encoded, dtype=np.float64)
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return linear * 2.0**-exposure


def luminance(radiance: np.ndarray) -> np.ndarray:
    """Return the luminance (h, w) of linear radiance (h, w, 3)."""
    return np.asarray(radiance, dtype=np.float64) @ np.array(LUMINANCE)
