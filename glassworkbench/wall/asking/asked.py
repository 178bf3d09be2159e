"""The thickness asked at each point of one particular mold's outside."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from glassworkbench.mold import Mold
from glassworkbench.wall.asking.bore import Bore, bore_in, check_fits, points_around
from glassworkbench.wall.asking.by_face import ByFace, thickness_by_face
from glassworkbench.wall.asking.interpolation import PeriodicGrid, smooth_step
from glassworkbench.wall.asking.over_height import ThicknessOverHeight
from glassworkbench.wall.asking.underside import underside_of

STEM_FADE_SHARE = 0.1
"""The thickness of a stemmed glass depends on the angle fully this share of the height above the stem."""


@dataclass(frozen=True, eq=False)
class AskedThickness:
    """A thickness as data, applied to a mold.

    Parameters
    ----------
    at : callable
        Takes points of the outside (n, 3), upright, in mm, and the 1-based numbers (n,) of the CAD faces they lie on (0
        where there is none); returns the thickness (n,), mm. A bore is in it: see `bore.Bore`.
    minimum_mm, maximum_mm : float
        What is asked lies between these everywhere.
    over_height : ThicknessOverHeight or None
        The same as a function of the height alone, where it is one; a bore is not in it.
    bore : Bore or None
        The cylinder prescribed for the inside of the finish, whatever the thickness there.
    by_face : ByFace or None
        The same as thicknesses of CAD faces, where it is such and there is no bore.
    """

    at: Callable[[np.ndarray, np.ndarray], np.ndarray]
    minimum_mm: float
    maximum_mm: float
    over_height: ThicknessOverHeight | None = None
    bore: Bore | None = None
    by_face: ByFace | None = None

    @property
    def bore_radius_mm(self) -> float | None:
        """The radius prescribed for the inside of the finish."""
        return None if self.bore is None else self.bore.radius_mm


def asked_over_height(mold: Mold, over_height: ThicknessOverHeight) -> AskedThickness:
    """Return a thickness that depends on the height, but inside the standing ring may be another."""
    if over_height.underside_mm is None:

        def at(points_mm: np.ndarray, faces: np.ndarray) -> np.ndarray:
            return over_height.at(points_mm[:, 2])
    else:
        underside = underside_of(mold)

        def at(points_mm: np.ndarray, faces: np.ndarray) -> np.ndarray:
            return over_height.at(points_mm[:, 2], underside.holds(points_mm))

    return AskedThickness(at, over_height.minimum_mm, over_height.maximum_mm, over_height)


def asked_by_angle(mold: Mold, grid: PeriodicGrid) -> AskedThickness:
    """Return a thickness that depends on height and angle.

    All angles meet at the axis of the underside, and nearly so where a stem opens into the bowl; toward these the
    thickness becomes the mean over the angle, so that the inside has no pucker there.
    """
    underside = underside_of(mold)
    stem_top, fade = mold.anatomy.stem_top_mm, STEM_FADE_SHARE * mold.anatomy.height_mm
    mean = ThicknessOverHeight(
        grid.heights, grid.mean_over_angle(), interpolation="smooth" if grid.smooth else "linear"
    )

    def at(points_mm: np.ndarray, faces: np.ndarray) -> np.ndarray:
        height = points_mm[:, 2]
        thickness = grid.at(height, np.degrees(np.arctan2(points_mm[:, 1], points_mm[:, 0])))
        if stem_top > 0.0:
            share = smooth_step((height - stem_top) / fade)
        else:
            from_axis = np.hypot(points_mm[:, 0], points_mm[:, 1]) / underside.ring_radius(points_mm)
            share = np.where(underside.holds(points_mm), smooth_step(from_axis), 1.0)
        return share * thickness + (1.0 - share) * mean.at(height)

    return AskedThickness(at, float(grid.values.min()), float(grid.values.max()))


def asked_by_face(mold: Mold, named_mm: Mapping[int, float], otherwise_mm: float) -> AskedThickness:
    """Return a thickness that depends on the CAD face.

    Raises
    ------
    InputError
        As `by_face.thickness_by_face`.
    """
    by_face = thickness_by_face(mold, named_mm, otherwise_mm)
    used = by_face.thicknesses_mm[1:]
    return AskedThickness(by_face.at, float(used.min()), float(used.max()), by_face=by_face)


def with_bore(asked: AskedThickness, mold: Mold, diameter_mm: float) -> AskedThickness:
    """Return a thickness asked, with a bore of this diameter in the finish.

    Raises
    ------
    InputError
        If the bore leaves no glass somewhere.
    """
    bore = bore_in(mold, diameter_mm)
    points, numbers = points_around(bore, mold)

    def at(points_mm: np.ndarray, faces: np.ndarray) -> np.ndarray:
        radius = np.hypot(points_mm[:, 0], points_mm[:, 1])
        return bore.thickness(radius, points_mm[:, 2], asked.at(points_mm, faces))

    of_bore = at(points, numbers)
    check_fits(bore, points, of_bore)
    return dataclasses.replace(
        asked,
        at=at,
        minimum_mm=min(asked.minimum_mm, float(of_bore.min())),
        maximum_mm=max(asked.maximum_mm, float(of_bore.max())),
        by_face=None,
        bore=bore,
    )
