"""What a CAD file holds: reading it, finding out how the container stands in it, its exact profile, its mesh."""

from glassworkbench.mold.anatomy import Anatomy
from glassworkbench.mold.files import read_mold
from glassworkbench.mold.inspection import inspect
from glassworkbench.mold.mold import Mold, core_meridian, mold_from_shape, outer_meridian
from glassworkbench.mold.surfaces import exact_surface
from glassworkbench.mold.tessellation import outside_mesh, tessellate, tessellate_faces

__all__ = [
    "Anatomy",
    "Mold",
    "core_meridian",
    "exact_surface",
    "inspect",
    "mold_from_shape",
    "outer_meridian",
    "outside_mesh",
    "read_mold",
    "tessellate",
    "tessellate_faces",
]
