"""The kinds of defects by the industry's names."""

from __future__ import annotations

from dataclasses import MISSING, Field, fields
from types import MappingProxyType

from glassworkbench.flaws.bubbles import Blister, Seed
from glassworkbench.flaws.cords import Cord
from glassworkbench.flaws.defect import Defect
from glassworkbench.flaws.films import Check, Split
from glassworkbench.flaws.shapes import Lean, Ovality
from glassworkbench.flaws.stones import Stone
from glassworkbench.flaws.threads import BirdSwing, Spike
from glassworkbench.flaws.walls import ChokedNeck, Slug, ThinSpot, Washboard
from glassworkbench.settings import unknown_name

IN_GLASS = (Seed, Blister, Stone, Cord, Check, Split, BirdSwing, Spike)
"""They are added to the scene of any container."""

IN_WALL = (ThinSpot, Slug, ChokedNeck, Washboard, Lean, Ovality)
"""They are made with the wall, so they are measured with it."""

KINDS: MappingProxyType[str, type[Defect]] = MappingProxyType({kind.kind: kind for kind in (*IN_GLASS, *IN_WALL)})


def kinds() -> dict[str, str]:
    """Return what each kind of defect is, by its name."""
    return {name: kind.description for name, kind in KINDS.items()}


def described(name: str) -> dict[str, object]:
    """Return what a kind is, and the keys that a file may give it, with what holds where they are not given.

    Raises
    ------
    InputError
        If there is no such kind.
    """
    if name not in KINDS:
        raise unknown_name("kind", name, KINDS)
    kind = KINDS[name]
    told: dict[str, object] = {"kind": name, "description": kind.description, "class": kind.usual_severity}
    for field in fields(kind):
        if field.name != "severity":
            told[field.name] = _default(field)
    return told


def _default(field: Field) -> object:
    if field.default is MISSING:
        return "needed"
    return "optional" if field.default is None else field.default
