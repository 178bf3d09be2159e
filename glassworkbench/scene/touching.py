"""Which of many ellipsoids touch or overlap."""

from __future__ import annotations

import numpy as np

FEW = 32
"""Boxes among which every pair is looked at."""

HALVINGS = 80
"""Of the interval in which the contact function has its maximum, by the golden section."""


def touching_pairs(centres_mm: np.ndarray, semi_axes_mm: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Return the pairs of ellipsoids that touch or overlap, int (k, 2), each pair and the list ascending.

    Parameters
    ----------
    centres_mm, semi_axes_mm : array (n, 3)
    rotations : array (n, 3, 3)
        Columns are the directions of the semi-axes.
    """
    arms = rotations * semi_axes_mm[:, None, :]
    reach = np.linalg.norm(arms, axis=2)
    pairs = _box_pairs(centres_mm - reach, centres_mm + reach)
    first, second = pairs.T
    contact = contact_function(centres_mm[second] - centres_mm[first], arms[first], arms[second])
    return pairs[contact <= 1.0]


def contact_function(between_mm: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return for pairs of ellipsoids the square of the factor by which both grow until they touch.

    It is above 1 where they lie apart. With the shape matrices A and B and v from centre to centre it is the maximum
    over s from 0 to 1 of s (1 - s) v . ((1 - s) A + s B)^-1 v, which is concave in s.

    Parameters
    ----------
    between_mm : array (k, 3)
        From the first centre to the second.
    first, second : array (k, 3, 3)
        Columns are the semi-axes, so that A = first first^T.

    References
    ----------
    J. W. Perram and M. S. Wertheim, "Statistical mechanics of hard ellipsoids", J. Comput. Phys. 58 (1985) 409.
    """
    # In the coordinates where A is the identity, B's principal axes leave a sum of three terms.
    inverse = np.linalg.inv(first)
    axes, stretch, _ = np.linalg.svd(inverse @ second)
    across = np.einsum("kji,kj->ki", axes, np.einsum("kij,kj->ki", inverse, between_mm)) ** 2
    squares = stretch**2

    def value(s: np.ndarray) -> np.ndarray:
        s = s[:, None]
        return np.sum(s * (1.0 - s) * across / ((1.0 - s) + s * squares), axis=1)

    low, high = np.zeros(len(across)), np.ones(len(across))
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    for _ in range(HALVINGS):
        step = golden * (high - low)
        left_is_better = value(high - step) > value(low + step)
        low, high = np.where(left_is_better, low, high - step), np.where(left_is_better, low + step, high)
    return value(0.5 * (low + high))


def _box_pairs(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the pairs of boxes that overlap, (k, 2): by halving the set, what lies across the cut in both halves."""
    found = [np.zeros((0, 2), dtype=np.int64)]
    waiting = [np.arange(len(low))]
    while waiting:
        members = waiting.pop()
        if len(members) > FEW:
            centres = 0.5 * (low[members] + high[members])
            axis = int(np.argmax(np.ptp(centres, axis=0)))
            cut = np.median(centres[:, axis])
            halves = [members[low[members, axis] <= cut], members[high[members, axis] >= cut]]
            if max(map(len, halves)) <= 0.75 * len(members):
                waiting += halves
                continue
        # Few, or so many of them across every cut that cutting would not end.
        order = members[np.argsort(low[members, 0])]
        last = np.searchsorted(low[order, 0], high[order, 0], side="right")
        counts = np.maximum(last - np.arange(len(order)) - 1, 0)
        first = np.repeat(np.arange(len(order)), counts)
        second = first + 1 + np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        a, b = order[first], order[second]
        meet = np.all((low[a] <= high[b]) & (low[b] <= high[a]), axis=1)
        found.append(np.sort(np.stack([a[meet], b[meet]], axis=1), axis=1))
    return np.unique(np.concatenate(found), axis=0)
