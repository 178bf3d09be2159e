"""Where straight lines cross a body of rational Bezier patches, in numpy.

The rules are those of ``native/patch.hpp``: winding numbers of the curved triangles' boundaries say how often a line
crosses each, and in which sense; Newton says where. Feet are sought from many starts at once, not by way of the
silhouette.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from glassworkbench.scene import Patches
from glassworkbench.tracer.curved_triangles import TOWARDS_MIDDLE, CurvedTriangles, evaluate

BEYOND = 0.6
"""Barycentric coordinates that a foot may lie outside its triangle by."""

ON_TRIANGLE = 1e-3
"""The same where a foot is on its triangle, but for the edges' error."""

STARTS = np.array([(2, 2), (4, 1), (1, 4), (1, 1)]) / 6.0
"""Barycentric coordinates from which feet are sought."""

MOST_STEPS = 30
STEP = 1e-12
"""Newton's last step, in barycentric coordinates."""


@dataclass(frozen=True, eq=False)
class Feet:
    """Where lines meet triangles' sheets: rows of a table that `row` counts; `sense` is 1 where the line leaves."""

    row: np.ndarray
    share: np.ndarray
    distance: np.ndarray
    sense: np.ndarray

    def take(self, chosen: np.ndarray) -> Feet:
        """Return the chosen feet, by a mask or by their places."""
        return Feet(self.row[chosen], self.share[chosen], self.distance[chosen], self.sense[chosen])


def _joined(first: Feet, second: Feet) -> Feet:
    return Feet(*(np.concatenate([getattr(first, f.name), getattr(second, f.name)]) for f in fields(Feet)))


class PatchesCrosser:
    """The curved triangles of a body, and the crossings of pairs (line, triangle) with them."""

    def __init__(self, patches: Patches) -> None:
        self.patches = patches
        self.triangles = CurvedTriangles.of(patches)

    def __call__(
        self, origins: np.ndarray, directions: np.ndarray, line: np.ndarray, triangle: np.ndarray
    ) -> tuple[np.ndarray, ...]:
        """Return line (k,), distance in mm (k,), whether it enters (k,), and outward unit normal (k, 3).

        Parameters
        ----------
        origins, directions : array (n, 3)
        line, triangle : int array (c,)
            Candidates: pairs whose boxes meet.
        """
        table = self.triangles
        frame = _Frames(origins, directions)
        turns = self._winding_numbers(frame, line, triangle)
        slant = np.abs(_dot(directions[line], table.cone_axis[triangle]))
        kept = (turns != 0) | (slant <= table.cone_sine[triangle])
        line, triangle, turns = line[kept], triangle[kept], turns[kept]
        rays = origins[line], directions[line]
        every = np.arange(len(line))
        feet = self._feet(*rays, triangle, np.repeat(every, len(STARTS)), np.tile(STARTS, (len(line), 1)))
        # Where only one foot of a pair was found, Newton is kept from finding it again.
        alone = feet.take(np.unique(feet.row, return_index=True)[1])
        entered, left = (np.isin(alone.row, feet.row[feet.sense == sense]) for sense in (-1, 1))
        wanted = turns[alone.row]
        alone = alone.take((entered != left) & ((wanted == 0) | np.where(wanted < 0, ~entered, ~left)))
        row, share = np.repeat(alone.row, len(STARTS)), np.tile(STARTS, (len(alone.row), 1))
        others = self._feet(*rays, triangle, row, share, np.repeat(alone.share, len(STARTS), axis=0))
        feet = _joined(feet, others)

        single = np.flatnonzero(turns)
        chosen = self._of_sense(feet, turns, single, frame, line, triangle)
        pairs = _pairs(feet, turns)
        both = _joined(chosen, pairs)
        sense = np.concatenate([turns[chosen.row], pairs.sense])
        normal = self._normals(triangle[both.row], both.share)
        found = line[both.row], both.distance, sense, normal
        line, distance, sense, normal = (np.repeat(column, np.abs(sense), axis=0) for column in found)
        return line, distance, sense < 0, normal

    def _winding_numbers(self, frame: _Frames, line: np.ndarray, triangle: np.ndarray) -> np.ndarray:
        table = self.triangles
        turns = np.zeros(len(line), dtype=np.int64)
        for side in range(3):
            # Far edges wind as their chords do, so all may be followed along their parabolas.
            points = frame.project(line, table.edges_mm[table.edge[triangle, side]])
            start, middle, end = points[:, :-1:2], points[:, 1::2], points[:, 2::2]
            once = (winding(start, end) + _lens(start, end, middle)).sum(axis=1)
            turns += np.where(table.along[triangle, side], once, -once)
        return turns

    def _feet(
        self,
        origins: np.ndarray,
        directions: np.ndarray,
        triangle: np.ndarray,
        row: np.ndarray,
        share: np.ndarray,
        but: np.ndarray | None = None,
    ) -> Feet:
        """Return the feet that Newton finds for lines `row` from barycentric coordinates `share`.

        With `but`, feet there are divided out of the equations (deflation: Brown and Gearhart, "Deflation techniques
        for the calculation of further solutions of a nonlinear system", Numerische Mathematik 16, 1971).
        """
        done = Feet(row[:0], share[:0], np.zeros(0), row[:0])
        for _ in range(MOST_STEPS):
            point, by_p, by_q = self._evaluate(triangle[row], share)
            direction = directions[row]
            gap = origins[row] - point
            volume = _dot(np.cross(by_p, by_q), direction)
            with np.errstate(divide="ignore", invalid="ignore"):
                step_p = _dot(np.cross(gap, by_q), direction) / volume
                step_q = _dot(np.cross(by_p, gap), direction) / volume
            step = np.column_stack([step_p, step_q])
            if but is not None:
                away = share - but
                square = _dot(away, away)
                with np.errstate(divide="ignore", invalid="ignore"):
                    step = step / (1.0 + 2.0 * _dot(away, step) / (square * (1.0 + square)))[:, None]
            size = np.abs(step).max(axis=1)
            finite = np.isfinite(size)
            step = np.where(finite[:, None], step, 0.0)
            limited = step * np.minimum(1.0, 0.5 / np.maximum(np.abs(step).max(axis=1), 0.5))[:, None]
            distance = _dot(limited[:, :1] * by_p + limited[:, 1:] * by_q - gap, direction)
            share = share + limited
            near = finite & np.all(share >= -BEYOND, axis=1) & (share.sum(axis=1) <= 1.0 + BEYOND)
            last = near & (size < STEP)
            sense = np.where(volume < 0.0, -1, 1)
            found = Feet(row[last], share[last], distance[last], sense[last])
            done = _joined(done, found)
            row, share = row[near & ~last], share[near & ~last]
            but = but if but is None else but[near & ~last]
            if len(row) == 0:
                break
        return done

    def _of_sense(
        self, feet: Feet, turns: np.ndarray, single: np.ndarray, frame: _Frames, line: np.ndarray, triangle: np.ndarray
    ) -> Feet:
        """Return for each row of `single` the foot of the sense that its winding number asks for, least outside.

        Where there is none, the flat triangle's point has to do.
        """
        right = feet.take(feet.sense * turns[feet.row] > 0)
        outside = np.maximum(np.maximum(-right.share.min(axis=1), right.share.sum(axis=1) - 1.0), 0.0)
        order = np.lexsort((outside, right.row))
        right = right.take(order)
        right = right.take(np.append(True, np.diff(right.row) > 0)) if len(order) else right
        lost = np.setdiff1d(single, right.row)
        corners = frame.project(line[lost], self.triangles.corners_mm[triangle[lost]])
        areas = [_area(corners[:, k], corners[:, (k + 1) % 3]) for k in range(3)]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.column_stack([areas[2], areas[0]]) / sum(areas)[:, None]
        inside = np.all(share >= -BEYOND, axis=1) & (share.sum(axis=1) <= 1.0 + BEYOND)
        share = np.where(inside[:, None], share, 1.0 / 3.0)
        weights = np.column_stack([1.0 - share.sum(axis=1), share])
        distance = _dot(weights, corners[..., 2]) / frame.along[line[lost]]
        flat = Feet(lost, share, distance, np.sign(turns[lost]))
        return _joined(right, flat)

    def _normals(self, triangle: np.ndarray, share: np.ndarray) -> np.ndarray:
        _, by_p, by_q = self._evaluate(triangle, share)
        normal = np.cross(by_p, by_q)
        collapsed = _dot(normal, normal) <= 1e-16 * _dot(by_p, by_p) * _dot(by_q, by_q)
        inner = share[collapsed] + TOWARDS_MIDDLE * (1.0 / 3.0 - share[collapsed])
        _, by_p, by_q = self._evaluate(triangle[collapsed], inner)
        normal[collapsed] = np.cross(by_p, by_q)
        return normal / np.sqrt(_dot(normal, normal))[:, None]

    def _evaluate(self, triangle: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        table = self.triangles
        return evaluate(self.patches, table.sheet, table.uv, table.pole, triangle, share)


class _Frames:
    """Space seen along lines: the line at (0, 0), its largest component as third axis, the others sheared."""

    def __init__(self, origins: np.ndarray, directions: np.ndarray) -> None:
        forward = np.argmax(np.abs(directions), axis=1)
        self.along = np.take_along_axis(directions, forward[:, None], 1)[:, 0]
        axes = np.stack([(forward + 1) % 3, (forward + 2) % 3, forward], axis=1)
        axes[self.along < 0.0, :2] = axes[self.along < 0.0, 1::-1]
        self.axes = axes
        self.origins = origins
        self.shear = np.take_along_axis(directions, axes[:, :2], 1) / self.along[:, None]

    def project(self, line: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return points (k, s, 3) as lines (k,) see them."""
        seen = np.take_along_axis(points - self.origins[line][:, None], self.axes[line][:, None], 2)
        seen[..., :2] -= self.shear[line][:, None] * seen[..., 2:]
        return seen


def winding(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return what edges from p to q (..., 2 or 3) add to winding numbers about the origin of the first two axes.

    1 or -1 where the edge crosses the half-axis x > 0. The way back adds the opposite, in floating point too.
    """
    falls, rises = p[..., 1] >= 0.0, q[..., 1] >= 0.0
    area = _area(p, q)
    return np.where(falls == rises, 0, np.where(rises, area > 0.0, -(area < 0.0).astype(np.int64)))


def _lens(p: np.ndarray, q: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Return how often the loop from p along the parabola through the middle to q, and straight back, winds."""
    control = 2.0 * middle - 0.5 * (p + q)
    a, b, c = _area(p, control), _area(control, q), _area(q, p)
    between = c * c < 4.0 * a * b
    positive, negative = (a > 0.0) & (b > 0.0) & (c > 0.0), (a < 0.0) & (b < 0.0) & (c < 0.0)
    return np.where(between & positive, 1, np.where(between & negative, -1, 0))


def _pairs(feet: Feet, turns: np.ndarray) -> Feet:
    """Return the feet of lines that enter and leave one triangle: pairs of feet that lie on it."""
    outside = np.maximum(np.maximum(-feet.share.min(axis=1), feet.share.sum(axis=1) - 1.0), 0.0)
    near = (turns[feet.row] == 0) & (outside <= ON_TRIANGLE)
    feet, outside = feet.take(near), outside[near]
    order = np.lexsort((outside, feet.sense, feet.row))
    feet, outside = feet.take(order), outside[order]
    first = (np.diff(feet.row, prepend=-1) != 0) | (np.diff(feet.sense, prepend=0) != 0)
    feet = feet.take(first)
    both = (feet.sense[:-1] < 0) & (feet.sense[1:] > 0) & (feet.row[:-1] == feet.row[1:])
    entering = np.flatnonzero(both)
    return feet.take(np.concatenate([entering, entering + 1]))


def _area(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    return p[..., 0] * q[..., 1] - q[..., 0] * p[..., 1]


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...k,...k->...", a, b)
