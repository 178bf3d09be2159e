"""The container itself, the same at every station: bodies, media, and what fills it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.glass import Filling, Glass, find_filling
from glassworkbench.scene import Body, ContainerGeometry, Medium, Revolved
from glassworkbench.scene.validate import positive
from glassworkbench.staging.pose import Pose

USUAL_LEVEL = 0.8
"""Level of a filling for which none is given, as a part of the finish's height."""


@dataclass(frozen=True)
class Fill:
    """A liquid up to a level.

    Parameters
    ----------
    liquid : Filling
    level_mm : float, optional
        Height of the liquid's surface above the container's lowest point; `USUAL_LEVEL` of the finish's if None.
    """

    liquid: Filling
    level_mm: float | None = None

    def __post_init__(self) -> None:
        if self.level_mm is not None:
            object.__setattr__(self, "level_mm", positive(self.level_mm, "fill level"))

    def __str__(self) -> str:
        return self.liquid.name if self.level_mm is None else f"{self.liquid.name}:{self.level_mm:g}"


def parse_fill(text: str) -> Fill:
    """Return the fill that ``LIQUID`` or ``LIQUID:LEVEL_MM`` names.

    Raises
    ------
    InputError
        If the liquid is not known or the level is no number above 0.
    """
    liquid, colon, level = text.rpartition(":")
    try:
        level_mm = float(level.removesuffix("mm"))
    except ValueError as error:
        # A colon may also part off the name of a filling in a file, or the letter of a drive.
        if not colon or liquid.endswith(".toml") or level.endswith(".toml"):
            return Fill(find_filling(text))
        name = find_filling(liquid).name
        raise InputError(f"fill level: expected a height in mm, as {name}:180, got {level!r}") from error
    return Fill(find_filling(liquid), level_mm) if colon else Fill(find_filling(text))


def bodies(geometry: ContainerGeometry, fill: Fill | None, pose: Pose) -> tuple[Body, ...]:
    """Return the bodies outer, cavity (if it has one) and, if there is a `fill`, fill.

    The container stands in its pose; the liquid's surface stays level, and at its height where the container is
    tilted about the middle of its base.

    Raises
    ------
    InputError
        If the level does not lie below the finish, or there is no cavity to fill.
    """
    outer = Body("outer", pose.applied(geometry.outer))
    if geometry.cavity is None:
        if fill is not None:
            raise InputError(
                f"fill {fill}: the container's rim is rounded, so its inside is not known; leave the filling away, "
                "or make the container of its mold"
            )
        return (outer,)
    container = (outer, Body("cavity", pose.applied(geometry.cavity)))
    if fill is None:
        return container
    level = USUAL_LEVEL * geometry.finish_height_mm if fill.level_mm is None else fill.level_mm
    if level >= geometry.finish_height_mm:
        raise InputError(
            f"fill {fill}: the level must lie below the finish at {geometry.finish_height_mm:.4g} mm; lower it"
        )
    return (*container, Body("fill", _cylinder_around(geometry, level, pose)))


def media(geometry: ContainerGeometry, glass: Glass, fill: Fill | None) -> tuple[Medium, ...]:
    """Return the glass, and the liquid where the cavity holds it."""
    where = "outer" if geometry.cavity is None else "outer and not cavity"
    wall = Medium.of(where, glass)
    if fill is None:
        return (wall,)
    return (wall, Medium.of("cavity and fill", fill.liquid))


def _cylinder_around(geometry: ContainerGeometry, level_mm: float, pose: Pose) -> Revolved:
    """Return a cylinder wider than the container: its side and bottom bound no medium, only its top is seen."""
    reach = np.maximum(np.abs(geometry.low_mm), np.abs(geometry.high_mm))
    # Tilted, the container may lie anywhere in a ball about the middle of its base.
    radius = 1.01 * float(np.hypot(*reach[:2]) if pose.tilt_deg == 0.0 else np.linalg.norm(reach))
    bottom = float(geometry.low_mm[2]) - (0.01 if pose.tilt_deg == 0.0 else 1.0) * radius
    corners = np.array([(0.0, bottom), (radius, bottom), (radius, level_mm), (0.0, level_mm)])
    steps = np.linspace(0.0, 1.0, 4)[None, :, None]
    lines = corners[:-1, None] * (1.0 - steps) + corners[1:, None] * steps
    return Revolved(np.concatenate([lines, np.ones((3, 4, 1))], axis=2), base_mm=pose.offset_mm)
