"""Where a wall leaves no room, and how much would fit there."""

from __future__ import annotations

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.wall.measuring.outside import Outside

LAYERS, ACROSS = 48, 24
"""Heights that are looked at, and points across each."""

CLOSER = 4
"""The narrowest heights, which are looked at closely."""

ZOOMS = 3


def no_room(wall: Outside, asked_mm: float) -> InputError:
    """Return the sentence for a body whose cavity does not reach the mouth: where it is narrowest, and what fits.

    The largest ball that fits at each height is sought; the cavity is blocked where the wall asked leaves it least.
    """
    corners = wall.corners_mm[~wall.collar]
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    centre, half = 0.5 * (low + high)[:2], 0.5 * (high - low)[:2]
    heights = np.linspace(low[2], wall.finish_height_mm, LAYERS + 1)[1:-1]
    best = _widest(wall, corners, centre, half, heights)
    # Below the widest place there is a floor, which blocks nothing.
    widest = int(np.argmax(best[:, 2]))
    narrow = widest + np.argsort(best[widest:, 2])[:CLOSER]
    for k in narrow:
        closer = half
        for _ in range(ZOOMS):
            closer = closer * 3.0 / ACROSS
            found = _widest(wall, corners, best[k, :2], closer, heights[k : k + 1])[0]
            if found[2] > best[k, 2]:
                best[k] = found
    worst = narrow[np.argmin(best[narrow, 2])]
    _, _, clearance, radius = best[worst]
    if clearance > 0.0:
        return InputError(
            f"wall: {asked_mm:.3g} mm leaves no way from the mouth down that could be found; ask for a thinner wall"
        )
    return InputError(
        f"wall: {radius - clearance:.3g} mm fills the container at height {heights[worst]:.1f} mm, "
        f"where less than {radius:.2f} mm fits; ask for a thinner wall there"
    )


def _widest(
    wall: Outside, corners: np.ndarray, centre: np.ndarray, half: np.ndarray, heights: np.ndarray
) -> np.ndarray:
    """Return for each height x, y, the clearance and the distance to the outside (n, 4) where the clearance is largest.

    Only points inside the body count, in a rectangle about a centre.
    """
    grid = np.stack(np.meshgrid(*(np.linspace(-1.0, 1.0, ACROSS),) * 2, indexing="ij"), axis=-1).reshape(-1, 2)
    places = centre + grid * half
    inside = within(places, heights, corners)
    best = np.tile(np.array([*centre, -np.inf, 0.0]), (len(heights), 1))
    column, layer = np.nonzero(inside)
    points = np.column_stack([places[column], heights[layer]])
    found = wall.clearance(points)
    order = np.argsort(found.clearance_mm)
    best[layer[order]] = np.column_stack([points[:, :2], found.clearance_mm, found.distance_mm])[order]
    return best


def within(places: np.ndarray, heights: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return which points above places (n, 2) at heights (k,) lie inside a body (n, k).

    The body is bounded by triangles (m, 3, 3), closed but for a mouth on top: a line straight down from a point inside
    meets an odd number of them.
    """
    inside = np.zeros((len(places), len(heights)), dtype=bool)
    low, high = corners[:, :, :2].min(axis=1), corners[:, :, :2].max(axis=1)
    # A line through a corner or side would be counted twice or not at all; none is that unlucky a little aside.
    for k, (x, y) in enumerate(places + 1e-7 * np.sqrt([2.0, 3.0])):
        near = np.flatnonzero((low[:, 0] <= x) & (x <= high[:, 0]) & (low[:, 1] <= y) & (y <= high[:, 1]))
        a, b, c = np.moveaxis(corners[near], 1, 0)
        shares = np.stack([_area(b, c, x, y), _area(c, a, x, y), _area(a, b, x, y)])
        hit = np.all(shares > 0.0, axis=0) | np.all(shares < 0.0, axis=0)
        crossed = (shares[:, hit] * np.stack([a, b, c])[:, hit, 2]).sum(axis=0) / shares[:, hit].sum(axis=0)
        inside[k] = np.count_nonzero(crossed[:, None] < heights, axis=0) % 2 == 1
    return inside


def _area(p: np.ndarray, q: np.ndarray, x: float, y: float) -> np.ndarray:
    return (p[:, 0] - x) * (q[:, 1] - y) - (p[:, 1] - y) * (q[:, 0] - x)
