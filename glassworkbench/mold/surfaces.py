"""The exact surface of a CAD solid as the tracer takes it: a sheet of patches a face, joined by a coarse mesh."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import Part
from glassworkbench.mold.mending import welded
from glassworkbench.mold.patches import FacePatches, face_patches, locate
from glassworkbench.mold.tessellation import WELD_MM, meshed_faces
from glassworkbench.scene import Mesh, Patches, Sheet

DEVIATION_MM = 0.1
"""Of the mesh that joins the sheets; a finer one is not seen."""

ROUNDING_MM = 1e-4
"""Farthest that a node may lie off its face besides the shape's own tolerances."""

SAME_MM = 1e-4
"""Nodes are matched to their parameters by position, those nearer than this to each other without a search."""

COLLAPSED_MM = 1e-7
"""A sheet's border no longer than this is a pole."""


def exact_surface(shape: Part.Shape, deviation_mm: float = DEVIATION_MM) -> Patches:
    """Return the exact surface of a closed solid; how coarse the mesh under it is changes the time to trace it only.

    Parameters
    ----------
    shape : Part.Shape
        In mm, its faces outward.
    deviation_mm : float
        Of the mesh that tells how the faces join.

    Returns
    -------
    Patches
        Its sheets are the surfaces of the faces, exact but for offset surfaces, which OCC approximates
        (`FacePatches.error_mm`): the largest such error is its `surface_error_mm`. Its own `deviation_mm` bounds how
        far the mesh's nodes lie off them: where faces do not quite meet, that is the gap between them.

    Raises
    ------
    InputError
        If the deviation is not above 0.
    GlassWorkbenchError
        If OCC leaves a hole in the mesh, cannot convert a face, or puts a node off its face by more than the shape's
        tolerance.
    """
    sheets, vertices, triangles, sheet_of_triangle, uv_of_corner = [], [], [], [], []
    count, error_mm = 0, 0.0
    for _, face, points, corners in meshed_faces(shape, deviation_mm):
        patches = face_patches(face)
        error_mm = max(error_mm, patches.error_mm)
        sheet, to_sheet = _sheet(face, patches)
        near = _corner_parameters(face, points, corners)
        flat = points[corners.ravel()]
        uv = to_sheet(*locate(patches, flat, near.reshape(-1, 2)), near.reshape(-1, 2))
        vertices.append(points)
        triangles.append(corners + count)
        sheet_of_triangle.append(np.full(len(corners), len(sheets), dtype=np.int32))
        uv_of_corner.append(_at_poles(sheet, uv.reshape(-1, 3, 2), flat.reshape(-1, 3, 3)))
        sheets.append(sheet)
        count += len(points)
    points = welded(np.concatenate(vertices), WELD_MM)
    corners = np.concatenate(triangles)
    at = points[corners]
    # Welding may leave slivers that are a line there and back; without them the mesh is as closed as before.
    kept = np.all(np.any(at != np.roll(at, 1, axis=1), axis=2), axis=1)
    try:
        return Patches(
            sheets,
            Mesh(points, corners[kept]),
            np.concatenate(sheet_of_triangle)[kept],
            np.concatenate(uv_of_corner)[kept],
            ROUNDING_MM + 2.0 * shape.getTolerance(1),
            error_mm,
        )
    except InputError as error:
        raise GlassWorkbenchError(
            f"the shape's faces could not be joined at {deviation_mm:g} mm ({error}); "
            "repair the shape, or try another deviation"
        ) from error


def _sheet(face: Part.Face, patches: FacePatches) -> tuple[Sheet, Callable]:
    """Return a face's patches unrolled over its parameter range, and what turns their numbers and places into (u, v).

    That takes numbers (n,), places (n, 2), and parameters (n, 2) near which, of all that repeat, the answer shall be.
    """
    bounds = np.reshape(face.ParameterRange, (2, 2))
    spans, columns, knots = [], [], []
    for axis in range(2):
        found = np.unique(patches.rectangles[:, 2 * axis : 2 * axis + 2], axis=0)
        column, start, end = _unrolled(found, bounds[axis], patches.period[axis])
        spans.append(found)
        columns.append(column)
        knots.append(np.append(start, end[-1]))
    degree_u, degree_v = patches.degrees
    grid = patches.controls.reshape(len(spans[0]), len(spans[1]), degree_u + 1, degree_v + 1, 4)
    sheet = Sheet(grid[columns[0]][:, columns[1]], *knots)

    def to_sheet(numbers: np.ndarray, places: np.ndarray, near: np.ndarray) -> np.ndarray:
        cells = np.column_stack(np.divmod(numbers, len(spans[1])))
        uv = np.empty_like(places)
        for axis, period in enumerate(patches.period):
            low, high = spans[axis][cells[:, axis]].T
            uv[:, axis] = low + places[:, axis] * (high - low)
            if period:
                uv[:, axis] += period * np.round((near[:, axis] - uv[:, axis]) / period)
        return uv

    return sheet, to_sheet


def _unrolled(spans: np.ndarray, wanted: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return which spans (n, 2) cover the wanted range in turn, as often as it takes, and their starts and ends."""
    shifts = period * np.arange(-2, 3) if period else np.zeros(1)
    starts, ends = (spans[:, side, None] + shifts for side in range(2))
    slack = 1e-9 * (wanted[1] - wanted[0])
    column, turn = np.nonzero((starts < wanted[1] - slack) & (ends > wanted[0] + slack))
    order = np.argsort(starts[column, turn])
    column, turn = column[order], turn[order]
    start, end = starts[column, turn], ends[column, turn]
    if np.any(np.abs(start[1:] - end[:-1]) > slack):
        raise GlassWorkbenchError("a face's patches leave gaps; repair the file in the CAD program")
    return column, start, end


def _corner_parameters(face: Part.Face, points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the CAD parameters (m, 3, 2) of each triangle's corners, on the triangle's own side of a seam.

    A node on a seam or a pole has several; the triangle gets those that lie nearest to each other.
    """
    known = _node_parameters(face, points)
    bounds = np.reshape(face.ParameterRange, (2, 2))
    scale = 1.0 / np.ptp(bounds, axis=1)
    uv = np.array([several[0] for several in known])[corners]
    double = np.array([len(several) > 1 for several in known])
    for number in np.flatnonzero(np.any(double[corners], axis=1)):
        choices = np.array(list(itertools.product(*(known[corner] for corner in corners[number]))))
        sides = scale * (choices - np.roll(choices, 1, axis=1))
        uv[number] = choices[np.argmin((sides**2).sum(axis=(1, 2)))]
    return uv


def _node_parameters(face: Part.Face, points: np.ndarray) -> list[list[tuple[float, float]]]:
    """Return of each node (n, 3) its CAD parameters; nodes on an edge may lie off the surface by its tolerance."""
    known = [[] for _ in points]
    places = {tuple(key): number for number, key in enumerate(np.round(points / SAME_MM).astype(np.int64).tolist())}
    parameters = face.getUVNodes()
    values = np.array([tuple(face.Surface.value(*uv)) for uv in parameters])
    for key, value, uv in zip(np.round(values / SAME_MM).astype(np.int64).tolist(), values, parameters, strict=True):
        number = places.get(tuple(key))
        if number is None:
            number = int(np.argmin(((points - value) ** 2).sum(axis=1)))
        known[number].append(uv)
    for number in (number for number, several in enumerate(known) if not several):
        known[number].append(parameters[int(np.argmin(((values - points[number]) ** 2).sum(axis=1)))])
    return known


def _at_poles(sheet: Sheet, uv: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the corners' parameters (m, 3, 2), those at a collapsed border on it, midway between the other two's."""
    uv = uv.copy()
    points = sheet.control_points[..., :3] / sheet.control_points[..., 3:]
    borders = (
        (0, sheet.u_knots[0], points[0, :, 0]),
        (0, sheet.u_knots[-1], points[-1, :, -1]),
        (1, sheet.v_knots[0], points[:, 0, :, 0]),
        (1, sheet.v_knots[-1], points[:, -1, :, -1]),
    )
    for axis, knot, border in borders:
        border = border.reshape(-1, 3)
        if np.ptp(border, axis=0).max() > COLLAPSED_MM:
            continue
        triangle, corner = np.nonzero(np.linalg.norm(at - border[0], axis=2) <= ROUNDING_MM)
        uv[triangle, corner, axis] = knot
        free = 1 - axis
        uv[triangle, corner, free] = 0.5 * (uv[triangle, :, free].sum(axis=1) - uv[triangle, corner, free])
    return uv
