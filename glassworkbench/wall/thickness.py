"""How thick the wall shall be: one number, a table over height, or a number per region."""

from __future__ import annotations

import csv
import itertools
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene.validate import finite
from glassworkbench.settings import unknown_name

if TYPE_CHECKING:
    from glassworkbench.mold import Anatomy

REGIONS = ("finish", "neck", "shoulder", "body", "heel", "base")

INTERPOLATIONS = ("smooth", "linear")

BLEND_SHARE = 0.25
"""A region hands over to its neighbour within this share of its own height."""

THINNEST_MM = 0.01
"""No wall of glass is thinner; whoever asks for less has probably taken another unit."""

COVER_SLACK = 0.005
"""A table may end this share of the height short of the base or the finish; its end value holds there."""


@dataclass(frozen=True, eq=False)
class ThicknessOverHeight:
    """The thickness asked at each height of one particular mold.

    Parameters
    ----------
    heights_mm, thicknesses_mm : array (n,)
        Heights above the lowest point, ascending, n >= 1; the end values hold beyond the ends.
    interpolation : {"smooth", "linear"}
        Smooth is monotone and piecewise cubic.
    underside_mm : float, optional
        Thickness of the base inside the ring it stands on, where that differs from what the height says: a
        push-up rises to heights that belong to the heel.
    """

    heights_mm: np.ndarray
    thicknesses_mm: np.ndarray
    interpolation: str = "smooth"
    underside_mm: float | None = None

    @property
    def uniform_mm(self) -> float | None:
        """The thickness, if it is the same everywhere."""
        values = set(map(float, self.thicknesses_mm))
        if self.underside_mm is not None:
            values.add(self.underside_mm)
        return values.pop() if len(values) == 1 else None

    @property
    def minimum_mm(self) -> float:
        """The smallest thickness asked anywhere."""
        return float(min(self.thicknesses_mm.min(), np.inf if self.underside_mm is None else self.underside_mm))

    @property
    def maximum_mm(self) -> float:
        """The largest thickness asked anywhere."""
        return float(max(self.thicknesses_mm.max(), -np.inf if self.underside_mm is None else self.underside_mm))

    def at(self, height_mm: np.ndarray, underside: np.ndarray | bool = False) -> np.ndarray:
        """Return the thickness (mm) at heights of any shape; `underside` marks points inside the standing ring."""
        thickness = self._interpolate(np.asarray(height_mm, dtype=np.float64), derivative=False)
        return thickness if self.underside_mm is None else np.where(underside, self.underside_mm, thickness)

    def slope(self, height_mm: np.ndarray, underside: np.ndarray | bool = False) -> np.ndarray:
        """Return the change of thickness per mm of height."""
        slope = self._interpolate(np.asarray(height_mm, dtype=np.float64), derivative=True)
        return slope if self.underside_mm is None else np.where(underside, 0.0, slope)

    def _interpolate(self, height_mm: np.ndarray, derivative: bool) -> np.ndarray:
        if len(self.heights_mm) == 1:
            return np.full(height_mm.shape, 0.0 if derivative else self.thicknesses_mm[0])
        if self.interpolation == "smooth":
            value, slope = monotone_cubic(self.heights_mm, self.thicknesses_mm, height_mm)
        else:
            value = np.interp(height_mm, self.heights_mm, self.thicknesses_mm)
            steps = np.diff(self.thicknesses_mm) / np.diff(self.heights_mm)
            row = np.clip(np.searchsorted(self.heights_mm, height_mm, side="right") - 1, 0, len(steps) - 1)
            beyond = (height_mm < self.heights_mm[0]) | (height_mm > self.heights_mm[-1])
            slope = np.where(beyond, 0.0, steps[row])
        return slope if derivative else value


@dataclass(frozen=True)
class UniformThickness:
    """The same thickness everywhere."""

    thickness_mm: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "thickness_mm", _thickness(self.thickness_mm, "wall"))

    def __str__(self) -> str:
        return _number(self.thickness_mm)

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
        thicknesses = tuple(_thickness(value, "wall thickness_mm") for value in self.thicknesses_mm)
        if len(heights) != len(thicknesses):
            raise InputError(
                f"wall table: {len(heights)} heights but {len(thicknesses)} thicknesses; give one for each"
            )
        if len(heights) < 2:
            raise InputError("wall table: it needs at least two rows; for a uniform wall give one number")
        for low, high in itertools.pairwise(heights):
            if high <= low:
                raise InputError(
                    f"wall table: height {_number(high)} mm follows {_number(low)} mm; sort the rows by height"
                )
        _known(self.interpolation, INTERPOLATIONS, "wall interpolation")
        object.__setattr__(self, "heights_mm", heights)
        object.__setattr__(self, "thicknesses_mm", thicknesses)

    def __str__(self) -> str:
        rows = zip(self.heights_mm, self.thicknesses_mm, strict=True)
        text = " ".join(f"{_number(height)}:{_number(thickness)}" for height, thickness in rows)
        return text if self.interpolation == "smooth" else f"{text} {self.interpolation}"

    def over_height(self, anatomy: Anatomy) -> ThicknessOverHeight:
        """Return the thickness at each height of a mold.

        Raises
        ------
        InputError
            If the table does not reach from the mold's lowest point to its finish.
        """
        height = anatomy.finish_height_mm
        low, high = self.heights_mm[0], self.heights_mm[-1]
        if low > COVER_SLACK * height or high < (1.0 - COVER_SLACK) * height:
            raise InputError(
                f"wall table: it covers heights {low:g} to {high:g} mm, but the container reaches from 0 to "
                f"{height:g} mm; add rows for the rest"
            )
        return ThicknessOverHeight(np.array(self.heights_mm), np.array(self.thicknesses_mm), self.interpolation)


@dataclass(frozen=True)
class RegionalThickness:
    """A thickness per region of the container, blended smoothly from each to the next.

    Parameters
    ----------
    regions : tuple of (str, float)
        From `REGIONS`, each at most once. A region of the mold that is not named blends between its named
        neighbours; one that the mold does not have is passed over.
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
        object.__setattr__(self, "regions", tuple((name, _thickness(value, f"wall {name}")) for name, value in pairs))

    def __str__(self) -> str:
        return " ".join(f"{name}={_number(value)}" for name, value in self.regions)

    def over_height(self, anatomy: Anatomy) -> ThicknessOverHeight:
        """Return the thickness at each height of a mold.

        Raises
        ------
        InputError
            If the mold has none of the regions named.
        """
        asked = dict(self.regions)
        present = sorted((low, high, asked[name]) for name, (low, high) in anatomy.regions.items() if name in asked)
        if not present:
            raise InputError(
                f"wall: the mold has none of the regions {', '.join(asked)}; it has {', '.join(anatomy.regions)}"
            )
        rows: dict[float, float] = {}
        for low, high, value in present:
            inset = BLEND_SHARE * (high - low)
            rows[low + inset] = value
            rows[high - inset] = value
        heights = np.array(sorted(rows))
        thicknesses = np.array([rows[height] for height in heights])
        return ThicknessOverHeight(heights, thicknesses, underside_mm=asked.get("base"))


Thickness = UniformThickness | TabulatedThickness | RegionalThickness


def parse_thickness(text: str) -> Thickness:
    """Read a wall specification.

    Parameters
    ----------
    text : str
        ``3`` or ``3mm``; ``finish=2.5 body=2 heel=4 base=5``; ``@wall.csv`` with columns height_mm and thickness_mm;
        or the table itself, ``0:5 40:2 300:3`` (height:thickness). A table may end in ``linear``.
        ``parse_thickness(str(thickness)) == thickness`` for every thickness.

    Raises
    ------
    InputError
        If the text is none of these, or a number in it is impossible.
    """
    words = text.split()
    if not words:
        raise InputError("wall: it is empty; give a thickness in mm, like 3")
    if words[0].startswith("@"):
        path, interpolation = _interpolation_after(text.strip()[1:])
        return read_thickness_table(path, interpolation)
    if any(":" in word for word in words):
        table, interpolation = _interpolation_after(text)
        return _inline_table(table.split(), interpolation)
    if any("=" in word for word in words):
        return RegionalThickness(tuple(_region(word) for word in words))
    return UniformThickness(_millimetres(text.strip(), "wall"))


def read_thickness_table(path: str | Path, interpolation: str = "smooth") -> TabulatedThickness:
    """Read a table over height from a CSV file with columns height_mm and thickness_mm.

    Semicolons or tabs may stand between the columns; then decimal commas are understood.

    Raises
    ------
    InputError
        If the file cannot be read, a column is missing, or a cell is empty or no number.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not a text file"
        raise InputError(f"wall table {path}: cannot be read ({reason}); give a CSV file") from error
    numbered = [(number, line) for number, line in enumerate(lines, start=1) if line.strip()]
    if not numbered:
        raise InputError(f"wall table {path}: it is empty; the first line must name height_mm and thickness_mm")
    delimiter = next((mark for mark in ";\t" if mark in numbered[0][1]), ",")
    rows = list(csv.reader((line for _, line in numbered), delimiter=delimiter))
    header = [cell.strip() for cell in rows[0]]
    if "angle_deg" in header:
        raise InputError(f"wall table {path}: a wall that varies with angle_deg is not supported; remove that column")
    for column in ("height_mm", "thickness_mm"):
        if column not in header:
            raise InputError(f"wall table {path}: no column {column}; the first line must name height_mm, thickness_mm")
    columns = header.index("height_mm"), header.index("thickness_mm")
    heights, thicknesses = [], []
    for (number, _), row in zip(numbered[1:], rows[1:], strict=True):
        if len(row) != len(header):
            raise InputError(
                f"wall table {path}, line {number}: {len(row)} cells where the first line has {len(header)}"
            )
        cells = [row[column].strip() for column in columns]
        heights.append(_millimetres(cells[0], f"wall table {path}, line {number}, height_mm"))
        thicknesses.append(_millimetres(cells[1], f"wall table {path}, line {number}, thickness_mm"))
    try:
        return TabulatedThickness(tuple(heights), tuple(thicknesses), interpolation)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def monotone_cubic(knots: np.ndarray, values: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Interpolate without overshoot; the end values hold beyond the ends.

    Parameters
    ----------
    knots, values : array (n,)
        Knots ascending, n >= 2.
    x : array
        Where to interpolate, any shape.

    Returns
    -------
    value, slope : array
        Shaped like x.

    Notes
    -----
    Piecewise cubic Hermite interpolation (PCHIP), slopes by Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5 (1984)
    300: weighted harmonic means of the neighbouring secants; at the ends the three-point formula, limited as by
    Moler, Numerical Computing with MATLAB (2004), section 3.6.
    """
    steps = np.diff(knots)
    secants = np.diff(values) / steps
    slopes = np.full(len(knots), secants[0])
    if len(steps) > 1:
        before, after = secants[:-1], secants[1:]
        same = before * after > 0.0
        weight_before, weight_after = 2 * steps[1:] + steps[:-1], steps[1:] + 2 * steps[:-1]
        inverse = weight_before / np.where(same, before, 1.0) + weight_after / np.where(same, after, 1.0)
        slopes[1:-1] = np.where(same, (weight_before + weight_after) / inverse, 0.0)
        slopes[0] = _end_slope(steps[0], steps[1], secants[0], secants[1])
        slopes[-1] = _end_slope(steps[-1], steps[-2], secants[-1], secants[-2])

    row = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(steps) - 1)
    step, start, secant = steps[row], slopes[row], secants[row]
    u = np.clip((x - knots[row]) / step, 0.0, 1.0)
    quadratic = 3 * secant - 2 * start - slopes[row + 1]
    cubic = start + slopes[row + 1] - 2 * secant
    value = values[row] + step * u * (start + u * (quadratic + u * cubic))
    slope = start + u * (2 * quadratic + u * 3 * cubic)
    return value, np.where((x < knots[0]) | (x > knots[-1]), 0.0, slope)


def _end_slope(step: float, next_step: float, secant: float, next_secant: float) -> float:
    slope = ((2 * step + next_step) * secant - step * next_secant) / (step + next_step)
    if slope * secant <= 0.0:
        return 0.0
    if secant * next_secant <= 0.0 and abs(slope) > 3 * abs(secant):
        return 3 * secant
    return slope


def _inline_table(words: list[str], interpolation: str) -> TabulatedThickness:
    pairs = []
    for word in words:
        height, colon, thickness = word.partition(":")
        if not colon:
            raise InputError(f"wall {word!r}: expected height:thickness in mm, like 120:2.5")
        pairs.append((_millimetres(height, f"wall {word!r}"), _millimetres(thickness, f"wall {word!r}")))
    heights, thicknesses = zip(*pairs, strict=True)
    return TabulatedThickness(heights, thicknesses, interpolation)


def _interpolation_after(text: str) -> tuple[str, str]:
    head, _, last = text.strip().rpartition(" ")
    return (head.strip(), last) if head and last in INTERPOLATIONS else (text.strip(), "smooth")


def _region(word: str) -> tuple[str, float]:
    name, equals, value = word.partition("=")
    if not equals:
        raise InputError(f"wall {word!r}: expected region=thickness, like body=2")
    if name == "bore":
        raise InputError("wall bore: a prescribed bore is not supported; give finish=... as thickness instead")
    if name == "else" or re.fullmatch(r"Face\d+", name):
        raise InputError(f"wall {name}: a thickness per face is not supported; name a region: {', '.join(REGIONS)}")
    _known(name, REGIONS, "wall region")
    return name, _millimetres(value, f"wall {name}")


def _known(name: str, names: tuple[str, ...], field: str) -> None:
    if name not in names:
        raise unknown_name(field, name, names)


def _millimetres(text: str, field: str) -> float:
    match = re.fullmatch(r"(.+?)\s*(?:mm)?", text)
    try:
        return float(match[1].replace(",", "."))
    except (TypeError, ValueError) as error:
        raise InputError(f"{field}: expected a number of mm, got {text!r}") from error


def _thickness(value: object, field: str) -> float:
    number = finite(value, field)
    if number <= 0.0:
        raise InputError(f"{field}: must be above 0 mm, got {number:g}")
    if number < THINNEST_MM:
        raise InputError(f"{field}: must be at least {THINNEST_MM:g} mm, got {number:g}; lengths are in mm")
    return number


def _number(value: float) -> str:
    return repr(value).removesuffix(".0")
