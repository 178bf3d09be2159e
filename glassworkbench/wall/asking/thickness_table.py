"""Tables of thicknesses from CSV files: over height, or over height and angle."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from glassworkbench.errors import InputError
from glassworkbench.scene.validate import finite
from glassworkbench.wall.asking.limits import check_above, thickness_mm
from glassworkbench.wall.asking.notation import number_in
from glassworkbench.wall.asking.thickness import GridThickness, TabulatedThickness

Table = TypeVar("Table", TabulatedThickness, GridThickness)

COLUMNS = ("height_mm", "angle_deg", "thickness_mm")


def read_thickness_table(path: str | Path, interpolation: str = "smooth") -> TabulatedThickness | GridThickness:
    """Read a table from a CSV file with columns height_mm and thickness_mm, and angle_deg for a grid.

    Semicolons or tabs may stand between the columns; then decimal commas are understood.

    Raises
    ------
    InputError
        If the file cannot be read, a column is missing, a cell is empty or no number, or the table is impossible.
    """
    numbered = _lines(path)
    delimiter = next((mark for mark in ";\t" if mark in numbered[0][1]), ",")
    rows = list(csv.reader((line for _, line in numbered), delimiter=delimiter))
    places = [f"{path}, line {number}" for number, _ in numbered]
    header = [cell.strip() for cell in rows[0]]
    for column in ("height_mm", "thickness_mm"):
        if column not in header:
            raise InputError(f"{places[0]}: no column {column}; the first line must name height_mm, thickness_mm")
    columns = [column for column in COLUMNS if column in header]
    for column in columns:
        if header.count(column) > 1:
            raise InputError(f"{places[0]}: it names {column} twice; name each column once")
    values = []
    for place, row in zip(places[1:], rows[1:], strict=True):
        if len(row) != len(header):
            cells = "one cell" if len(row) == 1 else f"{len(row)} cells"
            raise InputError(f"{place}: it has {cells} where the first line has {len(header)}; give as many")
        cells = {column: row[header.index(column)].strip() for column in columns}
        values.append([number_in(cells[column], f"{place}, {column}") for column in columns])
    if "angle_deg" in columns:
        return _located(path, lambda: GridThickness.from_points(values, interpolation, places[1:], str(path)))
    _check_rows(values, places[1:])
    heights, thicknesses = tuple(row[0] for row in values), tuple(row[1] for row in values)
    return _located(path, lambda: TabulatedThickness(heights, thicknesses, interpolation, str(path)))


def _check_rows(rows: Sequence[Sequence[float]], places: Sequence[str]) -> None:
    """Check each row (height, thickness) of a table over height, so that an error names its line."""
    previous = -math.inf
    for (height, thickness), place in zip(rows, places, strict=True):
        finite(height, f"{place}, height_mm")
        thickness_mm(thickness, f"{place}, thickness_mm")
        check_above(previous, height, place)
        previous = height


def _located(path: str | Path, make: Callable[[], Table]) -> Table:
    """Return the table that is made; what is wrong with it as a whole names the file."""
    try:
        return make()
    except InputError as error:
        told = re.sub("^wall (table|grid): ", "", str(error))
        raise InputError(told if told.startswith(f"{path}") else f"{path}: {told}") from error


def _lines(path: str | Path) -> list[tuple[int, str]]:
    """Return the lines that hold something, with their numbers."""
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not a text file"
        raise InputError(f"{path}: it cannot be read as a wall table ({reason}); give a CSV file") from error
    numbered = [(number, line) for number, line in enumerate(lines, start=1) if line.strip()]
    if not numbered:
        raise InputError(f"{path}: it is empty; the first line must name height_mm and thickness_mm")
    return numbered
