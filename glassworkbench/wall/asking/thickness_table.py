"""Tables of thicknesses from CSV files: over height, or over height and angle."""

from __future__ import annotations

import csv
from pathlib import Path

from glassworkbench.errors import InputError
from glassworkbench.wall.asking.notation import number_in
from glassworkbench.wall.asking.thickness import GridThickness, TabulatedThickness

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
    header = [cell.strip() for cell in rows[0]]
    for column in ("height_mm", "thickness_mm"):
        if column not in header:
            raise InputError(f"wall table {path}: no column {column}; the first line must name height_mm, thickness_mm")
    columns = [column for column in COLUMNS if column in header]
    for column in columns:
        if header.count(column) > 1:
            raise InputError(f"wall table {path}: the first line names {column} twice; name each column once")
    values = []
    for (number, _), row in zip(numbered[1:], rows[1:], strict=True):
        if len(row) != len(header):
            raise InputError(
                f"wall table {path}, line {number}: {len(row)} cells where the first line has {len(header)}"
            )
        cells = {column: row[header.index(column)].strip() for column in columns}
        values.append([number_in(cells[column], f"wall table {path}, line {number}, {column}") for column in columns])
    try:
        if "angle_deg" in columns:
            return GridThickness.from_points(values, interpolation)
        heights, thicknesses = tuple(row[0] for row in values), tuple(row[1] for row in values)
        return TabulatedThickness(heights, thicknesses, interpolation)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _lines(path: str | Path) -> list[tuple[int, str]]:
    """Return the lines that hold something, with their numbers."""
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not a text file"
        raise InputError(f"wall table {path}: cannot be read ({reason}); give a CSV file") from error
    numbered = [(number, line) for number, line in enumerate(lines, start=1) if line.strip()]
    if not numbered:
        raise InputError(f"wall table {path}: it is empty; the first line must name height_mm and thickness_mm")
    return numbered
