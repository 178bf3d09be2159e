"""A smooth surface through a grid of points that closes about the axis: cubic in both directions, as mesh and B-rep."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.scene import Mesh

CREASE = np.radians(60.0)
"""Where the grid turns by more than this at a point, the surface has a crease there, rounded within the grid."""

CREASE_TANGENT = 0.6
"""At a crease the tangent is shortened to this share, so that the surface stays close to the crease's sides."""

REACH = 20
"""The share of a knot's value in the derivative this many knots away is below 1e-11."""


@dataclass(frozen=True, eq=False)
class LoftSurface:
    """A bicubic surface of grid points, C2 but at creases, where it is C1.

    Parameters
    ----------
    u : array (n + 1,)
        Parameters of the columns about the axis; the last is the first again.
    v : array (m,)
        Parameters of the rows, from the pole on the axis to the mouth.
    points : array (m, n, 3)
        The first row is the pole, n times.
    """

    u: np.ndarray
    v: np.ndarray
    points: np.ndarray

    def at(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the points (k, l, 3) at the parameters v (k,) and u (l,)."""
        return self._blend(_hermite(self.v, v), self._around(_hermite(self.u, u)))

    def with_normals(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return points (k, l, 3) and unit normals pointing away from the axis' side, out of the cavity."""
        across, around = _hermite(self.v, v), self._around(_hermite(self.u, u))
        along_v = self._blend(_hermite(self.v, v, slope=True), around)
        along_u = self._blend(across, self._around(_hermite(self.u, u, slope=True)))
        pole = np.asarray(v) <= self.v[0]
        # At the pole the surface does not change along u, but its direction along v does.
        turning = self._blend(_hermite(self.v, v, slope=True), self._around(_hermite(self.u, u, slope=True)))
        normals = np.cross(np.where(pole[:, None, None], turning, along_u), along_v)
        if pole.any():
            normals[pole] = normals[pole].mean(axis=1, keepdims=True)
        normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-300)
        return self._blend(across, around), normals

    def with_columns(self, u: np.ndarray, points: np.ndarray) -> LoftSurface:
        """Return a surface with more columns: at u (k,), through points (m, k, 3)."""
        order = np.argsort(np.concatenate([self.u[:-1], u]), kind="stable")
        merged = np.concatenate([self.u[:-1], u])[order]
        return LoftSurface(
            np.append(merged, self.u[-1]), self.v, np.concatenate([self.points, points], axis=1)[:, order]
        )

    def with_rows(self, v: np.ndarray, points: np.ndarray) -> LoftSurface:
        """Return a surface with more rows: at v (k,), through points (k, n, 3)."""
        merged = np.concatenate([self.v, v])
        order = np.argsort(merged, kind="stable")
        return LoftSurface(self.u, merged[order], np.concatenate([self.points, points])[order])

    @cached_property
    def _slopes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Derivatives at the grid points (m, n, 3) by u, by v, and by both."""
        by_u = _periodic_tangents(self.u, self.points)
        by_v = _tangents(self.v, self.points.swapaxes(0, 1)).swapaxes(0, 1)
        twist = _periodic_tangents(self.u, by_v, _creases_around(self.points))
        by_u[0] = 0.0
        return by_u, by_v, twist

    def _around(self, basis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return values and v-derivatives (m, l, 3) on the rows, from the basis (l, 2, n + 1) along u."""
        by_u, by_v, twist = self._slopes
        value, slope = _closed(basis[:, 0]), _closed(basis[:, 1])
        return (
            np.einsum("lj,mjk->mlk", value, self.points, optimize=True)
            + np.einsum("lj,mjk->mlk", slope, by_u, optimize=True),
            np.einsum("lj,mjk->mlk", value, by_v, optimize=True)
            + np.einsum("lj,mjk->mlk", slope, twist, optimize=True),
        )

    @staticmethod
    def _blend(basis: np.ndarray, rows: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        return np.einsum("ki,ilx->klx", basis[:, 0], rows[0], optimize=True) + np.einsum(
            "ki,ilx->klx", basis[:, 1], rows[1], optimize=True
        )

    def mesh(self, u: np.ndarray, v: np.ndarray, rise_mm: float = 0.0) -> Mesh:
        """Return the closed mesh of the body below the mouth, or of that continued straight up.

        Parameters
        ----------
        u, v : array
            Parameters of the vertices, without the last u; v from the first to the last of the surface.
        rise_mm : float
            How far the body reaches straight up above the last row.
        """
        points, normals = self.with_normals(u, v)
        count, rows = len(u), len(v)
        rings, directions = [points[1:].reshape(-1, 3)], [normals[1:].reshape(-1, 3)]
        if rise_mm > 0.0:
            level = normals[-1] * np.array([1.0, 1.0, 0.0])
            level /= np.linalg.norm(level, axis=1, keepdims=True)
            rings += [points[-1], points[-1] + [0.0, 0.0, rise_mm]]
            directions += [level, level]
        top = rings[-1].reshape(-1, count, 3)[-1]
        vertices = [points[0, :1], *rings, top, top.mean(axis=0)[None]]
        up = np.tile([0.0, 0.0, 1.0], (count + 1, 1))
        k, after = np.arange(count), np.roll(np.arange(count), -1)
        triangles = [np.column_stack([np.zeros_like(k), after + 1, k + 1])]
        strips = [*range(rows - 2), *([rows - 1] if rise_mm > 0.0 else [])]
        for strip in strips:
            low, high = 1 + strip * count, 1 + (strip + 1) * count
            triangles += [np.column_stack([low + k, low + after, high + after])]
            triangles += [np.column_stack([low + k, high + after, high + k])]
        lid = 1 + sum(len(ring) for ring in rings)
        triangles.append(np.column_stack([lid + k, lid + after, np.full(count, lid + count)]))
        return Mesh(
            np.concatenate(vertices), np.concatenate(triangles), np.concatenate([normals[0, :1], *directions, up])
        )

    def face(self) -> Part.Shape:
        """Return the surface as one face with a seam, its pole a degenerate edge."""
        surface = Part.BSplineSurface()
        poles = self._poles()
        knots_u, knots_v = self.u, self.v
        surface.buildFromPolesMultsKnots(
            [[FreeCAD.Vector(*point) for point in column] for column in poles.swapaxes(0, 1).tolist()],
            [2] * len(knots_u),
            [4, *[2] * (len(knots_v) - 2), 4],
            knots_u.tolist(),
            knots_v.tolist(),
            True,
            False,
            3,
            3,
        )
        return surface.toShape()

    def _poles(self) -> np.ndarray:
        """Return the control points (2 m, 2 n, 3) over double knots: two about each grid point in each direction."""
        by_u, by_v, twist = self._slopes
        before_u, after_u = np.roll(np.diff(self.u), 1) / 3.0, np.diff(self.u) / 3.0
        spans = np.diff(self.v) / 3.0
        before_v, after_v = np.append(0.0, spans), np.append(spans, 0.0)
        rows, columns = self.points.shape[:2]
        poles = np.empty((rows, 2, columns, 2, 3))
        for i, dv in enumerate((-before_v, after_v)):
            for j, du in enumerate((-before_u, after_u)):
                dv_, du_ = dv[:, None, None], du[None, :, None]
                poles[:, i, :, j] = self.points + dv_ * by_v + du_ * by_u + dv_ * du_ * twist
        return poles.reshape(2 * rows, 2 * columns, 3)


def chord_parameters(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return parameters u (n + 1,) and v (m,) of a grid (m, n, 3): the mean lengths of its chords, summed."""
    around = np.linalg.norm(np.roll(points, -1, axis=1) - points, axis=2).mean(axis=0)
    along = np.linalg.norm(np.diff(points, axis=0), axis=2).mean(axis=1)
    return np.concatenate([[0.0], np.cumsum(around)]), np.concatenate([[0.0], np.cumsum(along)])


def _hermite(knots: np.ndarray, at: np.ndarray, slope: bool = False) -> np.ndarray:
    """Return the weights (k, 2, m) of the values and derivatives at the knots, for the value or slope at k places."""
    at = np.asarray(at, dtype=float)
    row = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2)
    step = knots[row + 1] - knots[row]
    s = (at - knots[row]) / step
    if slope:
        first, second = 6 * s * (s - 1) / step, -6 * s * (s - 1) / step
        rise, fall = (1 - s) * (1 - 3 * s), s * (3 * s - 2)
    else:
        first, second = (1 + 2 * s) * (1 - s) ** 2, s**2 * (3 - 2 * s)
        rise, fall = s * (1 - s) ** 2 * step, s**2 * (s - 1) * step
    weights = np.zeros((len(at), 2, len(knots)))
    k = np.arange(len(at))
    weights[k, 0, row], weights[k, 0, row + 1] = first, second
    weights[k, 1, row], weights[k, 1, row + 1] = rise, fall
    return weights


def _closed(basis: np.ndarray) -> np.ndarray:
    """Add the last column of a basis, the first one again, to the first."""
    folded = basis[:, :-1].copy()
    folded[:, 0] += basis[:, -1]
    return folded


def _periodic_tangents(u: np.ndarray, values: np.ndarray, creases: np.ndarray | None = None) -> np.ndarray:
    """Return derivatives (m, n, 3) at the knots of periodic C2 cubics through values (m, n, 3).

    A knot's derivative does not depend on knots more than `REACH` away, so the line is simply continued that far.
    """
    count = len(u) - 1
    around = np.arange(-REACH, count + REACH + 1)
    turns, column = np.divmod(around, count)
    creases = None if creases is None else creases[:, column]
    longer = _tangents(u[column] + turns * (u[-1] - u[0]), values[:, column], creases)
    return longer[:, REACH : REACH + count]


def _tangents(knots: np.ndarray, values: np.ndarray, creases: np.ndarray | None = None) -> np.ndarray:
    """Return derivatives (n, m, 3) at the knots of C2 cubics through values (n, m, 3), parabolas in the end spans.

    At a crease the derivative is set, and the cubics on both sides of it do not know of each other. Creases (n, m) are
    found in the values where they are not given.
    """
    step = np.diff(knots)
    secant = np.diff(values, axis=1) / step[:, None]
    before, after = secant[:, :-1], secant[:, 1:]
    if creases is None:
        creases = np.zeros(values.shape[:2], dtype=bool)
        creases[:, 1:-1] = _turns_sharply(before, after)
        short = np.minimum(np.linalg.norm(before, axis=2), np.linalg.norm(after, axis=2))
        given = CREASE_TANGENT * short[..., None] * _unit(_unit(before) + _unit(after))
    else:
        given = CREASE_TANGENT * 0.5 * (before + after)
    low, diagonal, high = np.zeros((3, *values.shape[:2]))
    right = np.empty_like(values)
    low[:, 1:-1], diagonal[:, 1:-1], high[:, 1:-1] = step[1:], 2.0 * (step[:-1] + step[1:]), step[:-1]
    right[:, 1:-1] = 3.0 * (step[:-1, None] * after + step[1:, None] * before)
    diagonal[:, 0] = diagonal[:, -1] = high[:, 0] = low[:, -1] = 1.0
    right[:, 0], right[:, -1] = 2.0 * secant[:, 0], 2.0 * secant[:, -1]
    low[creases], high[creases], diagonal[creases] = 0.0, 0.0, 1.0
    right[:, 1:-1][creases[:, 1:-1]] = given[creases[:, 1:-1]]
    return _tridiagonal(low, diagonal, high, right)


def _tridiagonal(low: np.ndarray, diagonal: np.ndarray, high: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solve n tridiagonal systems of m equations, (n, m) each, for three right sides (n, m, 3), by elimination."""
    count = diagonal.shape[1]
    diagonal, solved = diagonal.copy(), right.copy()
    for k in range(1, count):
        factor = low[:, k] / diagonal[:, k - 1]
        diagonal[:, k] -= factor * high[:, k - 1]
        solved[:, k] -= factor[:, None] * solved[:, k - 1]
    solved[:, -1] /= diagonal[:, -1, None]
    for k in range(count - 2, -1, -1):
        solved[:, k] = (solved[:, k] - high[:, k, None] * solved[:, k + 1]) / diagonal[:, k, None]
    return solved


def _creases_around(points: np.ndarray) -> np.ndarray:
    chord = np.roll(points, -1, axis=1) - points
    return _turns_sharply(np.roll(chord, 1, axis=1), chord)


def _turns_sharply(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(before, axis=2) * np.linalg.norm(after, axis=2)
    return np.einsum("ijk,ijk->ij", before, after) < np.cos(CREASE) * lengths


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=2, keepdims=True), 1e-300)
