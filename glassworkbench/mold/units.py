"""The unit of length that a CAD file says its numbers are in."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from glassworkbench.mold.read import IGES_ENDINGS, STEP_ENDINGS

STEP_SI_LENGTH = re.compile(r"LENGTH_UNIT\s*\(\s*\)[^;]*?SI_UNIT\s*\(\s*(?:\.(\w+)\.|\$)\s*,\s*\.METRE\.")
STEP_NAMED_LENGTH = re.compile(r"CONVERSION_BASED_UNIT\s*\(\s*'(\w+)'[^;]*?LENGTH_UNIT")

IGES_FLAG, IGES_NAME = 13, 14
"""Which of an IGES file's global parameters, from 0, tell the unit."""

IGES_UNITS = {
    "1": "inch",
    "2": "millimetre",
    "4": "foot",
    "5": "mile",
    "6": "metre",
    "7": "kilometre",
    "8": "mil",
    "9": "micrometre",
    "10": "centimetre",
    "11": "microinch",
}
"""By the flag in the global section (IGES 5.3, 2.2.4.3); flag 3 leaves it to the name, and none means inch."""


def declared_unit(path: Path) -> str | None:
    """Return the length unit of a CAD file, like millimetre or inch; None for one of a kind that names none."""
    kind = path.suffix.lower()
    if kind in STEP_ENDINGS:
        return _step_unit(path.read_text(encoding="latin-1"))
    if kind in IGES_ENDINGS:
        return _iges_unit(path.read_text(encoding="latin-1"))
    # FreeCAD's documents are in mm, whatever unit it shows.
    return "millimetre" if kind == ".fcstd" else None


def _step_unit(text: str) -> str | None:
    named = STEP_NAMED_LENGTH.search(text)
    if named:
        return named.group(1).lower()
    si = STEP_SI_LENGTH.search(text)
    return f"{(si.group(1) or '').lower()}metre" if si else None


def _iges_unit(text: str) -> str | None:
    lines = [line for line in text.splitlines() if line[72:73] == "G"]
    parameters = list(_parameters("".join(line[:72].ljust(72) for line in lines)))
    if len(parameters) <= IGES_NAME:
        return None
    flag, name = parameters[IGES_FLAG].strip() or "1", parameters[IGES_NAME].strip()
    return IGES_UNITS.get(flag, name.lower() or None)


def _parameters(section: str) -> Iterator[str]:
    """Yield the parameters of a global section; a string, like 2HMM, says how long it is and may hold delimiters."""
    between, end, place, number = ",", ";", 0, 0
    while place < len(section):
        string = re.compile(r"\s*(\d+)H").match(section, place)
        start = string.end() if string else place
        stop = start + int(string[1]) if string else place
        value = section[start:stop]
        while stop < len(section) and section[stop] not in (between, end):
            value += "" if string else section[stop]
            stop += 1
        yield value
        # The first two tell the delimiters themselves.
        if string and number < 2:
            between, end = (value, end) if number == 0 else (between, value)
        if section[stop : stop + 1] == end:
            return
        place, number = stop + 1, number + 1
