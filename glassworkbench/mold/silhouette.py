"""The outline of an upright body: its largest radius at each height, and what can be read from it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

STEM_SHARE = 0.35
"""A waist thinner than this share of what is above and below it is a stem; bottle necks are above 0.9 of the finish."""

TALL_HEEL_SHARE = 0.15
"""A heel higher than this share of the body's diameter is none: the body widens slowly above its true heel."""

HIGHEST_HEEL_SHARE, HIGHEST_BASE_SHARE = 0.25, 0.06
"""Bodies that widen all the way up, like bowls, end their heel and base at these shares of the diameter."""


@dataclass(frozen=True)
class Stem:
    """Where a stemmed glass is thinnest, and the height at which the stem has opened to twice that radius."""

    thinnest_mm: float
    top_mm: float


def silhouette(vertices_mm: np.ndarray, triangles: np.ndarray, levels: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Return heights (levels,) and the largest distance from the z axis (levels,) of a closed mesh there.

    The levels are centred, so that none of them falls into a flat end.
    """
    heights = _levels(vertices_mm, levels)
    radii = np.zeros(levels)
    for level, start, end in _sections(vertices_mm, triangles, heights):
        for point in (start, end):
            np.maximum.at(radii, level, np.hypot(point[:, 0], point[:, 1]))
    return heights, radii


def radius_spread(vertices_mm: np.ndarray, triangles: np.ndarray, low_mm: float) -> tuple[float, np.ndarray]:
    """Return the largest difference of the radii at one height above `low_mm`, and the farthest point (3,) there."""
    heights = _levels(vertices_mm, 400)
    nearest, farthest = np.full(len(heights), np.inf), np.zeros(len(heights))
    places = np.zeros((len(heights), 3))
    for level, start, end in _sections(vertices_mm, triangles, heights):
        along = (end - start)[:, :2]
        length_squared = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
        share = np.clip(-np.einsum("ij,ij->i", start[:, :2], along) / length_squared, 0.0, 1.0)
        closest = start[:, :2] + share[:, None] * along
        np.minimum.at(nearest, level, np.hypot(closest[:, 0], closest[:, 1]))
        distance = np.hypot(start[:, 0], start[:, 1])
        order = np.argsort(distance)
        farther = order[distance[order] > farthest[level[order]]]
        farthest[level[farther]] = distance[farther]
        places[level[farther]] = start[farther]
    spread = np.where((heights > low_mm) & np.isfinite(nearest), farthest - nearest, 0.0)
    widest = int(np.argmax(spread))
    return float(spread[widest]), places[widest]


def _levels(vertices_mm: np.ndarray, levels: int) -> np.ndarray:
    low, high = vertices_mm[:, 2].min(), vertices_mm[:, 2].max()
    return low + (high - low) * (np.arange(levels) + 0.5) / levels


def _sections(
    vertices_mm: np.ndarray, triangles: np.ndarray, heights: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield batches of level numbers (n,) and the ends (n, 3) of the segments in which triangles meet those levels."""
    corners = vertices_mm[triangles]
    order = np.argsort(corners[:, :, 2], axis=1)
    low, middle, high = np.moveaxis(np.take_along_axis(corners, order[:, :, None], axis=1), 1, 0)
    level = np.searchsorted(heights, low[:, 2], side="left")
    past = np.searchsorted(heights, high[:, 2], side="left")
    while np.any(level < past):
        left = level < past
        level, past, low, middle, high = level[left], past[left], low[left], middle[left], high[left]
        height = heights[level]
        lower_half = height < middle[:, 2]
        start = np.where(lower_half[:, None], low, middle)
        end = np.where(lower_half[:, None], middle, high)
        yield level, _at_height(low, high, height), _at_height(start, end, height)
        level = level + 1


def _at_height(start: np.ndarray, end: np.ndarray, height: np.ndarray) -> np.ndarray:
    rise = end[:, 2] - start[:, 2]
    share = np.where(rise > 0.0, (height - start[:, 2]) / np.where(rise > 0.0, rise, 1.0), 0.0)
    return start + share[:, None] * (end - start)


def find_stem(heights_mm: np.ndarray, radii_mm: np.ndarray) -> Stem | None:
    """Return the stem between a foot and a bowl, or None for a body without."""
    below = np.maximum.accumulate(radii_mm)
    above = np.maximum.accumulate(radii_mm[::-1])[::-1]
    waist = radii_mm / np.minimum(below, above)
    thinnest = int(np.argmin(waist))
    if waist[thinnest] > STEM_SHARE:
        return None
    opened = np.flatnonzero(radii_mm[thinnest:] > 2.0 * radii_mm[thinnest])
    return Stem(float(heights_mm[thinnest]), float(heights_mm[thinnest + opened[0]]))


def find_regions(heights_mm: np.ndarray, radii_mm: np.ndarray, stem: Stem | None) -> dict[str, tuple[float, float]]:
    """Return the heights (low, high) in mm of the regions there are, from bottom to top, without gaps.

    `base` ends where the outside, followed from below, has turned from facing down to facing sideways (45 degrees);
    `heel` where it reaches the body's width or, if the body tapers, its slope; `shoulder` begins where the width leaves
    the body's; `neck` where it has come down to the neck's; `finish` where the neck widens to its ring or thread, or
    near the top where it does not.
    A push-up belongs to the base although it rises above it. A stemmed glass has `base` (the foot) and `stem` below
    its body.
    """
    step = heights_mm[1] - heights_mm[0]
    bottom, top = 0.0, heights_mm[-1] + 0.5 * step
    cuts: list[tuple[str, float]] = []
    if stem is not None:
        thin = int(np.searchsorted(heights_mm, stem.thinnest_mm))
        foot = np.flatnonzero(radii_mm[: thin + 1] > 2.0 * radii_mm[thin])
        foot_top = heights_mm[foot[-1]] if len(foot) else bottom
        cuts += [("base", foot_top), ("stem", stem.top_mm)]
        lowest_body = int(np.searchsorted(heights_mm, stem.top_mm))
    else:
        widest = radii_mm[: max(1, len(radii_mm) * 2 // 3)].max()
        heel = _heel_end(heights_mm, radii_mm, widest)
        turned = np.flatnonzero(np.diff(radii_mm[: heel + 1]) > step)
        base_top = heights_mm[turned[-1] + 1] if len(turned) else bottom + 0.3 * (heights_mm[heel] - bottom)
        base_top = min(base_top, 2.0 * HIGHEST_BASE_SHARE * widest, 0.5 * heights_mm[heel])
        cuts += [("base", max(base_top, bottom + 0.25 * step)), ("heel", heights_mm[heel] + 0.5 * step)]
        lowest_body = heel
    body_radius = radii_mm[lowest_body:].max()
    finish = _finish_start(heights_mm, radii_mm)
    if stem is None and radii_mm[finish] < 0.95 * body_radius:
        neck_radius = radii_mm[max(lowest_body, finish - max(1, int(3.0 / step))) : finish + 1].min()
        shoulder = int(np.flatnonzero(radii_mm[: finish + 1] > 0.98 * body_radius)[-1])
        waist = shoulder + int(np.argmin(radii_mm[shoulder : finish + 1]))
        # A vase's neck flares again toward its mouth.
        neck_end = waist if radii_mm[waist] < 0.9 * neck_radius else finish
        wide = np.flatnonzero(radii_mm[shoulder : neck_end + 1] > neck_radius + 0.06 * (body_radius - neck_radius))
        neck = min(shoulder + int(wide[-1]) if len(wide) else shoulder, finish)
        cuts += [("body", heights_mm[shoulder]), ("shoulder", heights_mm[neck]), ("neck", heights_mm[finish])]
    else:
        cuts += [("body", heights_mm[finish])]
    cuts += [("finish", top)]
    regions = {}
    low = bottom
    for name, high in cuts:
        if high > low:
            regions[name] = (float(low), float(high))
            low = high
    return regions


def _heel_end(heights_mm: np.ndarray, radii_mm: np.ndarray, widest_mm: float) -> int:
    """Return the level where the heel ends.

    That is where the outline reaches the body's width. If it does so too far up, the body tapers or carries a ring:
    then it is the bend of the outline, where that stands out the most from the line to its widest place.
    """
    wide = int(np.argmax(radii_mm > 0.998 * widest_mm))
    if heights_mm[wide] <= 2.0 * TALL_HEEL_SHARE * widest_mm:
        return wide
    ends = [0, wide]
    bend = int(np.argmax((radii_mm - np.interp(heights_mm, heights_mm[ends], radii_mm[ends]))[: wide + 1]))
    highest = int(np.searchsorted(heights_mm, 2.0 * HIGHEST_HEEL_SHARE * widest_mm))
    return min(bend, highest)


def _finish_start(heights_mm: np.ndarray, radii_mm: np.ndarray) -> int:
    """Return the level where the finish begins: under its ring if it has one."""
    height = heights_mm[-1]
    near_top = np.flatnonzero(heights_mm > 0.8 * height)
    top_radius = radii_mm[heights_mm > 0.97 * height].max()
    waist = near_top[int(np.argmin(radii_mm[near_top]))]
    if radii_mm[waist] < 0.985 * top_radius and waist < near_top[-1] and heights_mm[waist] < 0.985 * height:
        widened = np.flatnonzero(radii_mm[waist:] > 0.5 * (radii_mm[waist] + top_radius))
        return waist + int(widened[0]) if len(widened) else int(waist)
    return int(np.searchsorted(heights_mm, height - min(0.06 * height, top_radius)))
