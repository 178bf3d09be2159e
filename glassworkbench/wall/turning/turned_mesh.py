"""The mesh of a body of revolution, from its meridian."""

from __future__ import annotations

import itertools

import numpy as np

from glassworkbench.scene import Mesh
from glassworkbench.wall.turning.bezier import evaluate, unit

TURN = 0.2
"""Largest angle (rad) between neighbouring normals of a smooth stretch, along the meridian and around the axis."""

ROW_MM = 10.0
"""Largest distance between neighbouring rings."""


def turned_mesh(chain: np.ndarray, smooth_runs: tuple[tuple[int, int], ...], deviation_mm: float) -> Mesh:
    """Return the closed mesh of a meridian chain (n, 4, 3) from axis to axis, the body to its left.

    Parameters
    ----------
    chain : array (n, 4, 3)
    smooth_runs : tuple of (int, int)
        Half-open ranges of segments within which the tangent is continuous; between them edges stay sharp.
    deviation_mm : float
        Largest distance of the triangles from the surface. Vertices and their normals are exact.
    """
    around = _steps(2.0 * np.pi * chain[:, :, 0].max(), 2.0 * np.pi, deviation_mm)
    angle = 2.0 * np.pi * np.arange(around) / around
    vertices, normals, triangles = [], [], []
    for first, last in smooth_runs:
        points, tangents = _rings(chain[first:last], deviation_mm)
        # Adding 0 makes -0 of a vertex on the axis 0: the mesh is closed where positions are the same.
        vertices.append(_turned(points[:, 0], points[:, 1], angle) + 0.0)
        normals.append(_turned(tangents[:, 1], -tangents[:, 0], angle))
        start = around * sum(len(rings) for rings in vertices[:-1])
        for ring, (low, high) in enumerate(itertools.pairwise(points[:, 0])):
            here = start + around * ring + np.arange(around)
            beside = start + around * ring + (np.arange(around) + 1) % around
            if low > 0.0:
                triangles.append(np.column_stack([here, beside, beside + around]))
            if high > 0.0:
                triangles.append(np.column_stack([here, beside + around, here + around]))
    return Mesh(
        np.concatenate(vertices).reshape(-1, 3), np.concatenate(triangles), np.concatenate(normals).reshape(-1, 3)
    )


def _steps(length_mm: float, turn: float, deviation_mm: float) -> int:
    """Return how many chords follow a curve of a length that turns by an angle (rad): their sagitta is l theta / 8."""
    return int(np.ceil(max(turn / TURN, np.sqrt(length_mm * turn / (8.0 * deviation_mm)), length_mm / ROW_MM, 1.0)))


def _rings(run: np.ndarray, deviation_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 2) on a smooth run of segments, each joint once, and unit tangents."""
    points, tangents = [], []
    for number, segment in enumerate(run):
        probe, slopes = evaluate(segment, np.linspace(1e-9, 1.0 - 1e-9, 17))
        length = float(np.linalg.norm(np.diff(probe, axis=0), axis=1).sum())
        turn = float(np.abs(np.diff(np.unwrap(np.arctan2(slopes[:, 1], slopes[:, 0])))).sum())
        u = np.linspace(0.0, 1.0, _steps(length, turn, deviation_mm) + 1)[int(number > 0) :]
        points.append(evaluate(segment, u)[0])
        # A segment whose handle has no length still has a tangent next to its end.
        tangents.append(unit(evaluate(segment, np.clip(u, 1e-9, 1.0 - 1e-9))[1]))
    points[0][0], points[-1][-1] = run[0, 0, :2], run[-1, 3, :2]
    return np.concatenate(points), np.concatenate(tangents)


def _turned(radial: np.ndarray, axial: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return vectors (rings, angles, 3) with these parts away from the axis and along it."""
    across = radial[:, None]
    return np.stack(
        [across * np.cos(angle), across * np.sin(angle), np.broadcast_to(axial[:, None], (len(axial), len(angle)))], 2
    )
