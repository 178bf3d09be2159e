"""The image of a camera: linear luminance, and whether there is anything to be judged in it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.images import files, from_display, luminance
from glassworkbench.settings import unknown_name

TONES = ("linear", "sRGB")
DEPTHS = (8, 10, 12, 14, 16)
"""Bits of a camera that an integer file of 16 bits may hold, at its lower or its upper end."""

BLANK_CONTRAST = 0.02
"""An image whose values differ by less than this, as a share of the largest, shows nothing."""


@dataclass(frozen=True, eq=False)
class CameraImage:
    """Linear luminance of a camera, in units of its own.

    Parameters
    ----------
    grey : array (h, w)
    saturated : array (h, w) of bool
        Pixels at full scale: they are at least as bright as they say.
    """

    grey: np.ndarray
    saturated: np.ndarray

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.grey.shape[1], self.grey.shape[0]


def read_camera_image(path: str | Path, tone: str | None = None) -> CameraImage:
    """Return the image of an 8, 10, 12, 14 or 16-bit PNG or TIFF file, or an EXR.

    Parameters
    ----------
    path : str or Path
    tone : str, optional
        ``"linear"`` or ``"sRGB"``; as its metadata say where not given, and linear where they say nothing.

    Raises
    ------
    InputError
        If the file is no image, is not finite, or blank.
    """
    if tone is not None and tone not in TONES:
        raise unknown_name("tone", tone, TONES)
    values, names, told, _ = files.read(path)
    bits = files.stored_bits(path)
    colours = [names.index(name) for name in "RGB"] if all(name in names for name in "RGB") else [0]
    values = values[:, :, colours]
    if not np.all(np.isfinite(values)):
        raise InputError(f"{path}: some of its pixels are not finite; save it as the camera gave it")
    saturated = np.any(values >= _full_scale(values, bits), axis=2)
    if (tone or told.get("tone_curve", "linear")) == "sRGB":
        values = from_display(values)
    grey = luminance(values) if len(colours) == 3 else values[:, :, 0]
    low, high = np.percentile(grey, (0.5, 99.5))
    if high <= 0.0 or high - low < BLANK_CONTRAST * high:
        raise InputError(
            f"{path}: the image is blank, its values are all about {high:.3g} of white; check light, exposure and cap"
        )
    return CameraImage(grey, saturated)


def _full_scale(values: np.ndarray, bits: int | None) -> float:
    """Return the value at which a pixel is saturated: the largest that the camera can give; infinite for floats."""
    if bits is None:
        return np.inf
    largest = 2**bits - 1
    top = round(float(values.max()) * largest)
    for depth in DEPTHS:
        full = 2**depth - 1
        # Cameras store 12 bits in 16 at the lower or at the upper end.
        if depth <= bits and top in (full, full << (bits - depth)):
            return top / largest
    return np.inf
