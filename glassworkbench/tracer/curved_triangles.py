"""The triangles of a body of patches as the tracer sees them: pieces of the exact surface with shared curved edges.

How they keep a ray from leaking is told in ``native/patch.hpp``; the native core and the numpy reference both start
from these tables.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.scene import Patches

GRID = 4
"""Parts of a triangle's sides between the points at which its bulge and its normals are sampled."""

EDGE_PIECES = 4
"""Parabolas that an edge is made of."""

BOX_MARGIN = 0.5
"""Share of the bulge by which a box is widened beyond the samples."""

CONE_MARGIN = 1.25
"""Factor on the largest angle between a triangle's sampled normals and their middle."""

AT_POLE = 1e-7
"""Sum of barycentric coordinates below which all is as it is there: a collapsed edge has no direction at its end."""

COLLAPSED = 1e-7
"""Length of an edge's tangent, relative to its triangle, below which the edge is collapsed into a pole."""

MEETING_STEPS = 4
"""Newton's steps from an edge to where the sheets on its sides meet."""

TANGENT = 1e-2
"""Sine of the angle between sheets below which where they meet is not sharp: a crossing there is off by less still."""

TOWARDS_MIDDLE = 1e-7
"""Share of the way to a triangle's middle at which a collapsed edge's normal is taken: the limit, but for 1e-7 rad."""


@dataclass(frozen=True, eq=False)
class CurvedTriangles:
    """Tables with one row a triangle; edge k runs from corner k to the next.

    Parameters
    ----------
    sheet : int array (m,)
    corners_mm : array (m, 3, 3)
    uv : array (m, 3, 2)
        Parameters of the corners in their sheet.
    pole : int array (m,)
        0; or, where corner 0 lies on a collapsed edge, 1 if u runs along that edge and 2 if v does.
    edges_mm : array (e, 2 EDGE_PIECES + 1, 3)
        Points along each edge, on the surface: ends and middles of as many parabolas in turn.
    edge : int array (m, 3)
        The edge on each side; both triangles at an edge name the same.
    along : bool array (m, 3)
        Whether the edge is run in the sense in which it is stored, which one of its triangles does.
    low_mm, high_mm : array (m, 3)
        A box around the curved triangle.
    cone_axis : array (m, 3), cone_sine : array (m,)
        A ray can be tangent to the triangle only if the sine of its angle with the plane across the axis is less.
    """

    sheet: np.ndarray
    corners_mm: np.ndarray
    uv: np.ndarray
    pole: np.ndarray
    edges_mm: np.ndarray
    edge: np.ndarray
    along: np.ndarray
    low_mm: np.ndarray
    high_mm: np.ndarray
    cone_axis: np.ndarray
    cone_sine: np.ndarray

    @classmethod
    def of(cls, patches: Patches) -> CurvedTriangles:
        """Return the tables of a body."""
        uv, corners, pole = _poles_first(patches)
        sheet = patches.sheet_of_triangle
        count = len(corners)

        share = np.array([(i, j) for i in range(GRID + 1) for j in range(GRID + 1 - i)]) / GRID
        share = np.tile(share, (count, 1))
        row = np.repeat(np.arange(count), len(share) // count)
        points = evaluate(patches, sheet, uv, pole, row, share)[0].reshape(count, -1, 3)
        # Normals are taken a little inside, where no edge is collapsed.
        inner = share + TOWARDS_MIDDLE * (1.0 / 3.0 - share)
        _, by_p, by_q = evaluate(patches, sheet, uv, pole, row, inner)
        normals = _unit(np.cross(by_p, by_q)).reshape(count, -1, 3)
        axis = _unit(normals.sum(axis=1))
        angle = np.arccos(np.clip(np.einsum("mc,msc->ms", axis, normals).min(axis=1), -1.0, 1.0))
        sine = np.sin(np.minimum(CONE_MARGIN * angle + 1e-6, np.pi / 2.0))
        sine = np.where(np.einsum("mc,mc->m", axis, axis) > 0.5, sine, 1.0)

        edges, edge, along = _edges(patches, sheet, uv, pole, corners)
        controls = 2.0 * edges[:, 1::2] - 0.5 * (edges[:, :-1:2] + edges[:, 2::2])
        around = np.concatenate([corners, points, *edges[edge].swapaxes(0, 1), *controls[edge].swapaxes(0, 1)], axis=1)
        first, second = share.reshape(count, -1, 2)[0].T
        flat = np.einsum("sk,mkc->msc", np.column_stack([1.0 - first - second, first, second]), corners)
        bulge = np.abs(points - flat).max(axis=(1, 2))
        margin = (BOX_MARGIN * bulge + 1e-12 * np.abs(corners).max())[:, None]
        low, high = around.min(axis=1) - margin, around.max(axis=1) + margin
        return cls(sheet, corners, uv, pole, edges, edge, along, low, high, axis, sine)


def evaluate(
    patches: Patches, sheet: np.ndarray, uv: np.ndarray, pole: np.ndarray, row: np.ndarray, share: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points on curved triangles, and their derivatives by the barycentric coordinates of corners 1 and 2.

    Parameters
    ----------
    patches : Patches
    sheet, uv, pole : arrays (m,), (m, 3, 2), (m,)
        As in `CurvedTriangles`.
    row : int array (k,)
        Numbers of triangles.
    share : array (k, 2)
        Barycentric coordinates of corners 1 and 2.
    """
    uv, pole = uv[row], pole[row]
    # A pole itself lies on the tangent plane from just inside.
    at_pole = (pole > 0) & (np.abs(share.sum(axis=1)) < AT_POLE)
    rest = np.where(at_pole[:, None], share - AT_POLE, 0.0)
    share = share - rest
    edges = uv[:, 1:] - uv[:, :1]
    value = uv[:, 0] + np.einsum("kb,kbc->kc", share, edges)
    # At a pole the parameter along the collapsed edge is constant on lines through the pole, like an angle.
    away = share.sum(axis=1)
    for free in (0, 1):
        fan = pole == free + 1
        turned = uv[fan, 1, free] + share[fan, 1] / away[fan] * (uv[fan, 2, free] - uv[fan, 1, free])
        value[fan, free] = turned
        edges[fan, :, free] = (uv[fan, 1:, free] - turned[:, None]) / away[fan, None]
    point, by_u, by_v = patches.evaluate(sheet[row], value)
    by_p, by_q = (edges[:, k, :1] * by_u + edges[:, k, 1:] * by_v for k in (0, 1))
    return point + rest[:, :1] * by_p + rest[:, 1:] * by_q, by_p, by_q


def _poles_first(patches: Patches) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the corners' parameters and places, turned so that a pole comes first, and the kind of pole."""
    uv = patches.uv_of_corner
    corners = patches.mesh.vertices_mm[patches.mesh.triangles]
    _, by_u, by_v = patches.evaluate(np.repeat(patches.sheet_of_triangle, 3), uv.reshape(-1, 2))
    width = np.repeat(np.ptp(uv, axis=1), 3, axis=0)
    speeds = np.linalg.norm(np.stack([by_u, by_v]), axis=2) * width.T
    size = np.repeat(np.linalg.norm(np.ptp(corners, axis=1), axis=1), 3)
    collapsed = (speeds <= COLLAPSED * size).reshape(2, -1, 3)
    pole, first = np.zeros(len(uv), dtype=np.int32), np.zeros(len(uv), dtype=np.int64)
    for kind in (2, 1):
        found = collapsed[kind - 1].sum(axis=1) == 1
        pole[found] = kind
        first[found] = np.argmax(collapsed[kind - 1][found], axis=1)
    order = (first[:, None] + np.arange(3)) % 3
    rows = np.arange(len(uv))[:, None]
    return np.ascontiguousarray(uv[rows, order]), np.ascontiguousarray(corners[rows, order]), pole


def _edges(
    patches: Patches, sheet: np.ndarray, uv: np.ndarray, pole: np.ndarray, corners: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the edges' points, which edge is on each side, and in which sense: see `CurvedTriangles`.

    The sheets on both sides of an edge know its points each; the edge has the mean of them, moved to where the sheets
    meet if they are two: a ray that enters through one just beyond its crease would else never leave by the other.
    """
    places, place = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    start = place.reshape(-1, 3)
    end = np.roll(start, -1, axis=1)
    along = start <= end
    pairs = np.stack([np.minimum(start, end), np.maximum(start, end)], axis=-1).reshape(-1, 2)
    ends, edge = np.unique(pairs, axis=0, return_inverse=True)
    edge = edge.reshape(-1, 3)

    count = 2 * EDGE_PIECES + 1
    way = np.arange(count) / (count - 1)
    points = np.zeros((len(ends), count, 3))
    sheets = np.zeros((len(ends), 2), dtype=np.int64)
    near = np.zeros((len(ends), 2, count, 2))
    for side, (p, q) in enumerate([(way, 0.0 * way), (1.0 - way, way), (0.0 * way, 1.0 - way)]):
        row = np.repeat(np.arange(len(corners)), count)
        share = np.tile(np.column_stack([p, q]), (len(corners), 1))
        found = evaluate(patches, sheet, uv, pole, row, share)[0].reshape(-1, count, 3)
        np.add.at(points, edge[:, side], np.where(along[:, side, None, None], found, found[:, ::-1]))
        straight = uv[:, None, side] + way[:, None] * (uv[:, (side + 1) % 3] - uv[:, side])[:, None]
        hand = along[:, side].astype(np.int64)
        sheets[edge[:, side], hand] = sheet
        near[edge[:, side], hand] = np.where(along[:, side, None, None], straight, straight[:, ::-1])
    points /= np.bincount(edge.ravel(), minlength=len(ends))[:, None, None]
    creased = np.flatnonzero(sheets[:, 0] != sheets[:, 1])
    points[creased] = _where_sheets_meet(patches, sheets[creased], near[creased], points[creased])
    points[:, 0], points[:, -1] = places[ends[:, 0]], places[ends[:, 1]]
    return points, edge.astype(np.int32), along


def _where_sheets_meet(patches: Patches, sheets: np.ndarray, uv: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return points (e, s, 3) moved along the normals of two sheets (e, 2) to both, from parameters (e, 2, s, 2) near.

    Where the sheets are tangent, to midway between them. What would move farther than a quarter of its edge is left.
    """
    moved, uv = points.reshape(-1, 3).copy(), uv.copy()
    for _ in range(MEETING_STEPS):
        normals, heights = [], []
        for side in (0, 1):
            sheet = np.repeat(sheets[:, side], points.shape[1])
            place, by_u, by_v = patches.evaluate(sheet, uv[:, side].reshape(-1, 2))
            gap = moved - place
            uu, cross, vv = (np.einsum("ij,ij->i", a, b) for a, b in ((by_u, by_u), (by_u, by_v), (by_v, by_v)))
            along_u, along_v = np.einsum("ij,ij->i", gap, by_u), np.einsum("ij,ij->i", gap, by_v)
            determinant = uu * vv - cross**2
            inverse = np.where(determinant > 1e-14 * uu * vv, 1.0, 0.0) / np.where(determinant > 0.0, determinant, 1.0)
            step = inverse[:, None] * np.column_stack([vv * along_u - cross * along_v, uu * along_v - cross * along_u])
            uv[:, side] += step.reshape(uv[:, side].shape)
            normals.append(_unit(np.cross(by_u, by_v)))
            heights.append(np.einsum("ij,ij->i", gap, normals[-1]))
        cosine = np.einsum("ij,ij->i", *normals)
        sine_squared = 1.0 - cosine**2
        tangent = sine_squared < TANGENT**2
        sine_squared = np.where(tangent, 1.0, sine_squared)
        first = np.where(tangent, 0.5 * heights[0], (heights[0] - cosine * heights[1]) / sine_squared)
        second = np.where(tangent, 0.5 * heights[1], (heights[1] - cosine * heights[0]) / sine_squared)
        moved = moved - first[:, None] * normals[0] - second[:, None] * normals[1]
    moved = moved.reshape(points.shape)
    length = np.linalg.norm(points[:, -1] - points[:, 0], axis=1)[:, None, None]
    near = np.linalg.norm(moved - points, axis=2, keepdims=True) <= 0.25 * length
    return np.where(near, moved, points)


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)
