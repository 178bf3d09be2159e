"""Nearest points on triangles that stand for a curved surface: native, and readable in numpy."""

from glassworkbench.spatial.bulge import SIDES, sags
from glassworkbench.spatial.nearest import Nearest, NearestTriangles

__all__ = ["SIDES", "Nearest", "NearestTriangles", "sags"]
