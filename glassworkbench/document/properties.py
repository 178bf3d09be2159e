"""Properties of document objects, from tables, so that old files gain what new versions add."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

READ_ONLY = 1
HIDDEN = 4
OUTPUT = 8
"""FreeCAD's attribute bits (App::PropertyType). A change of an output property does not ask for a recompute."""


@dataclass(frozen=True)
class Property:
    """A property as the property editor shows it.

    Parameters
    ----------
    kind : str
        FreeCAD's type, like ``App::PropertyLength``.
    name, group, description : str
    attributes : int
        Sum of READ_ONLY, HIDDEN, OUTPUT.
    value : optional
        What a new object starts with.
    """

    kind: str
    name: str
    group: str
    description: str
    attributes: int = 0
    value: Any = None


def add_properties(obj: Any, properties: Iterable[Property]) -> None:
    """Give a document object those of the `properties` that it does not have yet."""
    for one in properties:
        if one.name not in obj.PropertiesList:
            obj.addProperty(one.kind, one.name, one.group, one.description, one.attributes)
            if one.value is not None:
                setattr(obj, one.name, one.value)


def set_choices(obj: Any, name: str, choices: Iterable[str]) -> None:
    """Offer `choices` in an enumeration and keep its value, even one that is no longer offered."""
    choices = list(choices)
    current = getattr(obj, name)
    if current is not None and current not in choices:
        choices.append(current)
    setattr(obj, name, choices)
    if current is not None:
        setattr(obj, name, current)
