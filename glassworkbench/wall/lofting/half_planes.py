"""The wanted inner surface in meridian half-planes through the axis: traced from the floor's centre to the mouth.

In each half-plane the points that the wall allows are bounded by one curve. It is followed by its length, so shoulders,
push-ups and grooves are met like any other part of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.spatial import Nearest
from glassworkbench.wall.asking.interpolation import monotone_cubic

ON_CURVE_MM = 1e-4
"""Traced points lie this close to the inner surface."""

SWING = 2.2
"""From one step to the next the curve turns by less than this (rad)."""

OUTLINE_RAYS, OUTLINE_LEVELS = 240, 5
"""Where the horizontal outline turns is seen from this many directions at this many heights."""

TURNING_SHARE = 0.4
"""This share of the half-planes goes where the outline turns, the rest by its length."""

SMOOTHING_SHARE = 0.03
"""Share of a curve's length over which its direction is averaged before its landmarks are looked for."""

SHOULDER_LEAN = np.radians(20.0)
"""A curve that leans inward by more than this above the body has a shoulder and a neck to align."""

Clearance = Callable[[np.ndarray], Nearest]
"""How far inside the wanted cavity points (n, 3) lie, and the outer points that decide, as `Outside.clearance`."""


def floor_height(clearance: Clearance, distance: Clearance, base_mm: float, finish_mm: float) -> float:
    """Return the height of the cavity's floor on the axis.

    Parameters
    ----------
    clearance, distance : callable
        `Outside.clearance` and `Outside.distance`.
    base_mm, finish_mm : float
        Heights on the axis between which the cavity may lie.

    Raises
    ------
    InputError
        If the wall closes the cavity somewhere below the mouth; it says where, and how thick the wall may be there.
    """
    heights = np.linspace(base_mm, finish_mm, 400)
    on_axis = np.column_stack([np.zeros((400, 2)), heights])
    closed = clearance(on_axis).clearance_mm <= 0.0
    below = np.flatnonzero(closed)
    # The floor of the glass is the lowest closed run; whatever is closed above it parts the cavity or the mouth.
    top_of_floor = int(np.argmin(closed)) if not closed.all() else len(closed)
    above = below[below >= top_of_floor]
    if not len(above) and heights[min(top_of_floor, 399)] < 0.5 * (base_mm + finish_mm):
        return _root_on_axis(clearance, *heights[[max(top_of_floor - 1, 0), top_of_floor]])
    blocked = above if len(above) else below[heights[below] > base_mm + 0.1 * (finish_mm - base_mm)]
    room = distance(on_axis[blocked]).distance_mm
    narrow = int(np.argmin(room))
    raise InputError(
        f"wall: at height {heights[blocked[narrow]]:.1f} mm the walls meet and part the cavity or close the mouth; "
        f"there they may be at most {room[narrow]:.2f} mm thick"
    )


def _root_on_axis(clearance: Clearance, low: float, high: float) -> float:
    while high - low > 0.1 * ON_CURVE_MM:
        middle = 0.5 * (low + high)
        inside = clearance(np.array([[0.0, 0.0, middle]])).clearance_mm[0] > 0.0
        low, high = (low, middle) if inside else (middle, high)
    return 0.5 * (low + high)


def chosen_angles(clearance: Clearance, floor_mm: float, finish_mm: float, count: int) -> np.ndarray:
    """Return angles (count,) in [0, 2 pi), closer together where the horizontal outlines of the cavity turn."""
    directions = 2.0 * np.pi * np.arange(OUTLINE_RAYS) / OUTLINE_RAYS
    levels = floor_mm + (finish_mm - floor_mm) * (np.arange(OUTLINE_LEVELS) + 0.5) / OUTLINE_LEVELS
    phi, z = (grid.ravel() for grid in np.meshgrid(directions, levels))
    ray = np.column_stack([np.cos(phi), np.sin(phi), np.zeros_like(phi)])
    # The clearance falls by at most the length of a step, so no step leads through the surface.
    reach = np.zeros(len(phi))
    for _ in range(12):
        reach += np.maximum(clearance(reach[:, None] * ray + np.column_stack([0 * z, 0 * z, z])).clearance_mm, 0.0)
    outlines = (reach[:, None] * ray[:, :2]).reshape(OUTLINE_LEVELS, OUTLINE_RAYS, 2)
    sides = np.roll(outlines, -1, axis=1) - outlines
    length = np.linalg.norm(sides, axis=2)
    before = np.roll(sides, 1, axis=1)
    turn = np.abs(
        np.arctan2(
            before[..., 0] * sides[..., 1] - before[..., 1] * sides[..., 0], np.einsum("ijk,ijk->ij", before, sides)
        )
    )
    turn = 0.5 * (turn + np.roll(turn, -1, axis=1))
    density = (1.0 - TURNING_SHARE) * length / length.sum() + TURNING_SHARE * turn / max(turn.sum(), 1e-9)
    sums = np.concatenate([[0.0], np.cumsum(density.sum(axis=0) + 0.1 / OUTLINE_RAYS)])
    return np.interp(np.arange(count) / count * sums[-1], sums, np.append(directions, 2.0 * np.pi))


def trace(
    clearance: Clearance,
    distance: Clearance,
    angles: np.ndarray,
    floor_mm: float,
    finish_mm: float,
    step_mm: float,
) -> list[np.ndarray]:
    """Return, for each angle, the curve's points (r mm, z mm) from the axis to just above the finish plane.

    Parameters
    ----------
    clearance, distance : callable
        `Outside.clearance` and `Outside.distance`.
    angles : array (n,)
        Of the half-planes, rad.
    floor_mm : float
        Height of the curve on the axis.
    finish_mm : float
    step_mm : float
        Distance from each point to the next.

    Raises
    ------
    InputError
        If a curve comes back to the axis below the mouth; it says where, and how thick the wall may be there.
    GlassWorkbenchError
        If a curve is lost, or never reaches the mouth.

    Notes
    -----
    The next point lies on a circle about the last one where the clearance passes from below 0, on the right of the
    direction of travel, to above 0, on its left. A corner of the curve is crossed like any other part of it.
    """
    count = len(angles)
    across = np.column_stack([np.cos(angles), np.sin(angles)])
    points = [np.column_stack([np.zeros(count), np.full(count, floor_mm)])]
    heading, running = np.zeros(count), np.ones(count, dtype=bool)
    most = int(8.0 * (finish_mm + 1.0) / step_mm) + 200
    while running.any():
        last = points[-1].copy()
        rows = np.flatnonzero(running)
        turned = _next_heading(clearance, across[rows], last[rows], heading[rows], step_mm)
        if np.isnan(turned).any():
            row = rows[np.flatnonzero(np.isnan(turned))[0]]
            raise GlassWorkbenchError(f"the inner surface is lost {_place(angles[row], last[row])}")
        heading[rows] = turned
        last[rows] += step_mm * np.column_stack([np.cos(turned), np.sin(turned)])
        points.append(last)
        back = running & (last[:, 0] < 0.0) & (len(points) > 3)
        if back.any():
            row = np.flatnonzero(back)[0]
            on_axis = distance(np.array([[0.0, 0.0, last[row, 1]]])).distance_mm[0]
            raise InputError(
                f"wall: the walls meet {_place(angles[row], last[row])} and part the cavity; there they may be at most "
                f"{on_axis:.2f} mm thick"
            )
        running = running & (last[:, 1] < finish_mm)
        if len(points) > most:
            row = np.flatnonzero(running)[0]
            raise GlassWorkbenchError(f"the inner surface does not reach the mouth {_place(angles[row], last[row])}")
    grid = np.stack(points, axis=1)
    return [curve[: int(np.argmax(curve[:, 1] >= finish_mm)) + 1] for curve in grid]


def _place(angle: float, point: np.ndarray) -> str:
    return f"at angle {np.degrees(angle):.0f} degrees, height {point[1]:.1f} mm"


def _next_heading(
    clearance: Clearance, across: np.ndarray, last: np.ndarray, heading: np.ndarray, step_mm: float
) -> np.ndarray:
    """Return the directions (n,) of the next step, NaN where there is none."""
    low, high, guess = heading - SWING, heading + SWING, heading.copy()
    rows = np.arange(len(heading))
    for _ in range(40):
        cosine, sine = np.cos(guess[rows]), np.sin(guess[rows])
        r, z = last[rows, 0] + step_mm * cosine, last[rows, 1] + step_mm * sine
        points = np.column_stack([r[:, None] * across[rows], z])
        found = clearance(points)
        value = found.clearance_mm
        away = (points - found.feet_mm) / np.maximum(np.linalg.norm(points - found.feet_mm, axis=1), 1e-12)[:, None]
        radial = np.einsum("ij,ij->i", away[:, :2], across[rows])
        slope = step_mm * (-sine * radial + cosine * away[:, 2])
        low[rows] = np.where(value < 0.0, guess[rows], low[rows])
        high[rows] = np.where(value >= 0.0, guess[rows], high[rows])
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = guess[rows] - value / slope
        good = (slope > 0.05 * step_mm) & (newton > low[rows]) & (newton < high[rows])
        done = (np.abs(value) < ON_CURVE_MM) | (high[rows] - low[rows] < 1e-9)
        guess[rows] = np.where(done, guess[rows], np.where(good, newton, 0.5 * (low[rows] + high[rows])))
        rows = rows[~done]
        if not len(rows):
            break
    at_an_end = np.minimum(guess - (heading - SWING), heading + SWING - guess) < 1e-6
    return np.where(at_an_end, np.nan, guess)


def aligned(curves: Sequence[np.ndarray], finish_mm: float, count: int) -> np.ndarray:
    """Return points (count, n, 2) of n curves, those of one row corresponding to each other.

    Heel, shoulder and neck of all the curves come to lie on the same rows; between them the rows follow by length.

    Parameters
    ----------
    curves : sequence of arrays (k, 2)
        As `trace` returns them.
    finish_mm : float
    count : int
        The first row is the floor's centre, the last lies at the height of the finish plane.
    """
    ended = [_ended(curve, finish_mm) for curve in curves]
    lengths = [np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(c, axis=0), axis=1))]) for c in ended]
    marks = np.array(_common([_landmarks(curve, s) for curve, s in zip(ended, lengths, strict=True)]))
    shares = (marks / marks[:, -1:]).mean(axis=0)
    rows = np.linspace(0.0, 1.0, count)
    grid = np.empty((count, len(ended), 2))
    for column, (curve, s, mark) in enumerate(zip(ended, lengths, marks, strict=True)):
        at = monotone_cubic(shares, mark, rows)[0]
        grid[:, column] = np.column_stack([np.interp(at, s, curve[:, 0]), np.interp(at, s, curve[:, 1])])
    return grid


def bridged(meridians: np.ndarray, hidden: np.ndarray) -> np.ndarray:
    """Return points (m, n, 2) of n curves, the hidden ones (m, n) led smoothly on from those before and behind."""
    rows = np.arange(len(meridians), dtype=float)
    smooth = meridians.copy()
    for column in np.flatnonzero(hidden[1:-1].any(axis=0)):
        seen = ~hidden[:, column]
        seen[[0, -1]] = True
        for k in range(2):
            smooth[~seen, column, k] = monotone_cubic(rows[seen], meridians[seen, column, k], rows[~seen])[0]
    return smooth


def _ended(curve: np.ndarray, finish_mm: float) -> np.ndarray:
    before, after = curve[-2], curve[-1]
    share = np.clip((finish_mm - before[1]) / max(after[1] - before[1], 1e-12), 0.0, 1.0)
    return np.vstack([curve[:-1], before + share * (after - before)])


def _landmarks(curve: np.ndarray, lengths: np.ndarray) -> dict[str, float]:
    """Return the lengths at which the smoothed curve turns up into the wall, in over the shoulder, and up the neck."""
    steps = np.diff(curve, axis=0)
    lean = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    width = max(int(SMOOTHING_SHARE * len(lean)), 1)
    padded = np.pad(lean, width, mode="edge")
    lean = np.convolve(padded, np.full(2 * width + 1, 1.0 / (2 * width + 1)), mode="valid")
    middle = 0.5 * (lengths[1:] + lengths[:-1])
    marks = {}
    heel = _crossing(lean, middle, np.radians(45.0), 0, 1)
    if heel is not None:
        marks["heel"] = heel
        most = int(np.argmax(np.where(middle > heel, lean, -np.inf)))
        if lean[most] > np.radians(90.0) + SHOULDER_LEAN:
            level = 0.5 * (np.radians(90.0) + lean[most])
            marks["shoulder"] = _crossing(lean, middle, level, most, -1)
            marks["neck"] = _crossing(lean, middle, level, most, 1)
    marks["mouth"] = float(lengths[-1])
    return {name: at for name, at in marks.items() if at is not None}


def _crossing(lean: np.ndarray, at: np.ndarray, level: float, start: int, sense: int) -> float | None:
    """Return where the lean first passes a level, going forth or back from a start."""
    order = np.arange(start, len(lean)) if sense > 0 else np.arange(start, -1, -1)
    above = lean[order] > level
    changes = np.flatnonzero(above[1:] != above[:-1])
    if not len(changes):
        return None
    i, j = order[changes[0]], order[changes[0] + 1]
    return float(at[i] + (level - lean[i]) / (lean[j] - lean[i]) * (at[j] - at[i]))


def _common(marks: Sequence[dict[str, float]]) -> list[list[float]]:
    """Return the landmarks (from 0) that all curves have, in the same order and clearly apart."""
    names = [name for name in ("heel", "shoulder", "neck", "mouth") if all(name in each for each in marks)]
    kept: list[str] = []
    for name in names:
        before = [each[kept[-1]] if kept else 0.0 for each in marks]
        room = [each["mouth"] - each[name] for each in marks]
        apart = 0.02 * min(each["mouth"] for each in marks)
        clear = min(np.array([each[name] for each in marks]) - before) > apart and min(room) > apart
        if name == "mouth" or clear:
            kept.append(name)
    return [[0.0, *(each[name] for name in kept)] for each in marks]
