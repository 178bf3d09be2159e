"""Exact surfaces of any CAD model: sheets of rational Bezier patches, and the mesh that says how they join."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene.mesh import Mesh
from glassworkbench.scene.validate import finite, finite_array, positive

HIGHEST_DEGREE = 25
"""Of a sheet's patches in either direction: OCC makes none higher, and the native core has room for no more."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """The surface of one CAD face: a grid of rational Bezier patches over a rectangle of parameters.

    Beyond the rectangle the outermost patches go on: a trimmed face may need a little more than it says.

    Parameters
    ----------
    control_points : array (nu, nv, du + 1, dv + 1, 4)
        Of patch (i, j), homogeneous: weight times (x, y, z) in mm, and the weight, all weights above 0. Degrees from
        1 to `HIGHEST_DEGREE`.
    u_knots, v_knots : array (nu + 1,), (nv + 1,)
        Growing parameters between which the patches lie, patch (i, j) over
        [u_knots[i], u_knots[i + 1]] x [v_knots[j], v_knots[j + 1]].

    Raises
    ------
    InputError
        If a number is not finite, a weight is not positive, a degree is out of range, or knots do not grow or do not
        fit the grid.
    """

    control_points: np.ndarray
    u_knots: np.ndarray = field(default=(0.0, 1.0))
    v_knots: np.ndarray = field(default=(0.0, 1.0))

    def __post_init__(self) -> None:
        points = finite_array(self.control_points, (None, None, None, None, 4), "control_points")
        for degree in (points.shape[2] - 1, points.shape[3] - 1):
            if not 1 <= degree <= HIGHEST_DEGREE:
                raise InputError(f"control_points: degrees go from 1 to {HIGHEST_DEGREE}, got {degree}")
        if np.any(points[..., 3] <= 0.0):
            raise InputError("control_points: every weight must be above 0")
        object.__setattr__(self, "control_points", points)
        for name, count in (("u_knots", points.shape[0]), ("v_knots", points.shape[1])):
            knots = finite_array(getattr(self, name), (count + 1,), name)
            if count == 0 or np.any(np.diff(knots) <= 0.0):
                raise InputError(f"{name}: each must lie above the one before")
            object.__setattr__(self, name, knots)

    @property
    def degrees(self) -> tuple[int, int]:
        """Degrees of the patches in u and v."""
        return self.control_points.shape[2] - 1, self.control_points.shape[3] - 1

    def placed(self, turn: np.ndarray, shift_mm: np.ndarray) -> Sheet:
        """Return the sheet turned by a rotation (3, 3) about the origin, then moved."""
        points = np.array(self.control_points)
        points[..., :3] = points[..., :3] @ turn.T + shift_mm * points[..., 3:]
        return Sheet(points, self.u_knots, self.v_knots)

    def evaluate(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return points (k, 3) in mm at parameters (k, 2), and their derivatives by u and v (k, 3)."""
        i, u, u_width = _cell(self.u_knots, uv[:, 0])
        j, v, v_width = _cell(self.v_knots, uv[:, 1])
        degree_u, degree_v = self.degrees
        along_u, slope_u = _bernstein(degree_u, u)
        along_v, slope_v = _bernstein(degree_v, v)
        points = self.control_points[i, j]
        row = np.einsum("kb,kabc->kac", along_v, points)
        value = np.einsum("ka,kac->kc", along_u, row)
        by_u = np.einsum("ka,kac->kc", slope_u, row) / u_width[:, None]
        by_v = np.einsum("ka,kac->kc", along_u, np.einsum("kb,kabc->kac", slope_v, points)) / v_width[:, None]
        weight = value[:, 3:]
        point = value[:, :3] / weight
        return point, (by_u[:, :3] - point * by_u[:, 3:]) / weight, (by_v[:, :3] - point * by_v[:, 3:]) / weight


def _cell(knots: np.ndarray, parameter: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the interval that each parameter lies in (or next to), its place there, and the interval's width."""
    cell = np.clip(np.searchsorted(knots, parameter, side="right") - 1, 0, len(knots) - 2)
    width = knots[cell + 1] - knots[cell]
    return cell, (parameter - knots[cell]) / width, width


def _bernstein(degree: int, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the Bernstein polynomials (k, degree + 1) at t (k,), and their derivatives."""
    lower = [np.ones_like(t)]
    for _ in range(degree - 1):
        lower = _raised(lower, t)
    slope = [-lower[0], *(a - b for a, b in pairwise(lower)), lower[-1]]
    return np.stack(_raised(lower, t), axis=1), degree * np.stack(slope, axis=1)


def _raised(values: list[np.ndarray], t: np.ndarray) -> list[np.ndarray]:
    s = 1.0 - t
    return [s * values[0], *(t * a + s * b for a, b in pairwise(values)), t * values[-1]]


@dataclass(frozen=True, eq=False)
class Patches:
    """A closed body bounded by sheets of rational Bezier patches.

    A closed mesh says how the sheets join: each of its triangles stands for the piece of one sheet between its
    corners, which the tracer meets exactly. How fine the mesh is changes how fast a ray is traced, not what it sees.

    Parameters
    ----------
    sheets : sequence of Sheet
    mesh : Mesh
        Its vertices on the sheets; closed, counter-clockwise seen from outside. Its normals are not used.
    sheet_of_triangle : int array (m,)
    uv_of_corner : array (m, 3, 2)
        Each triangle's corners in its sheet's parameters. At a collapsed edge (a sphere's pole) any parameter that
        gives the point will do; the middle of the triangle's other two is best.
    deviation_mm : float
        Farthest that a vertex may lie from its point on the sheet.
    surface_error_mm : float
        Farthest that the sheets may lie from the surface they stand for; 0 where they are that surface.

    Raises
    ------
    InputError
        If a number is out of range, or a corner lies farther from its sheet than `deviation_mm`.
    """

    sheets: Sequence[Sheet]
    mesh: Mesh
    sheet_of_triangle: np.ndarray
    uv_of_corner: np.ndarray
    deviation_mm: float = 1e-4
    surface_error_mm: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "sheets", tuple(self.sheets))
        object.__setattr__(self, "deviation_mm", positive(self.deviation_mm, "deviation_mm"))
        object.__setattr__(self, "surface_error_mm", finite(self.surface_error_mm, "surface_error_mm"))
        if self.surface_error_mm < 0.0:
            raise InputError(f"surface_error_mm: must not be negative, got {self.surface_error_mm:g}")
        count = len(self.mesh.triangles)
        sheet = np.array(self.sheet_of_triangle, dtype=np.int32)
        if sheet.shape != (count,):
            raise InputError(f"sheet_of_triangle: expected {count} sheet numbers, got shape {sheet.shape}")
        if sheet.min() < 0 or sheet.max() >= len(self.sheets):
            raise InputError("sheet_of_triangle: a sheet number is out of range")
        sheet.setflags(write=False)
        object.__setattr__(self, "sheet_of_triangle", sheet)
        object.__setattr__(self, "uv_of_corner", finite_array(self.uv_of_corner, (count, 3, 2), "uv_of_corner"))
        corners = self.mesh.vertices_mm[self.mesh.triangles].reshape(-1, 3)
        points = self.evaluate(np.repeat(sheet, 3), self.uv_of_corner.reshape(-1, 2))[0]
        distance = np.linalg.norm(points - corners, axis=1)
        worst = int(np.argmax(distance))
        if not distance[worst] <= self.deviation_mm:
            raise InputError(
                f"uv_of_corner: corner {worst % 3} of triangle {worst // 3} lies {distance[worst]:.3g} mm from its "
                f"sheet, more than {self.deviation_mm:g} mm; its parameters belong to another place or sheet"
            )

    @property
    def box_mm(self) -> tuple[np.ndarray, np.ndarray]:
        """The lower and the upper corner (3,) of the box around it, to a sixteenth of how far its triangles bulge."""
        share = np.array([(i, j, 4 - i - j) for i in range(5) for j in range(5 - i)]) / 4.0
        uv = np.einsum("sk,mkc->msc", share, self.uv_of_corner).reshape(-1, 2)
        points = self.evaluate(np.repeat(self.sheet_of_triangle, len(share)), uv)[0]
        return points.min(axis=0), points.max(axis=0)

    def placed(self, turn: np.ndarray, shift_mm: np.ndarray) -> Patches:
        """Return the body turned by a rotation (3, 3) about the origin, then moved."""
        sheets = [sheet.placed(turn, shift_mm) for sheet in self.sheets]
        mesh = self.mesh.placed(turn, shift_mm)
        return replace(self, sheets=sheets, mesh=mesh)

    def evaluate(self, sheet: np.ndarray, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return points (k, 3) in mm on sheets (k,) at parameters (k, 2), and their derivatives by u and v."""
        answer = np.empty((3, len(sheet), 3))
        order = np.argsort(sheet, kind="stable")
        starts = np.flatnonzero(np.diff(sheet[order], prepend=-1))
        for rows in np.split(order, starts[1:]):
            if len(rows) > 0:
                answer[:, rows] = self.sheets[sheet[rows[0]]].evaluate(uv[rows])
        return answer[0], answer[1], answer[2]
