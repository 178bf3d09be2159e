"""How thick the wall shall be, as data: uniform, by region, over height, over height and angle, by face; with a bore.

The text of each, `str(thickness)`, is what `thickness_text.parse_thickness` reads.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.scene.validate import finite_array, positive
from glassworkbench.settings import unknown_name
from glassworkbench.wall.asking.asked import AskedThickness, asked_by_face, asked_over_height, with_bore
from glassworkbench.wall.asking.limits import (
    check_ascending,
    check_covers,
    check_interpolation,
    face_number,
    named_pairs,
    thickness_mm,
)
from glassworkbench.wall.asking.notation import text_of, with_interpolation
from glassworkbench.wall.asking.over_height import ThicknessOverHeight
from glassworkbench.wall.asking.thickness_grid import GridThickness

if TYPE_CHECKING:
    from glassworkbench.mold import Anatomy, Mold

REGIONS = ("finish", "neck", "shoulder", "body", "stem", "heel", "base")
"""From top to bottom; a mold has some of them."""

BLEND_SHARE = 0.25
"""A region hands over to its neighbour within this share of its own height."""


@dataclass(frozen=True)
class UniformThickness:
    """The same thickness everywhere."""

    thickness_mm: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "thickness_mm", thickness_mm(self.thickness_mm, "wall"))

    def __str__(self) -> str:
        return text_of(self.thickness_mm)

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
    file : str
        The name of the file it was read from, for messages; empty for none. Tables that differ in it alone are equal.

    Raises
    ------
    InputError
        If a thickness is not above 0, a number not finite, or the heights do not ascend.
    """

    heights_mm: tuple[float, ...]
    thicknesses_mm: tuple[float, ...]
    interpolation: str = "smooth"
    file: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        heights = tuple(map(float, finite_array(self.heights_mm, (None,), "wall height_mm")))
        given = finite_array(self.thicknesses_mm, (None,), "wall thickness_mm")
        thicknesses = tuple(thickness_mm(value, "wall thickness_mm") for value in given)
        if len(heights) != len(thicknesses):
            raise InputError(
                f"wall table: {len(heights)} heights but {len(thicknesses)} thicknesses; give one for each"
            )
        if len(heights) < 2:
            raise InputError("wall table: it needs at least two rows; for a uniform wall give one number")
        check_ascending(heights)
        check_interpolation(self.interpolation)
        object.__setattr__(self, "heights_mm", heights)
        object.__setattr__(self, "thicknesses_mm", thicknesses)

    def __str__(self) -> str:
        rows = zip(self.heights_mm, self.thicknesses_mm, strict=True)
        text = " ".join(f"{text_of(height)}:{text_of(thickness)}" for height, thickness in rows)
        return with_interpolation(text, self.interpolation)

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
        check_covers(self.heights_mm, anatomy, self.file)
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
        pairs = named_pairs(self.regions, "wall regions")
        if not pairs:
            raise InputError("wall: no region is named; give one like body=2, or one number for all")
        names = [name for name, _ in pairs]
        for name in names:
            if name not in REGIONS:
                raise unknown_name("wall region", name, REGIONS)
            if names.count(name) > 1:
                raise InputError(f"wall region {name}: given twice; give it once")
        object.__setattr__(self, "regions", tuple((name, thickness_mm(value, f"wall {name}")) for name, value in pairs))

    def __str__(self) -> str:
        return " ".join(f"{name}={text_of(value)}" for name, value in self.regions)

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
                raise InputError(f"wall {name}: the mold has no {name}; it has {', '.join(reversed(anatomy.regions))}")
        hollow = {name: ends for name, ends in anatomy.regions.items() if ends[1] > anatomy.stem_top_mm}
        walls = sorted((low, high, asked[name]) for name, (low, high) in hollow.items() if name in asked)
        if not walls:
            others = ", ".join(reversed(hollow))
            raise InputError(
                f"wall: {' and '.join(asked)} of a stemmed glass stay solid; give the thickness of {others}"
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
        pairs = named_pairs(self.faces, "wall faces")
        if not pairs:
            raise InputError("wall: no face is named; give one like Face12=4, or one number for all")
        numbers = [number for number, _ in pairs]
        for number in numbers:
            face_number(number)
            if numbers.count(number) > 1:
                raise InputError(f"wall Face{number}: given twice; give it once")
        faces = tuple((number, thickness_mm(value, f"wall Face{number}")) for number, value in pairs)
        object.__setattr__(self, "faces", faces)
        object.__setattr__(self, "otherwise_mm", thickness_mm(self.otherwise_mm, "wall else"))

    def __str__(self) -> str:
        named = (f"Face{number}={text_of(value)}" for number, value in self.faces)
        return " ".join((*named, f"else={text_of(self.otherwise_mm)}"))

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
        return f"{self.wall} bore={text_of(self.bore_mm)}"

    def on(self, mold: Mold) -> AskedThickness:
        """Return the thickness at each point of a mold's outside; raises as `wall.on`, or if the bore does not fit."""
        return with_bore(self.wall.on(mold), mold, self.bore_mm)

    def over_height(self, anatomy: Anatomy) -> ThicknessOverHeight:
        """Raise: the height alone does not tell this thickness."""
        raise GlassWorkbenchError("wall bore: no method makes a prescribed bore; give finish=... as thickness instead")


Thickness = UniformThickness | TabulatedThickness | RegionalThickness | GridThickness | FaceThickness | BoredThickness
