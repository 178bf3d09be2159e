"""Interpolation that never overshoots: over one coordinate, and over height and angle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

TURN_DEG = 360.0


def smooth_step(share: np.ndarray) -> np.ndarray:
    """Return 0 below share 0, 1 above 1, and the cubic in between that starts and ends level."""
    share = np.clip(share, 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


def monotone_cubic(knots: np.ndarray, values: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Interpolate without overshoot; the end values hold beyond the ends.

    Parameters
    ----------
    knots, values : array (n,)
        Knots ascending, n >= 2.
    x : array
        Where to interpolate, any shape.

    Returns
    -------
    value, slope : array
        Shaped like x.

    Notes
    -----
    Piecewise cubic Hermite interpolation (PCHIP), slopes by Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5 (1984)
    300: weighted harmonic means of the neighbouring secants; at the ends the three-point formula, limited as by
    Moler, Numerical Computing with MATLAB (2004), section 3.6.
    """
    steps = np.diff(knots)
    secants = np.diff(values) / steps
    slopes = _slopes(steps, secants)
    row = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(steps) - 1)
    step, start, secant = steps[row], slopes[row], secants[row]
    u = np.clip((x - knots[row]) / step, 0.0, 1.0)
    quadratic = 3 * secant - 2 * start - slopes[row + 1]
    cubic = start + slopes[row + 1] - 2 * secant
    value = values[row] + step * u * (start + u * (quadratic + u * cubic))
    slope = start + u * (2 * quadratic + u * 3 * cubic)
    return value, np.where((x < knots[0]) | (x > knots[-1]), 0.0, slope)


@dataclass(frozen=True, eq=False)
class PeriodicGrid:
    """Values at heights and angles, interpolated without overshoot; the end rows hold beyond the ends.

    Parameters
    ----------
    heights : array (n,)
        Ascending, n >= 2.
    angles_deg : array (m,)
        Ascending within 0 <= angle < 360, m >= 2; the last is followed by the first.
    values : array (n, m)
    smooth : bool
        Bicubic, with slopes that are continuous everywhere, or bilinear.

    Notes
    -----
    The bicubic patches have the slopes of `monotone_cubic` along both coordinates and no twist. Where a patch would
    leave the range of its four corners, the slopes at a corner are shortened until its four Bezier points (those of
    the convex hull) are within: by half at most, as each slope on its own keeps to its row or column. So the surface
    is monotone along rows and columns, stays between the four values around each point, and is smooth.
    """

    heights: np.ndarray
    angles_deg: np.ndarray
    values: np.ndarray
    smooth: bool = True

    def at(self, height: np.ndarray, angle_deg: np.ndarray) -> np.ndarray:
        """Return the values (k,) at heights and angles (k,)."""
        row = np.clip(np.searchsorted(self.heights, height, side="right") - 1, 0, len(self.heights) - 2)
        u = np.clip((height - self.heights[row]) / self._rises[row], 0.0, 1.0)
        angle = np.mod(angle_deg - self.angles_deg[0], TURN_DEG)
        column = np.clip(np.searchsorted(self.angles_deg - self.angles_deg[0], angle, side="right") - 1, 0, None)
        v = np.clip((angle - (self.angles_deg[column] - self.angles_deg[0])) / self._turns[column], 0.0, 1.0)
        corners = [(row + i, (column + j) % len(self.angles_deg), i, j) for i in (0, 1) for j in (0, 1)]
        if not self.smooth:
            share = ((1.0 - u, u), (1.0 - v, v))
            return sum(share[0][i] * share[1][j] * self.values[n, m] for n, m, i, j in corners)
        along_height, along_angle = self._slopes
        at_u, at_v = _hermite(u), _hermite(v)
        total = np.zeros(np.shape(u))
        for n, m, i, j in corners:
            total += at_u[0][i] * at_v[0][j] * self.values[n, m]
            total += at_u[1][i] * at_v[0][j] * self._rises[row] * along_height[n, m]
            total += at_u[0][i] * at_v[1][j] * self._turns[column] * along_angle[n, m]
        return total

    def mean_over_angle(self) -> np.ndarray:
        """Return the mean of each row (n,), its values weighted by the angles they stand for."""
        weights = 0.5 * (self._turns + np.roll(self._turns, 1))
        return self.values @ weights / TURN_DEG

    @cached_property
    def _rises(self) -> np.ndarray:
        return np.diff(self.heights)

    @cached_property
    def _turns(self) -> np.ndarray:
        return np.diff(self.angles_deg, append=self.angles_deg[0] + TURN_DEG)

    @cached_property
    def _slopes(self) -> tuple[np.ndarray, np.ndarray]:
        """Slopes along height and angle, (n, m) each."""
        along_height = _slopes(self._rises[:, None], np.diff(self.values, axis=0) / self._rises[:, None])
        after = (np.roll(self.values, -1, axis=1) - self.values) / self._turns
        along_angle = _inner_slopes(np.roll(self._turns, 1), self._turns, np.roll(after, 1, axis=1), after)
        kept = np.ones(self.values.shape)
        for rows, others, rise in ((slice(None, -1), slice(1, None), 1.0), (slice(1, None), slice(None, -1), -1.0)):
            for shift, turns in ((-1, self._turns), (1, -np.roll(self._turns, 1))):
                here, there = self.values[rows], self.values[others]
                corners = np.stack([here, there, np.roll(here, shift, axis=1), np.roll(there, shift, axis=1)])
                step = (rise * self._rises[:, None] * along_height[rows] + turns * along_angle[rows]) / 3.0
                room = np.where(step > 0.0, corners.max(axis=0), corners.min(axis=0)) - here
                fits = np.abs(step) <= np.abs(room)
                kept[rows] = np.minimum(kept[rows], np.where(fits, 1.0, room / np.where(fits, 1.0, step)))
        return kept * along_height, kept * along_angle


def _hermite(u: np.ndarray) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """Return the weights of the values, and of the slopes times the step, at the start and at the end."""
    end = u * u * (3.0 - 2.0 * u)
    return (1.0 - end, end), (u * (1.0 - u) ** 2, u * u * (u - 1.0))


def _slopes(steps: np.ndarray, secants: np.ndarray) -> np.ndarray:
    """Return the slopes at the knots (n, ...) from steps and secants between them (n - 1, ...)."""
    if len(secants) == 1:
        return np.concatenate([secants, secants])
    first = _end_slope(steps[0], steps[1], secants[0], secants[1])
    last = _end_slope(steps[-1], steps[-2], secants[-1], secants[-2])
    return np.concatenate([first[None], _inner_slopes(steps[:-1], steps[1:], secants[:-1], secants[1:]), last[None]])


def _inner_slopes(step_before: np.ndarray, step_after: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    same = before * after > 0.0
    weight_before, weight_after = 2 * step_after + step_before, step_after + 2 * step_before
    inverse = weight_before / np.where(same, before, 1.0) + weight_after / np.where(same, after, 1.0)
    return np.where(same, (weight_before + weight_after) / inverse, 0.0)


def _end_slope(step: np.ndarray, next_step: np.ndarray, secant: np.ndarray, next_secant: np.ndarray) -> np.ndarray:
    slope = ((2 * step + next_step) * secant - step * next_secant) / (step + next_step)
    steep = (secant * next_secant <= 0.0) & (np.abs(slope) > 3 * np.abs(secant))
    return np.where(slope * secant <= 0.0, 0.0, np.where(steep, 3 * secant, slope))
