"""What a thickness may be at all, whatever the mold."""

from __future__ import annotations

from glassworkbench.errors import InputError
from glassworkbench.scene.validate import finite

THINNEST_MM = 0.01
"""No wall of glass is thinner; whoever asks for less has probably taken another unit."""


def thickness_mm(value: object, field: str) -> float:
    """Return `value` as a thickness in mm, or raise an InputError that names `field`."""
    number = finite(value, field)
    if number <= 0.0:
        raise InputError(f"{field}: must be above 0 mm, got {number:g}")
    if number < THINNEST_MM:
        raise InputError(f"{field}: must be at least {THINNEST_MM:g} mm, got {number:g}; lengths are in mm")
    return number
