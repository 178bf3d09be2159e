"""Regions of a mold so low that a thickness asked of them is hardly to be seen."""

from __future__ import annotations

from glassworkbench.mold import Anatomy
from glassworkbench.wall.asking.thickness import BoredThickness, RegionalThickness, Thickness

BROAD = ("base", "finish")
"""The base's thickness holds on all of the underside, and a finish is as low as its ring."""


def notes_on_narrow_regions(thickness: Thickness, anatomy: Anatomy) -> tuple[str, ...]:
    """Return a sentence for each region that is lower than the wall asked of it is thick."""
    wall = thickness.wall if isinstance(thickness, BoredThickness) else thickness
    if not isinstance(wall, RegionalThickness):
        return ()
    return tuple(
        f"{name}={asked:g} acts on the {high - low:.2g} mm from height {low:.3g} to {high:.3g} mm only, all that this "
        f"mold has of a {name}; a table over height reaches farther"
        for name, asked in wall.regions
        for low, high in (anatomy.regions[name],)
        if name not in BROAD and high - low < asked
    )
