"""Chains of rational cubic Bezier segments in the meridian half-plane: evaluate, cut, fit, check."""

from __future__ import annotations

import numpy as np

HANDLE_PASSES = 4
"""How often a fit's sample parameters are corrected (Hoschek, Computer Aided Geometric Design 5 (1988) 79)."""


def evaluate(segment: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points and derivatives with respect to u.

    Parameters
    ----------
    segment : array (4, 3)
        Control points (r mm, z mm, weight).
    u : array (m,)
        Parameters in [0, 1].

    Returns
    -------
    points, derivatives : array (m, 2)
    """
    homogeneous = segment * np.array([1.0, 1.0, 0.0]) * segment[:, 2:] + segment * np.array([0.0, 0.0, 1.0])
    u = np.asarray(u, dtype=np.float64)[:, None]
    v = 1.0 - u
    value = (
        v**3 * homogeneous[0] + 3 * u * v**2 * homogeneous[1] + 3 * u**2 * v * homogeneous[2] + u**3 * homogeneous[3]
    )
    legs = 3.0 * np.diff(homogeneous, axis=0)
    slope = v**2 * legs[0] + 2 * u * v * legs[1] + u**2 * legs[2]
    points = value[:, :2] / value[:, 2:]
    return points, (slope[:, :2] - points * slope[:, 2:]) / value[:, 2:]


def cut(segment: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return the part of a segment (4, 3) between two parameters, as a segment (de Casteljau)."""
    homogeneous = np.column_stack([segment[:, :2] * segment[:, 2:], segment[:, 2]])
    homogeneous = _split(homogeneous, high)[0]
    if low > 0.0:
        homogeneous = _split(homogeneous, low / high)[1]
    return np.column_stack([homogeneous[:, :2] / homogeneous[:, 2:], homogeneous[:, 2]])


def _split(points: np.ndarray, u: float) -> tuple[np.ndarray, np.ndarray]:
    first, last = [points[0]], [points[-1]]
    while len(points) > 1:
        points = points[:-1] + u * np.diff(points, axis=0)
        first.append(points[0])
        last.append(points[-1])
    return np.array(first), np.array(last[::-1])


def line(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the straight segment (4, 3) between two points (2,)."""
    share = np.linspace(0.0, 1.0, 4)[:, None]
    points = (1.0 - share) * np.asarray(start) + share * np.asarray(end)
    points[0], points[-1] = start, end
    return np.column_stack([points, np.ones(4)])


def polyline(chain: np.ndarray, per_segment: int) -> np.ndarray:
    """Return points (n, 2) along a chain (segments, 4, 3), each joint once."""
    u = np.linspace(0.0, 1.0, per_segment + 1)
    pieces = [evaluate(segment, u[1:])[0] for segment in chain]
    return np.concatenate([chain[0, :1, :2], *pieces])


def unit(vectors: np.ndarray) -> np.ndarray:
    """Return vectors (..., 2) scaled to length 1; zero vectors become NaN."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def fit_cubic(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, float]:
    """Fit one cubic with given end points and end tangents.

    Parameters
    ----------
    points : array (m, 2)
        Samples in order; the first and the last are met exactly.
    start, end : array (2,)
        Unit tangents in the direction of travel.

    Returns
    -------
    segment : array (4, 3)
    error_mm : float
        Largest distance from a sample to the curve.
    """
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    w = np.concatenate([[0.0], np.cumsum(steps)])
    length = w[-1]
    w /= length
    first, last = points[0], points[-1]
    for _ in range(HANDLE_PASSES):
        v = 1.0 - w
        b1, b2 = 3 * w * v**2, 3 * w**2 * v
        fixed = np.outer(v**3 + b1, first) + np.outer(b2 + w**3, last)
        # Least squares for the two handles' lengths, by their normal equations.
        rest = points - fixed
        first_moment, last_moment = b1 @ (rest @ start), -b2 @ (rest @ end)
        a, b, c = b1 @ b1, -(b1 @ b2) * (start @ end), b2 @ b2
        handles = np.array([c * first_moment - b * last_moment, a * last_moment - b * first_moment])
        handles /= max(a * c - b * b, 1e-300)
        # A handle that is not clearly forward would make a cusp; a third of the length is right to third order.
        handles = np.where(handles > 0.02 * length, handles, length / 3.0)
        segment = np.column_stack([[first, first + handles[0] * start, last - handles[1] * end, last], np.ones(4)])
        curve, slope = evaluate(segment, w)
        gap = points - curve
        w = np.clip(w + np.sum(gap * slope, axis=1) / np.sum(slope**2, axis=1), 0.0, 1.0)
        w[0], w[-1] = 0.0, 1.0
    return segment, float(np.linalg.norm(points - evaluate(segment, w)[0], axis=1).max())


def crossings(points: np.ndarray) -> np.ndarray:
    """Find where an open polyline crosses itself.

    Parameters
    ----------
    points : array (n, 2)

    Returns
    -------
    places : array (k, 2)
        One point for each pair of segments, not neighbours, that cross.
    """
    starts, ends = points[:-1], points[1:]
    block = 32
    edges = np.arange(0, len(starts), block)
    low = np.minimum.reduceat(np.minimum(starts, ends), edges, axis=0)
    high = np.maximum.reduceat(np.maximum(starts, ends), edges, axis=0)
    meets = np.all((low[:, None] <= high[None]) & (low[None] <= high[:, None]), axis=2)
    places = []
    for a, b in zip(*np.nonzero(np.triu(meets)), strict=True):
        i = np.arange(edges[a], min(edges[a] + block, len(starts)))
        j = np.arange(edges[b], min(edges[b] + block, len(starts)))
        i, j = (grid.ravel() for grid in np.meshgrid(i, j, indexing="ij"))
        apart = j > i + 1
        i, j = i[apart], j[apart]
        along = intersection(starts[i], ends[i], starts[j], ends[j])
        hit = ~np.isnan(along)
        places.append(starts[i[hit]] + along[hit, None] * (ends - starts)[i[hit]])
    return np.concatenate(places) if places else np.zeros((0, 2))


def intersection(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Return how far along ab (0 to 1) it meets cd, NaN where it does not; points are arrays (n, 2)."""
    ab, cd, ac = b - a, d - c, c - a
    area = ab[:, 0] * cd[:, 1] - ab[:, 1] * cd[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        along = (ac[:, 0] * cd[:, 1] - ac[:, 1] * cd[:, 0]) / area
        other = (ac[:, 0] * ab[:, 1] - ac[:, 1] * ab[:, 0]) / area
        hit = (along >= 0.0) & (along <= 1.0) & (other >= 0.0) & (other <= 1.0)
    return np.where(hit, along, np.nan)
