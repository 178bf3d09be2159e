"""From a mold and a thickness to a hollow container, measured."""

from glassworkbench.wall.choose import METHODS, hollow
from glassworkbench.wall.container import Container, WallReport
from glassworkbench.wall.thickness import (
    RegionalThickness,
    TabulatedThickness,
    Thickness,
    UniformThickness,
    parse_thickness,
)

__all__ = [
    "METHODS",
    "Container",
    "RegionalThickness",
    "TabulatedThickness",
    "Thickness",
    "UniformThickness",
    "WallReport",
    "hollow",
    "parse_thickness",
]
