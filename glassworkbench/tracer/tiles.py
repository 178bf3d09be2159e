"""Tiles of the image: the shares of work, numbered row by row."""

from __future__ import annotations

import numpy as np

TILE_SIZE = 32
"""Pixels along a tile; the native core's ``Cells::tile_size``."""


def tile_count(width: int, height: int) -> int:
    """Return how many tiles cover an image."""
    return -(-width // TILE_SIZE) * -(-height // TILE_SIZE)


def tiles_of(wanted: np.ndarray) -> np.ndarray:
    """Return the numbers of the tiles (n,) that hold a wanted pixel, for a mask (h, w)."""
    rows, columns = (np.arange(0, side, TILE_SIZE) for side in wanted.shape)
    bands = np.logical_or.reduceat(wanted, rows, axis=0)
    return np.flatnonzero(np.logical_or.reduceat(bands, columns, axis=1))


def pixels_of(tile: int, width: int, height: int) -> np.ndarray:
    """Return the row-major numbers (n,) of a tile's pixels."""
    across = -(-width // TILE_SIZE)
    top, left = tile // across * TILE_SIZE, tile % across * TILE_SIZE
    rows = np.arange(top, min(top + TILE_SIZE, height))
    columns = np.arange(left, min(left + TILE_SIZE, width))
    return (rows[:, None] * width + columns).ravel()
