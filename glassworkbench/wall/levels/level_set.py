"""Where a distance-like function is positive on a grid, evaluated only near its zero level."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

HALVINGS = 3
"""How often the spacing is halved from the coarsest grid to the finest."""


@dataclass(frozen=True, eq=False)
class Grid:
    """A cubic grid with a value at each node.

    Parameters
    ----------
    origin_mm : array (3,)
        Of the node (0, 0, 0).
    step_mm : float
        Spacing of the nodes.
    bound_mm : array (nx, ny, nz)
        Has the function's sign; the function is at least as far from 0 as this.
    """

    origin_mm: np.ndarray
    step_mm: float
    bound_mm: np.ndarray

    def points(self, nodes: np.ndarray) -> np.ndarray:
        """Return the points (n, 3) of nodes, or of places between them, counted in steps (n, 3)."""
        return self.origin_mm + self.step_mm * nodes


def sampled(
    function: Callable[[np.ndarray], np.ndarray], low_mm: np.ndarray, high_mm: np.ndarray, step_mm: float
) -> Grid:
    """Sample a function on a grid that covers a box.

    Parameters
    ----------
    function : callable
        Takes points (n, 3), returns values (n,) in mm. It must not change faster than the distance: then a value at one
        node decides the sign at all nodes that are nearer than that, and most are never evaluated.
    low_mm, high_mm : array (3,)
        Corners of the box; the grid starts at the lower one.
    step_mm : float
    """
    spacing = step_mm * 2**HALVINGS
    counts = np.ceil((np.asarray(high_mm) - low_mm) / spacing).astype(int) + 1
    nodes = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    bound = function(low_mm + spacing * nodes).reshape(counts)
    for _ in range(HALVINGS):
        spacing *= 0.5
        bound = _halved(bound, spacing)
        unknown = np.argwhere(np.isnan(bound))
        bound[tuple(unknown.T)] = function(low_mm + spacing * unknown)
    return Grid(np.asarray(low_mm, dtype=np.float64), step_mm, bound)


def _halved(bound: np.ndarray, spacing: float) -> np.ndarray:
    """Return bounds on the grid with half the spacing, NaN where those known say nothing."""
    fine = np.full(2 * np.array(bound.shape) - 1, np.nan)
    for odd in itertools.product((0, 1), repeat=3):
        best = None
        for side in itertools.product(*(range(1 + o) for o in odd)):
            near = bound[tuple(slice(s, n - o + s) for s, o, n in zip(side, odd, bound.shape, strict=True))]
            best = near if best is None else np.where(np.abs(near) > np.abs(best), near, best)
        left = np.abs(best) - spacing * np.sqrt(sum(odd))
        known = np.where(left > 0.0, np.copysign(left, best), np.nan) if any(odd) else best
        fine[tuple(slice(o, None, 2) for o in odd)] = known
    return fine
