"""Which entities a STEP file (ISO 10303-21) holds."""

from __future__ import annotations

import re
from collections import Counter

SKIPPED = re.compile(r"'(?:[^']|'')*'|/\*.*?\*/", re.DOTALL)
"""Strings and comments, in which anything may stand."""

INSTANCE = re.compile(r"#\d+\s*=\s*(?:([A-Z][A-Z0-9_]*)\s*\(|\(([^;]*)\)\s*;)")
"""A simple instance, or a complex one, which is several types at once."""

INNERMOST = re.compile(r"\([^()]*\)")

TELLING = ("RATIONAL_B_SPLINE_SURFACE", "RATIONAL_B_SPLINE_CURVE")
"""Types that say what a complex instance is; the others of theirs go without saying."""


def count_entities(text: str) -> dict[str, int]:
    """Return how often each type is there in a STEP file's text, the most frequent first.

    A complex instance counts once: by the type that tells what it is, else by all its types joined by +.
    """
    found = INSTANCE.findall(SKIPPED.sub("''", text))
    return dict(Counter(simple or _type_of(parts) for simple, parts in found).most_common())


def _type_of(parts: str) -> str:
    """Return the type of a complex instance from what stands in its parentheses."""
    while INNERMOST.search(parts):
        parts = INNERMOST.sub(" ", parts)
    types = parts.split()
    return next((name for name in TELLING if name in types), "+".join(types))
