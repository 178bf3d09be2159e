"""From a mold and a thickness to a hollow container, measured; and containers that are hollow already."""

from glassworkbench.wall.asking.thickness import (
    BoredThickness,
    FaceThickness,
    GridThickness,
    RegionalThickness,
    TabulatedThickness,
    Thickness,
    UniformThickness,
)
from glassworkbench.wall.asking.thickness_text import parse_thickness
from glassworkbench.wall.choose import METHODS, HollowingError, hollow
from glassworkbench.wall.container import Container, WallReport
from glassworkbench.wall.existing import container_from_shape, read_container
from glassworkbench.wall.flawed import flawed_mold, flawed_thickness

__all__ = [
    "METHODS",
    "BoredThickness",
    "Container",
    "FaceThickness",
    "GridThickness",
    "HollowingError",
    "RegionalThickness",
    "TabulatedThickness",
    "Thickness",
    "UniformThickness",
    "WallReport",
    "container_from_shape",
    "flawed_mold",
    "flawed_thickness",
    "hollow",
    "parse_thickness",
    "read_container",
]
