"""The largest body of revolution within a cavity, as a meridian."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.wall.levels.room import Room
from glassworkbench.wall.turning.bezier import line, unit

CREASE = np.cos(np.radians(8.0))
"""Tangents of neighbouring points that differ by more have a crease between them."""

JOINT = 1e-3
"""A crease that is nearer to a point than this share of the distance to the next lies at it."""

CLOSE_MM = 1e-6

CORRECTIONS = 6

STUCK_SHARE = 0.3
"""A step that is corrected to less than this share of itself has met a crease."""

MOST_POINTS = 20_000


@dataclass(frozen=True, eq=False)
class RoundRoom:
    """The lowest value of a room around the axis.

    Parameters
    ----------
    room : Room
    angles : int
        Half-planes that are looked at; 1 for a room that is round itself.
    """

    room: Room
    angles: int

    def value_and_gradient(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the values (n,) at points (n, 2) (r, z), and the unit gradients (n, 2) in the meridian half-plane."""
        angle = 2.0 * np.pi * np.arange(self.angles) / self.angles
        cosine, sine = np.cos(angle), np.sin(angle)
        around = np.stack(
            [points[:, :1] * cosine, points[:, :1] * sine, np.repeat(points[:, 1:], self.angles, axis=1)], axis=2
        )
        value, gradient = self.room.value_and_gradient(around.reshape(-1, 3))
        value, gradient = value.reshape(-1, self.angles), gradient.reshape(-1, self.angles, 3)
        lowest = value.argmin(axis=1)
        row = np.arange(len(points))
        g = gradient[row, lowest]
        flat = np.column_stack([g[:, 0] * cosine[lowest] + g[:, 1] * sine[lowest], g[:, 2]])
        return value[row, lowest], unit(flat)


def trace(room: RoundRoom, start: np.ndarray, step_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Follow the level from the axis at the bottom to the ceiling.

    Parameters
    ----------
    room : RoundRoom
    start : array (2,)
        A point of the axis within the room.
    step_mm : float

    Returns
    -------
    points, tangents : array (n, 2)

    Raises
    ------
    GlassWorkbenchError
        If the level does not lead from the axis to the ceiling.
    """
    point = np.array(start, dtype=np.float64)
    value, _ = room.value_and_gradient(point[None])
    while value[0] > CLOSE_MM:
        # The level is nowhere nearer than the value.
        point[1] -= value[0]
        value, _ = room.value_and_gradient(point[None])
    points, tangents = [], []
    ceiling = room.room.ceiling_mm
    while len(points) < MOST_POINTS:
        value, gradient = room.value_and_gradient(point[None])
        # With the room to the left of travel, its gradient turned clockwise leads on.
        tangent = np.array([gradient[0, 1], -gradient[0, 0]])
        points.append(point)
        tangents.append(tangent if len(points) > 1 else np.array([1.0, 0.0]))
        if point[1] >= ceiling - CLOSE_MM and len(points) > 1:
            return np.array(points), np.array(tangents)
        ahead = _corrected(room, point + step_mm * tangents[-1])
        if np.linalg.norm(ahead - point) < STUCK_SHARE * step_mm:
            # At a crease the way on runs along the side that the step went through.
            _, beyond = room.value_and_gradient((point + step_mm * tangents[-1])[None])
            ahead = _corrected(room, point + step_mm * np.array([beyond[0, 1], -beyond[0, 0]]))
        if ahead[1] >= ceiling - CLOSE_MM:
            rise = (ceiling - point[1]) / max(tangents[-1][1], 1e-9)
            ahead = point + min(rise, step_mm) * tangents[-1]
            ahead[1] = ceiling
            points.append(ahead)
            tangents.append(tangents[-1])
            return np.array(points), np.array(tangents)
        if ahead[0] < 0.0 or np.linalg.norm(ahead - point) < 0.05 * step_mm:
            break
        point = ahead
    raise GlassWorkbenchError("no body of revolution that reaches from the base to the mouth fits inside the wall")


def _corrected(room: RoundRoom, point: np.ndarray) -> np.ndarray:
    for _ in range(CORRECTIONS):
        value, gradient = room.value_and_gradient(point[None])
        if abs(value[0]) < CLOSE_MM:
            break
        point = point - value[0] * gradient[0]
    return point


def chain_of(points: np.ndarray, tangents: np.ndarray) -> tuple[np.ndarray, tuple[tuple[int, int], ...]]:
    """Return cubics (n, 4, 3) through points (m, 2) with given tangents, sharp at creases, and their smooth runs.

    A crease lies where the tangents of two neighbours meet.
    """
    segments, starts = [], [0]
    for a, b, s, t in zip(points[:-1], points[1:], tangents[:-1], tangents[1:], strict=True):
        length = float(np.linalg.norm(b - a))
        if s @ t < CREASE:
            along = np.linalg.solve(np.column_stack([s, -t]), b - a) / length
            corner = a + along[0] * length * s
            if -JOINT < along[0] < 4.0 and -4.0 < along[1] < JOINT:
                if along[0] > JOINT:
                    segments.append(line(a, corner))
                starts.append(len(segments))
                if along[1] < -JOINT:
                    segments.append(line(corner if along[0] > JOINT else a, b))
                else:
                    segments[-1][3, :2] = b
                continue
        controls = np.array([a, a + length / 3.0 * s, b - length / 3.0 * t, b])
        segments.append(np.column_stack([controls, np.ones(4)]))
    ends = [*starts[1:], len(segments)]
    runs = tuple((first, last) for first, last in zip(starts, ends, strict=True) if last > first)
    return np.array(segments), runs
