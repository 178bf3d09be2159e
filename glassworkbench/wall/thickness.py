"""How thick the wall shall be, as data: uniform, by region, over height, over height and angle, by face; with a bore.

The text of each, `str(thickness)`, is what `thickness_text.parse_thickness` reads.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.scene.validate import finite, positive
from glassworkbench.settings import unknown_name
from glassworkbench.wall.asked import AskedThickness, asked_by_angle, asked_by_face, asked_over_height, with_bore
from glassworkbench.wall.interpolation import TURN_DEG, PeriodicGrid
from glassworkbench.wall.limits import thickness_mm
from glassworkbench.wall.over_height import ThicknessOverHeight

if TYPE_CHECKING:
    from glassworkbench.mold import Anatomy, Mold

REGIONS = ("finish", "neck", "shoulder", "body", "stem", "heel", "base")

INTERPOLATIONS = ("smooth", "linear")

BLEND_SHARE = 0.25
"""A region hands over to its neighbour within this share of its own height."""

COVER_SLACK = 0.005
"""A table may end this share of the height short of the base or the finish; its end value holds there."""


@dataclass(frozen=True)
class UniformThickness:
    """The same thickness everywhere."""

    thickness_mm: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "thickness_mm", thickness_mm(self.thickness_mm, "wall"))

    def __str__(self) -> str:
        return _number(self.thickness_mm)

    def on(self, mold: Mold) -> AskedThickness:
        """Return the thickness at each point of a mold's outside."""
        return asked_over_height(mold, self.over_height(mold.anatomy))

    def over_height(self, anatomy: Anatomy) -> ThicknessOverHeight:
        """Return the thickness at each height of a mold."""
        return ThicknessOverHeight(np.zeros(1), np.array([self.thickness_mm]))


@dataclass(frozen=True)
class TabulatedThickness:
    """A table over height.

    Parameters
    ----------
    heights_mm, thicknesses_mm : tuple of float
        At least two rows, heights ascending from the lowest point of the container; they must reach its finish.
    interpolation : {"smooth", "linear"}
        Smooth is monotone and piecewise cubic: it never leaves the range of the two rows it lies between.

    Raises
    ------
    InputError
        If a thickness is not above 0, a number not finite, or the heights do not ascend.
    """

    heights_mm: tuple[float, ...]
    thicknesses_mm: tuple[float, ...]
    interpolation: str = "smooth"

    def __post_init__(self) -> None:
        heights = tuple(finite(height, "wall height_mm") for height in self.heights_mm)
        thicknesses = tuple(thickness_mm(value, "wall thickness_mm") for value in self.thicknesses_mm)
        if len(heights) != len(thicknesses):
            raise InputError(
                f"wall table: {len(heights)} heights but {len(thicknesses)} thicknesses; give one for each"
            )
        if len(heights) < 2:
            raise InputError("wall table: it needs at least two rows; for a uniform wall give one number")
        _check_ascending(heights)
        _known(self.interpolation, INTERPOLATIONS, "wall interpolation")
        object.__setattr__(self, "heights_mm", heights)
        object.__setattr__(self, "thicknesses_mm", thicknesses)

    def __str__(self) -> str:
        rows = zip(self.heights_mm, self.thicknesses_mm, strict=True)
        text = " ".join(f"{_number(height)}:{_number(thickness)}" for height, thickness in rows)
        return _with_interpolation(text, self.interpolation)

    def on(self, mold: Mold) -> AskedThickness:
        """Return the thickness at each point of a mold's outside; raises as `over_height`."""
        return asked_over_height(mold, self.over_height(mold.anatomy))

    def over_height(self, anatomy: Anatomy) -> ThicknessOverHeight:
        """Return the thickness at each height of a mold.

        Raises
        ------
        InputError
            If the table does not reach from the mold's lowest point to its finish.
        """
        _check_covers(self.heights_mm, anatomy)
        return ThicknessOverHeight(np.array(self.heights_mm), np.array(self.thicknesses_mm), self.interpolation)


@dataclass(frozen=True)
class RegionalThickness:
    """A thickness per region of the container, blended smoothly from each to the next.

    The underside inside the standing ring has the base's thickness, however high it is pushed up; where the base is
    not named, that of the lowest region which is. A stem and the foot under it stay solid whatever they are given.

    Parameters
    ----------
    regions : tuple of (str, float)
        From `REGIONS`, each at most once. A region of the mold that is not named blends between its named neighbours.
    """

    regions: tuple[tuple[str, float], ...]

    def __post_init__(self) -> None:
        pairs = tuple(self.regions.items() if isinstance(self.regions, Mapping) else self.regions)
        if not pairs:
            raise InputError("wall: no region is named; give one like body=2, or one number for all")
        names = [name for name, _ in pairs]
        for name in names:
            _known(name, REGIONS, "wall region")
            if names.count(name) > 1:
                raise InputError(f"wall region {name}: given twice; give it once")
        object.__setattr__(self, "regions", tuple((name, thickness_mm(value, f"wall {name}")) for name, value in pairs))

    def __str__(self) -> str:
        return " ".join(f"{name}={_number(value)}" for name, value in self.regions)

    def on(self, mold: Mold) -> AskedThickness:
        """Return the thickness at each point of a mold's outside; raises as `over_height`."""
        return asked_over_height(mold, self.over_height(mold.anatomy))

    def over_height(self, anatomy: Anatomy) -> ThicknessOverHeight:
        """Return the thickness at each height of a mold.

        Raises
        ------
        InputError
            If the mold lacks a region that is named, or no region is named that has a wall.
        """
        asked = dict(self.regions)
        for name in asked:
            if name not in anatomy.regions:
                raise InputError(f"wall {name}: the mold has no {name}; it has {', '.join(anatomy.regions)}")
        hollow = {name: ends for name, ends in anatomy.regions.items() if ends[1] > anatomy.stem_top_mm}
        walls = sorted((low, high, asked[name]) for name, (low, high) in hollow.items() if name in asked)
        if not walls:
            raise InputError(
                f"wall: {' and '.join(asked)} of a stemmed glass stay solid; give the thickness of {', '.join(hollow)}"
            )
        rows: dict[float, float] = {}
        for low, high, value in walls:
            inset = BLEND_SHARE * (high - low)
            rows[low + inset] = value
            rows[high - inset] = value
        heights = np.array(sorted(rows))
        thicknesses = np.array([rows[height] for height in heights])
        return ThicknessOverHeight(heights, thicknesses, underside_mm=walls[0][2])


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

    def __post_init__(self) -> None:
        heights = tuple(finite(height, "wall height_mm") for height in self.heights_mm)
        angles = tuple(finite(angle, "wall angle_deg") for angle in self.angles_deg)
        rows = tuple(tuple(thickness_mm(value, "wall thickness_mm") for value in row) for row in self.thicknesses_mm)
        if len(rows) != len(heights) or any(len(row) != len(angles) for row in rows):
            raise InputError(
                f"wall grid: it needs {len(heights)} rows of {len(angles)} thicknesses, one for each height and angle"
            )
        if len(heights) < 2:
            raise InputError("wall grid: it needs at least two heights; repeat the row where the wall is the same")
        _check_ascending(heights)
        for angle in angles:
            if not 0.0 <= angle <= TURN_DEG:
                raise InputError(
                    f"wall grid: angle {_number(angle)} deg is not within 0 to 360; add or take full turns"
                )
        for low, high in itertools.pairwise(angles):
            if high <= low:
                raise InputError(
                    f"wall grid: angle {_number(high)} deg follows {_number(low)} deg; give each angle once, ascending"
                )
        if angles and angles[-1] == TURN_DEG:
            if angles[0] == 0.0:
                for height, row in zip(heights, rows, strict=True):
                    if row[0] != row[-1]:
                        raise InputError(
                            f"wall grid: at height {_number(height)} mm, 0 deg has {_number(row[0])} mm but 360 deg, "
                            f"the same angle, {_number(row[-1])} mm; leave one out"
                        )
                rows = tuple(row[:-1] for row in rows)
                angles = angles[:-1]
            else:
                rows = tuple((row[-1], *row[:-1]) for row in rows)
                angles = (0.0, *angles[:-1])
        if len(angles) < 2:
            raise InputError("wall grid: it needs at least two angles; for a table over height leave the angles out")
        _known(self.interpolation, INTERPOLATIONS, "wall interpolation")
        object.__setattr__(self, "heights_mm", heights)
        object.__setattr__(self, "angles_deg", angles)
        object.__setattr__(self, "thicknesses_mm", rows)

    @classmethod
    def from_points(cls, points: Iterable[tuple[float, float, float]], interpolation: str = "smooth") -> GridThickness:
        """Return the grid that points (height_mm, angle_deg, thickness_mm) make, given row after row.

        Raises
        ------
        InputError
            If the rows are not sorted by height, or one lacks an angle that another has; else as the class.
        """
        rows: dict[float, dict[float, float]] = {}
        previous = -np.inf
        for height, angle, thickness in points:
            height, angle = finite(height, "wall height_mm"), finite(angle, "wall angle_deg")
            if height < previous:
                _check_ascending((previous, height))
            previous = height
            row = rows.setdefault(height, {})
            if angle in row:
                raise InputError(
                    f"wall grid: height {_number(height)} mm, angle {_number(angle)} deg is given twice; give it once"
                )
            row[angle] = thickness
        angles = sorted({angle for row in rows.values() for angle in row})
        for height, row in rows.items():
            for angle in angles:
                if angle not in row:
                    raise InputError(
                        f"wall grid: height {_number(height)} mm lacks angle {_number(angle)} deg, which another "
                        "height has; give every height the same angles"
                    )
        return cls(
            tuple(rows),
            tuple(angles),
            tuple(tuple(row[angle] for angle in angles) for row in rows.values()),
            interpolation,
        )

    def __str__(self) -> str:
        text = " ".join(
            f"{_number(height)}@{_number(angle)}:{_number(thickness)}"
            for height, row in zip(self.heights_mm, self.thicknesses_mm, strict=True)
            for angle, thickness in zip(self.angles_deg, row, strict=True)
        )
        return _with_interpolation(text, self.interpolation)

    def on(self, mold: Mold) -> AskedThickness:
        """Return the thickness at each point of a mold's outside.

        Raises
        ------
        InputError
            If the grid does not reach from the mold's lowest point to its finish.
        """
        _check_covers(self.heights_mm, mold.anatomy)
        arrays = map(np.array, (self.heights_mm, self.angles_deg, self.thicknesses_mm))
        return asked_by_angle(mold, PeriodicGrid(*arrays, smooth=self.interpolation == "smooth"))

    def over_height(self, anatomy: Anatomy) -> ThicknessOverHeight:
        """Raise: the height alone does not tell this thickness."""
        raise GlassWorkbenchError("wall: no method makes a wall that varies with the angle; give a table over height")


@dataclass(frozen=True)
class FaceThickness:
    """A thickness per CAD face: a step across sharp edges, a smooth blend across smooth ones.

    Parameters
    ----------
    faces : tuple of (int, float)
        Numbers as FreeCAD counts the faces of the mold's solid, from 1, each at most once.
    otherwise_mm : float
        Of all faces that are not named.
    """

    faces: tuple[tuple[int, float], ...]
    otherwise_mm: float

    def __post_init__(self) -> None:
        pairs = tuple(self.faces.items() if isinstance(self.faces, Mapping) else self.faces)
        if not pairs:
            raise InputError("wall: no face is named; give one like Face12=4, or one number for all")
        numbers = [number for number, _ in pairs]
        for number in numbers:
            if not isinstance(number, int) or number < 1:
                raise InputError(f"wall Face{number}: faces are counted from 1; give a whole number")
            if numbers.count(number) > 1:
                raise InputError(f"wall Face{number}: given twice; give it once")
        faces = tuple((number, thickness_mm(value, f"wall Face{number}")) for number, value in pairs)
        object.__setattr__(self, "faces", faces)
        object.__setattr__(self, "otherwise_mm", thickness_mm(self.otherwise_mm, "wall else"))

    def __str__(self) -> str:
        named = (f"Face{number}={_number(value)}" for number, value in self.faces)
        return " ".join((*named, f"else={_number(self.otherwise_mm)}"))

    def on(self, mold: Mold) -> AskedThickness:
        """Return the thickness at each point of a mold's outside.

        Raises
        ------
        InputError
            If the mold has no CAD faces, or not those that are named, or one of them closes the mouth.
        """
        return asked_by_face(mold, dict(self.faces), self.otherwise_mm)

    def over_height(self, anatomy: Anatomy) -> ThicknessOverHeight:
        """Raise: the height alone does not tell this thickness."""
        raise GlassWorkbenchError("wall: no method makes a wall that varies by face; give a table over height")


@dataclass(frozen=True)
class BoredThickness:
    """Any thickness, with a bore prescribed for the finish.

    Parameters
    ----------
    wall : UniformThickness, TabulatedThickness, RegionalThickness, GridThickness or FaceThickness
    bore_mm : float
        Diameter of the inside of the finish; see `bore.bore_in` for how far down it reaches.
    """

    wall: UniformThickness | TabulatedThickness | RegionalThickness | GridThickness | FaceThickness
    bore_mm: float

    def __post_init__(self) -> None:
        if isinstance(self.wall, BoredThickness):
            raise InputError("wall bore: given twice; give it once")
        object.__setattr__(self, "bore_mm", positive(self.bore_mm, "wall bore"))

    def __str__(self) -> str:
        return f"{self.wall} bore={_number(self.bore_mm)}"

    def on(self, mold: Mold) -> AskedThickness:
        """Return the thickness at each point of a mold's outside; raises as `wall.on`, or if the bore does not fit."""
        return with_bore(self.wall.on(mold), mold, self.bore_mm)

    def over_height(self, anatomy: Anatomy) -> ThicknessOverHeight:
        """Raise: the height alone does not tell this thickness."""
        raise GlassWorkbenchError("wall bore: no method makes a prescribed bore; give finish=... as thickness instead")


Thickness = UniformThickness | TabulatedThickness | RegionalThickness | GridThickness | FaceThickness | BoredThickness


def _check_ascending(heights: tuple[float, ...]) -> None:
    for low, high in itertools.pairwise(heights):
        if high == low:
            raise InputError(f"wall table: height {_number(high)} mm is given twice; give each height once, sorted")
        if high < low:
            raise InputError(
                f"wall table: height {_number(high)} mm follows {_number(low)} mm; sort the rows by height"
            )


def _check_covers(heights: tuple[float, ...], anatomy: Anatomy) -> None:
    height, low, high = anatomy.finish_height_mm, heights[0], heights[-1]
    if low > COVER_SLACK * height or high < (1.0 - COVER_SLACK) * height:
        raise InputError(
            f"wall table: it covers heights {low:g} to {high:g} mm, but the container reaches from 0 to "
            f"{height:g} mm; add rows for the rest"
        )


def _known(name: str, names: tuple[str, ...], field: str) -> None:
    if name not in names:
        raise unknown_name(field, name, names)


def _with_interpolation(text: str, interpolation: str) -> str:
    return text if interpolation == "smooth" else f"{text} {interpolation}"


def _number(value: float) -> str:
    return repr(value).removesuffix(".0")
