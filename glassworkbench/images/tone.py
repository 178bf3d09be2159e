"""The tone curve between scene-referred radiance and an 8-bit picture: exposure, clipping, sRGB (IEC 61966-2-1)."""

from __future__ import annotations

import numpy as np


def to_display(radiance: np.ndarray, exposure: float = 0.0) -> np.ndarray:
    """Return the uint8 picture of linear radiance: times 2 ** exposure, clipped to 0..1, sRGB encoded."""
    linear = np.clip(np.asarray(radiance, dtype=np.float64) * 2.0**exposure, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return np.rint(255.0 * encoded).astype(np.uint8)


def from_display(encoded: np.ndarray, exposure: float = 0.0) -> np.ndarray:
    """Return the linear radiance of sRGB values in 0..1; what was clipped stays clipped."""
    encoded = np.asarray(encoded, dtype=np.float64)
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return linear * 2.0**-exposure
