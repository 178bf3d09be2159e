"""A wall as a title or one line of an answer can hold it; its data are in its whole text."""

from __future__ import annotations

from pathlib import Path

from glassworkbench.wall.asking.notation import text_of, with_interpolation
from glassworkbench.wall.asking.thickness import BoredThickness, GridThickness, TabulatedThickness, Thickness

LONGEST = 60
"""Longer texts are cut, in characters."""

FIRST_ROWS = 3
"""How many rows of a long table are told before the last."""


def shortened(thickness: Thickness) -> str:
    """Return a thickness in short: a table by the name of its file, or where it has none by its ends."""
    if isinstance(thickness, BoredThickness):
        return f"{shortened(thickness.wall)} bore={text_of(thickness.bore_mm)}"
    if not isinstance(thickness, (TabulatedThickness, GridThickness)):
        return _ends(str(thickness))
    if thickness.file:
        return with_interpolation(f"@{Path(thickness.file).name}", thickness.interpolation)
    rows = str(thickness).removesuffix(with_interpolation("", thickness.interpolation))
    return with_interpolation(_ends(rows), thickness.interpolation)


def _ends(text: str) -> str:
    if len(text) <= LONGEST:
        return text
    words = text.split()
    return " ".join([*words[:FIRST_ROWS], "…", words[-1]])
