"""How thick the wall shall be at each height and angle, as data."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.scene.validate import finite
from glassworkbench.wall.asking.asked import AskedThickness, asked_by_angle
from glassworkbench.wall.asking.interpolation import TURN_DEG, PeriodicGrid
from glassworkbench.wall.asking.limits import (
    angle_deg,
    check_ascending,
    check_covers,
    check_interpolation,
    check_not_below,
    thickness_mm,
)
from glassworkbench.wall.asking.notation import text_of, with_interpolation
from glassworkbench.wall.asking.over_height import ThicknessOverHeight

if TYPE_CHECKING:
    from glassworkbench.mold import Anatomy, Mold

Rows = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class GridThickness:
    """A table over height and angle, periodic in angle.

    Parameters
    ----------
    heights_mm : tuple of float
        At least two, ascending from the lowest point of the container; they must reach its finish.
    angles_deg : tuple of float
        At least two, ascending from 0 to 360 about the axis, counter-clockwise from the upright container's +x as seen
        from above. 0 and 360 are the same angle: where both are given, their thicknesses must agree.
    thicknesses_mm : tuple of tuple of float
        A row for each height, with a thickness for each angle.
    interpolation : {"smooth", "linear"}
        Smooth is bicubic and never leaves the range of the four values around; see `interpolation.PeriodicGrid`.
    file : str
        The name of the file it was read from, for messages; empty for none. Grids that differ in it alone are equal.

    Raises
    ------
    InputError
        If a thickness is not above 0, a number not finite, an angle beyond 0 to 360, or heights or angles do not
        ascend.
    """

    heights_mm: tuple[float, ...]
    angles_deg: tuple[float, ...]
    thicknesses_mm: tuple[tuple[float, ...], ...]
    interpolation: str = "smooth"
    file: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        heights = tuple(finite(height, "wall height_mm") for height in self.heights_mm)
        angles = tuple(angle_deg(angle, "wall grid") for angle in self.angles_deg)
        rows = tuple(tuple(thickness_mm(value, "wall thickness_mm") for value in row) for row in self.thicknesses_mm)
        if len(rows) != len(heights) or any(len(row) != len(angles) for row in rows):
            raise InputError(
                f"wall grid: it needs {len(heights)} rows of {len(angles)} thicknesses, one for each height and angle"
            )
        if len(heights) < 2:
            raise InputError("wall grid: it needs at least two heights; repeat the row where the wall is the same")
        check_ascending(heights)
        for low, high in itertools.pairwise(angles):
            if high <= low:
                raise InputError(
                    f"wall grid: angle {text_of(high)} deg follows {text_of(low)} deg; give each angle once, ascending"
                )
        angles, rows = _within_one_turn(heights, angles, rows)
        if len(angles) < 2:
            raise InputError("wall grid: it needs at least two angles; for a table over height leave the angles out")
        check_interpolation(self.interpolation)
        object.__setattr__(self, "heights_mm", heights)
        object.__setattr__(self, "angles_deg", angles)
        object.__setattr__(self, "thicknesses_mm", rows)

    @classmethod
    def from_points(
        cls,
        points: Iterable[tuple[float, float, float]],
        interpolation: str = "smooth",
        places: Iterable[str] = itertools.repeat("wall grid"),
        file: str = "",
    ) -> GridThickness:
        """Return the grid that points (height_mm, angle_deg, thickness_mm) make, given row after row.

        Parameters
        ----------
        points : iterable of (float, float, float)
        interpolation : {"smooth", "linear"}
        places : iterable of str
            What messages call each point.
        file : str
            The name of the file that all are from; empty for none.

        Raises
        ------
        InputError
            If the rows are not sorted by height, or one lacks an angle that another has; else as the class.
        """
        rows: dict[float, dict[float, float]] = {}
        first_place: dict[float, str] = {}
        previous = -np.inf
        for (height, angle, thickness), place in zip(points, places, strict=False):
            height, angle = finite(height, f"{place}, height_mm"), angle_deg(angle, f"{place}, angle_deg")
            check_not_below(previous, height, place)
            previous = height
            row = rows.setdefault(height, {})
            first_place.setdefault(height, place)
            if angle in row:
                raise InputError(
                    f"{place}: height {text_of(height)} mm, angle {text_of(angle)} deg is given twice; give it once"
                )
            row[angle] = thickness_mm(thickness, f"{place}, thickness_mm")
            _check_full_turn(height, row.get(0.0), row.get(TURN_DEG), place)
        angles = sorted({angle for row in rows.values() for angle in row})
        for height, row in rows.items():
            for angle in angles:
                if angle not in row:
                    raise InputError(
                        f"{first_place[height]}: height {text_of(height)} mm lacks angle {text_of(angle)} deg, which "
                        "another height has; give every height the same angles"
                    )
        return cls(
            tuple(rows),
            tuple(angles),
            tuple(tuple(row[angle] for angle in angles) for row in rows.values()),
            interpolation,
            file,
        )

    def __str__(self) -> str:
        text = " ".join(
            f"{text_of(height)}@{text_of(angle)}:{text_of(thickness)}"
            for height, row in zip(self.heights_mm, self.thicknesses_mm, strict=True)
            for angle, thickness in zip(self.angles_deg, row, strict=True)
        )
        return with_interpolation(text, self.interpolation)

    def on(self, mold: Mold) -> AskedThickness:
        """Return the thickness at each point of a mold's outside.

        Raises
        ------
        InputError
            If the grid does not reach from the mold's lowest point to its finish.
        """
        check_covers(self.heights_mm, mold.anatomy, self.file)
        arrays = map(np.array, (self.heights_mm, self.angles_deg, self.thicknesses_mm))
        return asked_by_angle(mold, PeriodicGrid(*arrays, smooth=self.interpolation == "smooth"))

    def over_height(self, anatomy: Anatomy) -> ThicknessOverHeight:
        """Raise: the height alone does not tell this thickness."""
        raise GlassWorkbenchError("wall: no method makes a wall that varies with the angle; give a table over height")


def _within_one_turn(
    heights: tuple[float, ...], angles: tuple[float, ...], rows: Rows
) -> tuple[tuple[float, ...], Rows]:
    """Return angles and rows with 0 deg in place of 360 deg, which is the same."""
    if not angles or angles[-1] < TURN_DEG:
        return angles, rows
    if angles[0] > 0.0:
        return (0.0, *angles[:-1]), tuple((row[-1], *row[:-1]) for row in rows)
    for height, row in zip(heights, rows, strict=True):
        _check_full_turn(height, row[0], row[-1], "wall grid")
    return angles[:-1], tuple(row[:-1] for row in rows)


def _check_full_turn(height: float, at_0: float | None, at_360: float | None, place: str) -> None:
    """Check that 0 and 360 degrees have the same thickness, where a height has both."""
    if at_0 is not None and at_360 is not None and at_0 != at_360:
        raise InputError(
            f"{place}: at height {text_of(height)} mm, 0 deg has {text_of(at_0)} mm but 360 deg, "
            f"the same angle, {text_of(at_360)} mm; leave one out"
        )
