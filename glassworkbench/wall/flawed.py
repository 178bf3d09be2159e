"""Defects that are made with the wall: the mold deformed, and the thickness asked changed, before hollowing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.flaws.defect import Defect, InShape, InThickness
from glassworkbench.freecad import FreeCAD
from glassworkbench.mold import Mold, mold_from_shape
from glassworkbench.mold.placing import moved
from glassworkbench.wall.asking.limits import THINNEST_MM
from glassworkbench.wall.asking.thickness import GridThickness, TabulatedThickness, Thickness
from glassworkbench.wall.choose import as_thickness

ROWS, COLUMNS = 65, 24
"""Of the table that a wall which varies becomes, besides those that the defects and the wall itself ask for."""


def flawed_mold(mold: Mold, defects: Sequence[Defect]) -> Mold:
    """Return a mold that leans or is oval as defects say; the wall put into it has the thickness asked.

    Raises
    ------
    InputError
        If the mold is a mesh, or a defect is too large for it.
    """
    shapes = [defect for defect in defects if isinstance(defect, InShape)]
    if not shapes:
        return mold
    if mold.upright is None:
        raise InputError(f"{shapes[0]}: the mold {mold.name} is a mesh; only molds of CAD faces are deformed")
    matrix = np.eye(4)
    for shape in shapes:
        matrix[:3, :3] = shape.deformation(mold.anatomy.maximum_radius_mm) @ matrix[:3, :3]
    deformed = mold.upright.transformGeometry(FreeCAD.Matrix(*matrix.ravel().tolist()))
    axis = mold.placement[:3, 2]
    made = mold_from_shape(moved(deformed, mold.placement), mold.name, axis=axis, up=axis)
    return replace(made, path=mold.path, sha256=mold.sha256, repairs=mold.repairs)


def flawed_thickness(thickness: Thickness | str | float, mold: Mold, defects: Sequence[Defect]) -> Thickness:
    """Return the wall that is asked with defects in it: a table over height, or over height and angle.

    Raises
    ------
    InputError
        If the wall is told by face or has a bore, or a defect takes more than there is.
    """
    thickness = as_thickness(thickness, tuple(reversed(mold.anatomy.regions)))
    flaws = [defect for defect in defects if isinstance(defect, InThickness)]
    if not flaws:
        return thickness
    asked = thickness.on(mold)
    if asked.by_face is not None or asked.bore is not None:
        raise InputError(f"{flaws[0]}: a wall by face or with a bore cannot have it; give the wall by height or region")
    top, radius = mold.anatomy.finish_height_mm, mold.anatomy.maximum_radius_mm
    for flaw in flaws:
        if not 0.0 < flaw.height_mm < top:
            raise InputError(f"{flaw}: it must lie between the lowest point and the finish at {top:.4g} mm")
    own = getattr(thickness, "heights_mm", ()) if asked.over_height is None else asked.over_height.heights_mm
    is_uniform = asked.over_height is not None and asked.over_height.uniform_mm is not None
    even = np.linspace(0.0, top, 2 if is_uniform else ROWS)
    heights = _between(np.concatenate([even, own, *(flaw.rows_mm() for flaw in flaws)]), top)
    columns = np.concatenate([flaw.columns_deg(radius) for flaw in flaws])
    if asked.over_height is not None and len(columns) == 0:
        rows = _with_flaws(asked, heights[:, None], np.zeros(1), flaws, radius)[:, 0]
        return TabulatedThickness(tuple(heights), tuple(rows))
    own = getattr(thickness, "angles_deg", ())
    even = np.linspace(0.0, 360.0, 4 if is_uniform else COLUMNS, endpoint=False)
    angles = np.unique(np.round(np.concatenate([even, own, columns]) % 360.0, 6) % 360.0)
    rows = _with_flaws(asked, heights[:, None], angles, flaws, radius)
    return GridThickness(tuple(heights), tuple(angles), tuple(map(tuple, rows)))


def _between(heights: np.ndarray, top: float) -> np.ndarray:
    inner = np.unique(np.round(heights[(heights > 0.0) & (heights < top)], 6))
    return np.concatenate([[0.0], inner[(inner > 1e-3) & (inner < top - 1e-3)], [top]])


def _with_flaws(
    asked: object, heights: np.ndarray, angles: np.ndarray, flaws: Sequence[InThickness], radius_mm: float
) -> np.ndarray:
    """Return the thickness (n, m) at heights (n, 1) and angles (m,)."""
    turns = np.radians(angles) + 0.0 * heights
    # On the outside's widest cylinder, so that none counts as inside the standing ring.
    points = np.stack([radius_mm * np.cos(turns), radius_mm * np.sin(turns), heights + 0.0 * turns], axis=-1)
    thickness = asked.at(points.reshape(-1, 3), np.zeros(turns.size, dtype=np.int64)).reshape(turns.shape)
    for flaw in flaws:
        thickness = thickness + flaw.added_mm(heights, angles, radius_mm)
        if thickness.min() < THINNEST_MM:
            raise InputError(f"{flaw}: it takes more than the wall has there; make it less, or the wall thicker")
    return thickness
