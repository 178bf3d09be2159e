"""Which stretches of an envelope bound the cavity: cusps, folds and features that vanish are taken away."""

from __future__ import annotations

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.wall.turning.bezier import intersection
from glassworkbench.wall.turning.envelope import Envelope

CLEARANCE_MM = 1e-6
"""A point of the envelope that is this much too near to the outside lies in a fold."""

CORNER = 1e-5
"""Pieces of the outside that turn inward by less (rad) count as one; CAD files are seldom smoother."""

GROUP, BLOCK = 64, 16
"""How many neighbouring points, and centres of circles, are tested together."""


def clearance(points: np.ndarray, feet: np.ndarray, thickness: np.ndarray) -> np.ndarray:
    """Return min over feet of |p - s| - t for each point (n, 2): how much too far inside (mm), negative if too near.

    Points and feet that follow each other should be neighbours: they are tested in groups, most of which are too far
    from each other to matter.
    """
    edges = np.arange(0, len(feet), BLOCK)
    centres, radii = _groups(feet, BLOCK)
    reach = radii + np.maximum.reduceat(thickness, edges)
    least = radii - np.minimum.reduceat(thickness, edges)
    padding = -len(feet) % BLOCK
    feet = np.pad(feet, ((0, padding), (0, 0)), mode="edge").reshape(-1, BLOCK, 2)
    thickness = np.pad(thickness, (0, padding), mode="edge").reshape(-1, BLOCK)
    nearest = np.empty(len(points))
    for number, (middle, radius) in enumerate(zip(*_groups(points, GROUP), strict=True)):
        group = slice(number * GROUP, (number + 1) * GROUP)
        apart = np.hypot(*(centres - middle).T)
        near = apart - radius - reach <= (apart + radius + least).min()
        gap = points[group, None] - feet[near].reshape(-1, 2)
        nearest[group] = (np.sqrt(np.einsum("ijk,ijk->ij", gap, gap)) - thickness[near].ravel()).min(axis=1)
    return nearest


def _groups(points: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a centre (g, 2) and a radius (g,) of circles that hold each `size` points that follow each other."""
    edges = np.arange(0, len(points), size)
    low, high = np.minimum.reduceat(points, edges, axis=0), np.maximum.reduceat(points, edges, axis=0)
    return 0.5 * (low + high), 0.5 * np.hypot(*(high - low).T)


def unfolded(envelope: Envelope) -> list[tuple[float, float]]:
    """Return the stretches (first place, last place) of the envelope that bound the cavity, in order, joined."""
    trace, places = envelope.trace, envelope.places
    kept = np.isfinite(trace.points[:, 0]) & (trace.points[:, 0] >= -1e-9)
    kept[kept] = clearance(trace.points[kept], trace.feet, trace.thickness) >= -CLEARANCE_MM
    for end in _convex_corners(envelope):
        # The fold behind a blunt corner can be smaller than the samples' spacing, but it is there.
        kept[end : end + 2] = False
    edges = np.flatnonzero(np.diff(np.concatenate([[False], kept, [False]]).astype(int)))
    runs = [(first, last - 1) for first, last in edges.reshape(-1, 2)]
    runs = [run for run in runs if run[1] > run[0]]
    if not runs:
        raise GlassWorkbenchError("revolved: no part of the offset meridian bounds a cavity")
    first = min(range(len(runs)), key=lambda k: trace.points[runs[k][0], 0])
    stretches = [(_axis_place(envelope, runs[first][0]), places[runs[first][1]])]
    last = runs[first][1]
    for start, end in runs[first + 1 :]:
        joint = _joint(envelope, last, start)
        # A run that does not touch the chain bounds a pocket of its own, which stays solid.
        if joint is not None:
            stretches[-1] = (stretches[-1][0], joint[0])
            stretches.append((joint[1], places[end]))
            last = end
    return stretches


def _convex_corners(envelope: Envelope) -> np.ndarray:
    """Return the samples that end a piece where the next starts turned toward the inside."""
    directions = envelope.trace.directions
    before, after = directions[:-1], directions[1:]
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.flatnonzero((np.diff(np.floor(envelope.places)) > 0) & (turn > CORNER))


def _axis_place(envelope: Envelope, first: int) -> float:
    """Return the place where the run that starts at a sample meets the axis."""
    r = envelope.trace.points[:, 0]
    if first == 0 or not r[first - 1] < 0.0:
        return float(envelope.places[first])
    low, high = envelope.places[first - 1], envelope.places[first]
    for _ in range(60):
        middle = 0.5 * (low + high)
        if envelope.at(np.array([middle])).points[0, 0] < 0.0:
            low = middle
        else:
            high = middle
    return float(high)


def _joint(envelope: Envelope, last: int, first: int) -> tuple[float, float] | None:
    """Return the places where the branch that ends at sample `last` meets the one that starts at `first`."""
    places = envelope.places
    # Each branch is followed into its fold, but not past the end of its piece, where the next may start elsewhere.
    a_end = np.nextafter(np.floor(places[last]) + 1.0, 0.0)
    a = places[max(last - 2, 0)], min(places[min(last + 3, len(places) - 1)], a_end)
    b = max(places[max(first - 3, 0)], np.floor(places[first])), places[min(first + 2, len(places) - 1)]
    found = False
    # Ten rounds of a sixteenth each come down to the last digits of a place; there the test itself may miss.
    for _ in range(10):
        grids = np.linspace(*a, 17), np.linspace(*b, 17)
        p, q = (envelope.at(grid).points for grid in grids)
        i, j = (index.ravel() for index in np.indices((16, 16)))
        hits = np.flatnonzero(np.isfinite(intersection(p[i], p[i + 1], q[j], q[j + 1])))
        if len(hits) == 0:
            break
        found = True
        i, j = i[hits[0]], j[hits[0]]
        a, b = (grids[0][i], grids[0][i + 1]), (grids[1][j], grids[1][j + 1])
    if found:
        return 0.5 * (a[0] + a[1]), 0.5 * (b[0] + b[1])
    # Branches that meet at a grazing angle may miss each other by rounding; ends that all but touch are as good.
    pairs = [(a[1], b[0]), (float(places[last]), float(places[first]))]
    gaps = [np.linalg.norm(np.diff(envelope.at(np.array(pair)).points, axis=0)) for pair in pairs]
    points = envelope.trace.points
    spacing = np.linalg.norm(points[last] - points[last - 1]) + np.linalg.norm(points[first + 1] - points[first])
    return pairs[int(np.argmin(gaps))] if min(gaps) <= spacing else None


def up_to(envelope: Envelope, stretches: list[tuple[float, float]], height_mm: float) -> list[tuple[float, float]]:
    """Return the stretches up to where they first reach a height."""
    for number, (start, end) in enumerate(stretches):
        within = (envelope.places > start) & (envelope.places < end)
        places = np.concatenate([[start], envelope.places[within], [end]])
        ends = envelope.at(places[[0, -1]]).points[:, 1]
        heights = np.concatenate([ends[:1], envelope.trace.points[within, 1], ends[1:]])
        above = np.flatnonzero(heights >= height_mm)
        if len(above) and above[0] > 0:
            low, high = places[above[0] - 1], places[above[0]]
            for _ in range(60):
                middle = 0.5 * (low + high)
                if envelope.at(np.array([middle])).points[0, 1] >= height_mm:
                    high = middle
                else:
                    low = middle
            return [*stretches[:number], (start, high)]
    raise GlassWorkbenchError(
        f"revolved: the offset meridian breaks off before it reaches {height_mm:.2f} mm, where the mouth is"
    )
