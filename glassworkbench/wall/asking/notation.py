"""Numbers and interpolations as they stand in a wall's text or table."""

from __future__ import annotations

import re

from glassworkbench.errors import InputError

INTERPOLATIONS = ("smooth", "linear")
"""The first is understood where none is written."""


def number_in(text: str, field: str) -> float:
    """Return a number, with a decimal point or comma, perhaps followed by mm.

    Raises
    ------
    InputError
        If it is none; the message names `field`.
    """
    if not text.strip():
        raise InputError(f"{field}: it is empty; give a number, like 2.5")
    match = re.fullmatch(r"(.+?)\s*(?:mm)?", text)
    try:
        return float(match[1].replace(",", "."))
    except (TypeError, ValueError) as error:
        raise InputError(f"{field}: expected a number, like 2.5, got {text!r}") from error


def text_of(number: float) -> str:
    """Return the shortest text that is read as exactly this number."""
    return repr(number).removesuffix(".0")


def with_interpolation(text: str, interpolation: str) -> str:
    """Return the text of a table with that of its interpolation behind it."""
    return text if interpolation == INTERPOLATIONS[0] else f"{text} {interpolation}"
