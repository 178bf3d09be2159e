"""What the tracer sees of a CAD solid: its exact surface, or a fine mesh and a sentence that says why."""

from __future__ import annotations

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import Part
from glassworkbench.mold import exact_surface, tessellate
from glassworkbench.scene import Mesh, Patches

DEVIATION_MM = 0.015
"""Largest distance of a mesh from its surface; refraction at the facets' interpolated normals is then smooth."""

MAXIMUM_TRIANGLES = 400_000


def seen_surface(shape: Part.Shape, name: str) -> tuple[Patches | Mesh, tuple[str, ...]]:
    """Return the exact surface of a closed upright solid, or a mesh where there is none, with a note that says so.

    Parameters
    ----------
    shape : Part.Shape
    name : str
        What the shape is, as the note begins: ``"the cavity"``.
    """
    try:
        return exact_surface(shape), ()
    except GlassWorkbenchError as error:
        return fine_mesh(shape), (f"{name} is traced as a mesh, not on its exact faces: {error}",)


def fine_mesh(shape: Part.Shape) -> Mesh:
    """Return a mesh of a solid that is fine enough to look through, and not larger than the tracer likes."""
    deviation = DEVIATION_MM
    while True:
        mesh = tessellate(shape, deviation)
        if len(mesh.triangles) <= MAXIMUM_TRIANGLES:
            return mesh
        deviation *= 2.0
