"""What a rendering has gathered so far, pixel by pixel."""

from __future__ import annotations

import numpy as np


class Film:
    """Sums of samples, from which the image and its error estimate follow.

    Parameters
    ----------
    width, height : int
        In pixels; arrays are row-major over pixels.

    Attributes
    ----------
    sum, low, high : array (pixels, 3)
        Sum, smallest and largest of the samples' radiance.
    bound : array (pixels,)
        Sum of the samples' bounds on what was left out.
    depth_mm : array (pixels,)
    samples : int64 array (pixels,)
    rays, crossings, leaks : int
    """

    def __init__(self, width: int, height: int) -> None:
        pixels = width * height
        self.width, self.height = width, height
        self.sum = np.zeros((pixels, 3))
        self.low = np.full((pixels, 3), np.inf)
        self.high = np.full((pixels, 3), -np.inf)
        self.bound = np.zeros(pixels)
        self.depth_mm = np.full(pixels, np.inf)
        self.samples = np.zeros(pixels, dtype=np.int64)
        self.rays = self.crossings = self.leaks = 0

    def add_totals(self, rays: int, crossings: int, leaks: int) -> None:
        """Count traced camera rays, crossings and leaks."""
        self.rays += int(rays)
        self.crossings += int(crossings)
        self.leaks += int(leaks)

    def mean(self) -> np.ndarray:
        """Return the mean radiance (pixels, 3)."""
        return self.sum / np.maximum(self.samples, 1)[:, None]

    def pruned(self) -> np.ndarray:
        """Return the bound on what was left out of each pixel (pixels,)."""
        return self.bound / np.maximum(self.samples, 1)

    def sampling(self) -> np.ndarray:
        """Return the estimated sampling error of each pixel (pixels,).

        An edge of height h through a pixel, sampled by n points of a (0, 2)-sequence, leaves about h n^(-3/4) / 2:
        of order sqrt(n) of the n strata are cut, each errs by a fraction of h / n at random (Mitchell 1996). The
        height is the range of the samples; while they are few, also that of the neighbours', which may have met
        the edge that this pixel's samples missed.
        """
        shape = (self.height, self.width, 3)
        low, high = self.low.reshape(shape), self.high.reshape(shape)
        own = np.max(high - low, axis=2).ravel()
        around = np.max(_dilated(high, np.maximum) - _dilated(low, np.minimum), axis=2).ravel()
        height = np.where(self.samples <= FEW_SAMPLES, around, own)
        return 0.5 * height * np.maximum(self.samples, 1) ** -0.75


FEW_SAMPLES = 4


def _dilated(values: np.ndarray, combine: np.ufunc) -> np.ndarray:
    """Return each pixel's extreme over itself and its eight neighbours, for (h, w, 3) values."""
    for axis in (0, 1):
        padded = np.pad(values, [(1, 1) if a == axis else (0, 0) for a in range(3)], mode="edge")
        count = values.shape[axis]
        parts = [np.take(padded, range(k, k + count), axis=axis) for k in range(3)]
        values = combine(combine(parts[0], parts[1]), parts[2])
    return values
