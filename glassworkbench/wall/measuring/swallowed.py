"""Where a wall that is asked elsewhere swallows the outside's own: no inside can follow the outside there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.wall.candidate import HopelessError
from glassworkbench.wall.measuring.outside import Outside
from glassworkbench.wall.measuring.surface import facets

SAMPLES = 1500
"""Points of the outside that are looked at."""

MOST_SHARE = 0.15
"""More of the outside than this is not left to a wall that was asked elsewhere."""

TOLD_SHARE = 0.02
"""Less of the outside than this is lost to every thick base and is not worth a sentence."""


@dataclass(frozen=True)
class Swallowed:
    """What of the outside is lost to a thicker wall asked elsewhere.

    Parameters
    ----------
    share : float
        Of the outside's area, without mouth, embossing and a stem.
    low_mm, high_mm : float
        Heights between which it lies.
    asked_mm : float
        The smallest thickness asked there.
    thick_mm, thick_at_mm : float
        The thickest wall that takes it, and the height of the outer point where that is asked.
    """

    share: float
    low_mm: float
    high_mm: float
    asked_mm: float
    thick_mm: float
    thick_at_mm: float

    def __str__(self) -> str:
        return (
            f"{self.thick_mm:.3g} mm asked at height {self.thick_at_mm:.1f} mm swallow the wall of "
            f"{self.asked_mm:.3g} mm asked from {self.low_mm:.1f} to {self.high_mm:.1f} mm, "
            f"{100.0 * self.share:.0f} % of the outside"
        )


def swallowed(wall: Outside, stem_top_mm: float = 0.0) -> Swallowed | None:
    """Return what of the outside cannot have its own wall, or None where all of it can.

    Straight inward from an outer point, at its thickness t, lies the inner point that it asks for. Where all walls are
    alike, this comes nearer to another outer point by t at most: sharp edges and tight heels are rounded by that. If
    another wall reaches past it by more than t, that wall is the reason.
    """
    corners = wall.corners_mm
    counts = ~wall.collar & ~wall.embossed & (corners[:, :, 2].min(axis=1) >= stem_top_mm)
    if wall.thickness_mm[counts].max(initial=0.0) <= 2.0 * wall.thickness_mm[counts].min(initial=np.inf):
        return None
    numbers = np.flatnonzero(counts)
    area = np.cumsum(np.linalg.norm(facets(corners[numbers]), axis=1))
    places = (np.arange(SAMPLES) + 0.5) / SAMPLES * area[-1]
    chosen = numbers[np.minimum(np.searchsorted(area, places), len(area) - 1)]
    points, normals = corners[chosen].mean(axis=1), wall.normals[chosen].mean(axis=1)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    thickness = wall.thickness_mm[chosen].mean(axis=1)
    found = wall.clearance(points - thickness[:, None] * normals)
    lost = np.flatnonzero(found.clearance_mm < -thickness)
    if len(lost) == 0:
        return None
    reach = found.distance_mm[lost] - found.clearance_mm[lost]
    thickest = int(np.argmax(reach))
    heights = points[lost, 2]
    return Swallowed(
        share=len(lost) / SAMPLES,
        low_mm=float(heights.min()),
        high_mm=float(heights.max()),
        asked_mm=float(thickness[lost].min()),
        thick_mm=float(reach[thickest]),
        thick_at_mm=float(found.feet_mm[lost[thickest], 2]),
    )


def note_on_swallowed(wall: Outside, stem_top_mm: float) -> tuple[str, ...]:
    """Return a sentence about what of the outside loses its own wall; none where that is little.

    Raises
    ------
    HopelessError
        If it is so much that the wall is not what was asked.
    """
    lost = swallowed(wall, stem_top_mm)
    if lost is None or lost.share < TOLD_SHARE:
        return ()
    if lost.share > MOST_SHARE:
        most = lost.thick_mm * MOST_SHARE / lost.share
        raise HopelessError(f"wall: {lost}; ask for at most about {most:.2g} mm there")
    return (str(lost),)
