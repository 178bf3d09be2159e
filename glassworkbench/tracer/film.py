"""What a rendering has gathered so far, pixel by pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SAMPLES = (1, 4, 16, 64, 256, 1024)
"""How many samples a pixel may hold: powers of four fill the strata of the sampling sequence."""

FEW_SAMPLES = 4
"""Up to here a pixel's neighbours are asked, too, whether an edge may run through it."""

DEEPEST = 4
"""How often a pixel's cut-off may be made smaller."""


@dataclass(frozen=True, eq=False)
class Work:
    """Pixels that hold equally many samples at the same cut-off, and how many they shall hold.

    Parameters
    ----------
    pixels : int64 array (n,)
    samples : int
        How many afterwards.
    depth : int
        How often the cut-off was made smaller for them.
    afresh : bool
        Whether they start again from no samples, since their cut-off changed.
    """

    pixels: np.ndarray
    samples: int
    depth: int
    afresh: bool


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
    depth : int64 array (pixels,)
        How often the pixel's cut-off was made smaller.
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
        self.depth = np.zeros(pixels, dtype=np.int64)
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

    def work(self, tolerance: float) -> list[Work]:
        """Return what to trace next so that each pixel's error comes below the tolerance; empty when done.

        Half of the tolerance is for what is left out: a pixel that exceeds it starts again with a smaller cut-off while
        it is cheap, that is, while it holds few samples. The rest is for sampling.
        """
        if self.rays == 0:
            return [Work(np.arange(self.samples.size), SAMPLES[0], 0, False)]
        pruned = self.pruned()
        deeper = (pruned > 0.5 * tolerance) & (self.depth < DEEPEST) & (self.samples <= SAMPLES[2])
        finer = (self.sampling() > np.maximum(tolerance - pruned, 0.5 * tolerance)) & (self.samples < SAMPLES[-1])
        groups = []
        for afresh, chosen in ((True, deeper), (False, finer & ~deeper)):
            for samples in SAMPLES:
                for depth in range(DEEPEST + 1):
                    pixels = np.flatnonzero(chosen & (self.samples == samples) & (self.depth == depth))
                    if len(pixels) == 0:
                        continue
                    if afresh:
                        groups.append(Work(pixels, samples, depth + 1, True))
                    else:
                        groups.append(Work(pixels, SAMPLES[SAMPLES.index(samples) + 1], depth, False))
        return groups

    def prepare(self, work: Work) -> None:
        """Forget the samples of pixels that start again."""
        if not work.afresh:
            return
        pixels = work.pixels
        self.sum[pixels] = 0.0
        self.low[pixels], self.high[pixels] = np.inf, -np.inf
        self.bound[pixels] = 0.0
        self.samples[pixels] = 0
        self.depth[pixels] = work.depth


def _dilated(values: np.ndarray, combine: np.ufunc) -> np.ndarray:
    """Return each pixel's extreme over itself and its eight neighbours, for (h, w, 3) values."""
    for axis in (0, 1):
        padded = np.pad(values, [(1, 1) if a == axis else (0, 0) for a in range(3)], mode="edge")
        count = values.shape[axis]
        parts = [np.take(padded, range(k, k + count), axis=axis) for k in range(3)]
        values = combine(combine(parts[0], parts[1]), parts[2])
    return values
