"""Which nodes of a grid belong to the cavity that the mouth opens into."""

from __future__ import annotations

import numpy as np

from glassworkbench.wall.levels.level_set import Grid


def cavity_nodes(grid: Grid, positive: np.ndarray, ceiling_mm: float, mouth_radius_mm: float) -> tuple[np.ndarray, int]:
    """Return the nodes (nx, ny, nz) that are joined to the mouth, and how many pockets of others there are.

    Parameters
    ----------
    grid : Grid
        About an upright body; the function is positive in its cavity and, apart from that, outside.
    positive : bool array (nx, ny, nz)
        Without its outermost layers.
    ceiling_mm, mouth_radius_mm : float
        Height of the mouth, and how far it reaches from the axis.
    """
    outward = np.zeros_like(positive)
    for axis, ends in ((0, (1, -2)), (1, (1, -2)), (2, (1,))):
        for end in ends:
            at = tuple(end if k == axis else slice(None) for k in range(3))
            outward[at] = positive[at]
    outside = joined(positive, outward)
    level = int(np.floor((ceiling_mm - grid.origin_mm[2]) / grid.step_mm))
    from_axis = np.hypot(
        *np.meshgrid(*(grid.origin_mm[k] + grid.step_mm * np.arange(positive.shape[k]) for k in (0, 1)), indexing="ij")
    )
    mouth = np.zeros_like(positive)
    mouth[:, :, level] = positive[:, :, level] & ~outside[:, :, level] & (from_axis < mouth_radius_mm)
    cavity = joined(positive, mouth)
    left = positive & ~outside & ~cavity
    pockets = 0
    while left.any():
        first = np.zeros_like(left)
        first[np.unravel_index(np.argmax(left), left.shape)] = True
        left &= ~joined(left, first)
        pockets += 1
    return cavity, pockets


def joined(positive: np.ndarray, seeds: np.ndarray) -> np.ndarray:
    """Return the nodes that a way along the grid's edges through positive nodes joins to the seeds."""
    shape = positive.shape
    free = positive.ravel() & ~seeds.ravel()
    reached = seeds.ravel().copy()
    front = np.flatnonzero(reached)
    strides = np.array([shape[1] * shape[2], shape[2], 1])
    while len(front):
        # The outermost nodes are never positive, so that no step leads out of the grid.
        beside = np.unique((front[:, None] + np.concatenate([strides, -strides])).ravel())
        front = beside[free[beside]]
        free[front], reached[front] = False, True
    return reached.reshape(shape)


def without_border(positive: np.ndarray) -> np.ndarray:
    """Return the nodes, the outermost taken out."""
    within = np.zeros_like(positive)
    within[1:-1, 1:-1, 1:-1] = positive[1:-1, 1:-1, 1:-1]
    return within
