"""Numbers as people write them into a wall's text or table."""

from __future__ import annotations

import re

from glassworkbench.errors import InputError


def number_in(text: str, field: str) -> float:
    """Return a number, with a decimal point or comma, perhaps followed by mm.

    Raises
    ------
    InputError
        If it is none; the message names `field`.
    """
    match = re.fullmatch(r"(.+?)\s*(?:mm)?", text)
    try:
        return float(match[1].replace(",", "."))
    except (TypeError, ValueError) as error:
        raise InputError(f"{field}: expected a number, like 2.5, got {text!r}") from error
