"""What a thickness, or a table of thicknesses, may be at all."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import TYPE_CHECKING

from glassworkbench.errors import InputError
from glassworkbench.scene.validate import finite
from glassworkbench.settings import unknown_name
from glassworkbench.wall.asking.interpolation import TURN_DEG
from glassworkbench.wall.asking.notation import INTERPOLATIONS, text_of

if TYPE_CHECKING:
    from glassworkbench.mold import Anatomy

THINNEST_MM = 0.01
"""No wall of glass is thinner; whoever asks for less has probably taken another unit."""

LAND_SHARE = 0.5
"""However far a lip's rounding reaches, the sealing surface keeps at least this share of the wall."""

COVER_SLACK = 0.005
"""A table may end this share of the height short of the base or the finish; its end value holds there."""


def thickness_mm(value: object, field: str) -> float:
    """Return `value` as a thickness in mm, or raise an InputError that names `field`."""
    number = finite(value, field)
    if number <= 0.0:
        raise InputError(f"{field}: must be above 0 mm, got {number:g}")
    if number < THINNEST_MM:
        raise InputError(f"{field}: must be at least {THINNEST_MM:g} mm, got {number:g}; lengths are in mm")
    return number


def named_pairs(value: object, field: str) -> tuple[tuple[object, object], ...]:
    """Return a dictionary, or pairs of a name and a thickness, as pairs, or raise an InputError."""
    try:
        return tuple((name, thickness) for name, thickness in (value.items() if isinstance(value, Mapping) else value))
    except (TypeError, ValueError) as error:
        raise InputError(f"{field}: expected a thickness by name, like a dictionary, got {value!r}") from error


def angle_deg(value: object, field: str) -> float:
    """Return `value` as an angle from 0 to 360 degrees, or raise an InputError that names `field`."""
    number = finite(value, field)
    if not 0.0 <= number <= TURN_DEG:
        raise InputError(f"{field}: angle {text_of(number)} deg is not within 0 to 360; add or take full turns")
    return number


def face_number(value: object) -> int:
    """Return `value` as the number of a CAD face, or raise an InputError."""
    if not isinstance(value, int) or value < 1:
        raise InputError(f"wall Face{value}: faces are counted from 1; give a whole number from there")
    return value


def check_ascending(heights: tuple[float, ...]) -> None:
    """Check that the heights of a table ascend."""
    for low, high in itertools.pairwise(heights):
        check_above(low, high, "wall table")


def check_above(low: float, high: float, field: str) -> None:
    """Check that a height of a table lies above the one before."""
    if high == low:
        raise InputError(f"{field}: height {text_of(high)} mm is given twice; give each height once, sorted")
    check_not_below(low, high, field)


def check_not_below(low: float, high: float, field: str) -> None:
    """Check that a height of a table does not lie below the one before."""
    if high < low:
        raise InputError(f"{field}: height {text_of(high)} mm follows {text_of(low)} mm; sort the rows by height")


def check_covers(heights: tuple[float, ...], anatomy: Anatomy, file: str) -> None:
    """Check that the heights of a table, perhaps from a file, reach from a mold's lowest point to its finish."""
    height, low, high = anatomy.finish_height_mm, heights[0], heights[-1]
    if low > COVER_SLACK * height or high < (1.0 - COVER_SLACK) * height:
        raise InputError(
            f"{file or 'wall table'}: it covers heights {low:g} to {high:g} mm, but the container reaches from 0 to "
            f"{height:g} mm; add rows for the rest"
        )


def check_interpolation(name: str) -> None:
    """Check that there is an interpolation of this name."""
    if name not in INTERPOLATIONS:
        raise unknown_name("wall interpolation", name, INTERPOLATIONS)
