"""Where in a pixel its samples lie: the same points as ``native/sampling.hpp``, for the reference tracer."""

from __future__ import annotations

import numpy as np


def sample_points(pixels: np.ndarray, number: int) -> np.ndarray:
    """Return where sample `number` lies in each pixel.

    The first two dimensions of Sobol's sequence, shifted digitally by a hash of the pixel's number (splitmix64;
    Steele, Lea, Flood 2014): any first 4 ** k samples are stratified, and neighbouring pixels do not alias together.

    Parameters
    ----------
    pixels : int array (n,)
        Row-major numbers of pixels.
    number : int
        Which sample, from 0.

    Returns
    -------
    array (n, 2)
        Column and row within the pixel, in [0, 1).
    """
    shift = _hashed(np.asarray(pixels).astype(np.uint64))
    first = np.uint32(int(f"{number:032b}"[::-1], 2))
    second, direction = 0, 1 << 31
    while number:
        if number & 1:
            second ^= direction
        number >>= 1
        direction ^= direction >> 1
    bits = np.stack([shift.astype(np.uint32) ^ first, (shift >> np.uint64(32)).astype(np.uint32) ^ np.uint32(second)])
    return bits.T / 2.0**32


def _hashed(x: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore"):
        x = x + np.uint64(0x9E3779B97F4A7C15)
        x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))
