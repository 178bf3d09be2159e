"""Lengths in station files: in mm, or in sizes of the container, so that one station serves any."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from glassworkbench.errors import InputError
from glassworkbench.scene import ContainerGeometry
from glassworkbench.scene.validate import finite
from glassworkbench.staging.directions import corners

UNITS = ("mm", "sizes", "finishes")


@dataclass(frozen=True)
class Lengths:
    """How many mm the units have in which a station may give a length.

    Parameters
    ----------
    sizes_mm : float
        The larger of the container's width and height.
    finishes_mm : float
        The finish's outer diameter.
    """

    sizes_mm: float
    finishes_mm: float

    @classmethod
    def of(cls, geometry: ContainerGeometry) -> Lengths:
        """Return the units for a container."""
        width, _, height = geometry.high_mm - geometry.low_mm
        return cls(float(max(width, height)), 2.0 * float(corners(geometry, "finish", "lengths")[:, 0].max()))

    def mm(self, table: Mapping, name: str, where: str) -> float | None:
        """Return the length (mm) that a table gives as NAME_mm, NAME_sizes or NAME_finishes, None if it gives none.

        Raises
        ------
        InputError
            If it gives more than one, or what it gives is no number; `where` it stands goes before the message.
        """
        given = [key for key in length_keys([name]) if key in table]
        if len(given) > 1:
            raise InputError(f"{where}: {' and '.join(given)} say the same; keep one")
        if not given:
            return None
        unit = {"mm": 1.0, "sizes": self.sizes_mm, "finishes": self.finishes_mm}[given[0].rpartition("_")[2]]
        return unit * finite(table[given[0]], f"{where}: {given[0]}")


def length_keys(names: Iterable[str]) -> tuple[str, ...]:
    """Return the keys under which lengths may be given."""
    return tuple(f"{name}_{unit}" for name in names for unit in UNITS)
