"""Reads a thickness from its text: that of the command line, of scene files and of the property editor."""

from __future__ import annotations

import re
from collections.abc import Sequence

from glassworkbench.errors import InputError
from glassworkbench.settings import nearest_name
from glassworkbench.wall.asking.limits import face_number
from glassworkbench.wall.asking.notation import INTERPOLATIONS, number_in
from glassworkbench.wall.asking.thickness import (
    REGIONS,
    BoredThickness,
    FaceThickness,
    GridThickness,
    RegionalThickness,
    TabulatedThickness,
    Thickness,
    UniformThickness,
)
from glassworkbench.wall.asking.thickness_table import read_thickness_table


def parse_thickness(text: str, regions: Sequence[str] = REGIONS) -> Thickness:
    """Read a wall specification.

    Parameters
    ----------
    text : str
        ``3`` or ``3mm``; ``finish=2.5 body=2 heel=4 base=5`` by region; ``Face12=4 else=2`` by face; ``@wall.csv``, a
        table with columns height_mm, thickness_mm and perhaps angle_deg; or the table itself, ``0:5 40:2 300:3``
        (height:thickness) or ``0@0:5 0@180:4 300@0:3 300@180:2`` (height@angle:thickness). A table may end in
        ``linear``, and all may have a bore, ``bore=18.5``.
        ``parse_thickness(str(thickness)) == thickness`` for every thickness.
    regions : sequence of str
        Those that there are, top down; where the mold is known, its own.

    Raises
    ------
    InputError
        If the text is none of these, or a number in it is impossible.
    """
    text = text.strip()
    if not text:
        raise InputError("wall: it is empty; give a thickness in mm, like 3")
    text, ending = _ending(text) if text.startswith("@") else _without_bore(text)
    bores = [word.removeprefix("bore=") for word in ending if word.startswith("bore=")]
    interpolations = [word for word in ending if word in INTERPOLATIONS]
    if len(bores) > 1:
        raise InputError("wall bore: given twice; give it once")
    if not text:
        raise InputError("wall: a bore alone says nothing of the rest; give a thickness, too, like 3 bore=18.5")
    wall = _wall(text, interpolations, regions)
    return BoredThickness(wall, number_in(bores[0], "wall bore")) if bores else wall


def table_file(text: str) -> str | None:
    """Return the name of the CSV file that a wall specification refers to, None for one without."""
    text = text.strip()
    return _ending(text)[0][1:].strip() if text.startswith("@") else None


def _wall(text: str, interpolations: list[str], regions: Sequence[str]) -> Thickness:
    if text.startswith("@"):
        return read_thickness_table(text[1:].strip(), *interpolations[:1])
    words = text.split()
    if any(":" in word for word in words):
        interpolation = words.pop() if words[-1] in INTERPOLATIONS else "smooth"
        return _grid(words, interpolation) if "@" in words[0] else _table(words, interpolation)
    if any("=" in word for word in words):
        return _by_name(words, regions)
    return UniformThickness(number_in(text, "wall"))


def _ending(text: str) -> tuple[str, list[str]]:
    """Part a file's name, which may hold spaces, from the words for bore and interpolation behind it."""
    ending = []
    while True:
        head, _, last = text.rpartition(" ")
        if not head or not (last in INTERPOLATIONS or last.startswith("bore=")):
            return text, ending
        text = head.rstrip()
        ending.append(last)


def _without_bore(text: str) -> tuple[str, list[str]]:
    words = text.split()
    bores = [word for word in words if word.startswith("bore=")]
    return " ".join(word for word in words if word not in bores), bores


def _table(words: list[str], interpolation: str) -> TabulatedThickness:
    pairs = []
    for word in words:
        height, colon, thickness = word.partition(":")
        if not colon:
            raise InputError(f"wall {word!r}: expected height:thickness in mm, like 120:2.5")
        pairs.append((number_in(height, f"wall {word!r}"), number_in(thickness, f"wall {word!r}")))
    heights, thicknesses = zip(*pairs, strict=True)
    return TabulatedThickness(heights, thicknesses, interpolation)


def _grid(words: list[str], interpolation: str) -> GridThickness:
    points = []
    for word in words:
        parts = re.fullmatch(r"([^@:]+)@([^@:]+):([^@:]+)", word)
        if not parts:
            raise InputError(f"wall {word!r}: expected height@angle:thickness in mm and degrees, like 120@90:2.5")
        points.append(tuple(number_in(part, f"wall {word!r}") for part in parts.groups()))
    return GridThickness.from_points(points, interpolation)


def _by_name(words: list[str], known: Sequence[str]) -> RegionalThickness | FaceThickness:
    regions, faces, others = [], [], []
    for word in words:
        name, equals, value = word.partition("=")
        if not equals:
            raise InputError(f"wall {word!r}: expected region=thickness, like body=2")
        face = re.fullmatch(r"Face(\d+)", name)
        if not face and name not in (*REGIONS, "else"):
            raise _unknown_region(name, known)
        thickness = number_in(value, f"wall {name}")
        if face:
            faces.append((face_number(int(face[1])), thickness))
        elif name == "else":
            others.append(thickness)
        else:
            regions.append((name, thickness))
    if regions and (faces or others):
        raise InputError("wall: regions and faces do not go together; name regions, or faces and else=")
    if regions:
        return RegionalThickness(tuple(regions))
    if len(others) > 1:
        raise InputError("wall else: given twice; give it once")
    if not others:
        raise InputError("wall: the faces that are not named have no thickness; add one for all others, like else=2")
    return FaceThickness(tuple(faces), others[0])


def _unknown_region(name: str, regions: Sequence[str]) -> InputError:
    number = re.search(r"\d+", name)
    meant = nearest_name(name, (*regions, f"Face{number[0]}" if number else "Face", "else", "bore"))
    hint = f"there is {', '.join(regions)}; " + (
        "faces are Face1, Face2 and so on, with else= for all others" if meant is None else f"did you mean {meant!r}?"
    )
    return InputError(f"wall region {name!r} is not known; {hint}")
