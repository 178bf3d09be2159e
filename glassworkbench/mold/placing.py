"""Motions between the coordinates of a CAD file and those of the upright container."""

from __future__ import annotations

import numpy as np

from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold.axis import Standing, rotation_to_upright


def placement_of(standing: Standing, vertices_mm: np.ndarray) -> np.ndarray:
    """Return the matrix (4, 4) from upright to CAD coordinates for a container with the points `vertices_mm` (n, 3)."""
    heights = (vertices_mm - standing.point_mm) @ standing.axis
    placement = np.eye(4)
    placement[:3, :3] = rotation_to_upright(standing.axis).T
    placement[:3, 3] = standing.point_mm + heights.min() * standing.axis
    return placement


def moved(shape: Part.Shape, matrix: np.ndarray) -> Part.Shape:
    """Return a copy of a shape after a rigid motion (4, 4)."""
    copy = shape.copy()
    copy.transformShape(FreeCAD.Matrix(*matrix.ravel().tolist()), True, False)
    return copy
