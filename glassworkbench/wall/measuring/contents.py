"""What a container weighs and holds, empty and filled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene import Mesh
from glassworkbench.scene.validate import positive
from glassworkbench.wall.measuring.volumes import Volume, mesh_volume, volume_below

GLASS_G_PER_CM3 = 2.5
"""Density of soda-lime container glass."""

LIQUID_G_PER_CM3 = 1.0
"""Density of water."""

LEVEL_ERROR_MM = 1e-6


@dataclass(frozen=True, eq=False)
class Cavity:
    """The room inside a container, and how much of it a liquid fills.

    Parameters
    ----------
    inside : Mesh
        Upright, closed level at the finish plane.
    """

    inside: Mesh

    @property
    def floor_mm(self) -> float:
        """The height of its lowest point."""
        return float(self.inside.vertices_mm[:, 2].min())

    @property
    def brim_mm(self) -> float:
        """The height of the finish plane."""
        return float(self.inside.vertices_mm[:, 2].max())

    def brimful(self) -> Volume:
        """Return the volume up to the finish plane."""
        return mesh_volume(self.inside)

    def filled(self, level_mm: float) -> Volume:
        """Return what a liquid fills up to a height above the container's lowest point.

        Raises
        ------
        InputError
            If the level is not between the floor and the finish plane.
        """
        if not self.floor_mm <= level_mm <= self.brim_mm + LEVEL_ERROR_MM:
            raise InputError(
                f"fill level: {level_mm:g} mm is not inside the container; "
                f"it must be from {self.floor_mm:.1f} to {self.brim_mm:.1f} mm"
            )
        return volume_below(self.inside, level_mm)

    def capacity_ml(self, level_mm: float) -> float:
        """Return the capacity up to a height; raises as `filled`."""
        return 1e-3 * self.filled(level_mm).volume_mm3

    def level_mm(self, capacity_ml: float) -> float:
        """Return the height that a quantity of liquid reaches.

        Raises
        ------
        InputError
            If it is not above 0, or more than the container holds brimful.
        """
        wanted = 1e3 * positive(capacity_ml, "capacity_ml")
        brimful = self.brimful().volume_mm3
        if wanted > brimful * (1.0 + 1e-9):
            raise InputError(f"capacity: {capacity_ml:g} ml is more than the {1e-3 * brimful:.1f} ml that fit in")
        low, high = self.floor_mm, self.brim_mm
        under, over = -wanted, brimful - wanted
        while high - low > LEVEL_ERROR_MM:
            # Regula falsi is quick where the body is straight; halving now and then keeps it from creeping.
            straight = low - under * (high - low) / max(over - under, 1e-300)
            level = float(np.clip(straight, low + 0.05 * (high - low), high - 0.05 * (high - low)))
            excess = volume_below(self.inside, level).volume_mm3 - wanted
            if excess > 0.0:
                high, over = level, excess
            else:
                low, under = level, excess
        return 0.5 * (low + high)


@dataclass(frozen=True, eq=False)
class FillPoint:
    """A container filled to a level.

    Parameters
    ----------
    level_mm : float
        Height above the container's lowest point.
    capacity_ml : float
    centre_of_gravity_mm : array (3,)
        Of glass and liquid together.
    """

    level_mm: float
    capacity_ml: float
    centre_of_gravity_mm: np.ndarray

    def to_json(self) -> dict[str, object]:
        """Return it as plain numbers."""
        return {
            "level_mm": self.level_mm,
            "capacity_ml": self.capacity_ml,
            "centre_of_gravity_mm": [float(coordinate) for coordinate in self.centre_of_gravity_mm],
        }


def centre_of_gravity(
    glass: Volume,
    liquid: Volume,
    glass_g_per_cm3: float = GLASS_G_PER_CM3,
    liquid_g_per_cm3: float = LIQUID_G_PER_CM3,
) -> np.ndarray:
    """Return the centre of gravity (3,) of a container with a liquid in it, mm."""
    glass_g, liquid_g = glass.volume_mm3 * glass_g_per_cm3, liquid.volume_mm3 * liquid_g_per_cm3
    return (glass_g * glass.centroid_mm + liquid_g * liquid.centroid_mm) / (glass_g + liquid_g)


def weight_g(glass_volume_mm3: float, density_g_per_cm3: float = GLASS_G_PER_CM3) -> float:
    """Return the weight of a glass volume."""
    return density_g_per_cm3 * 1e-3 * glass_volume_mm3
