"""Cuts a closed mesh level and closes it there."""

from __future__ import annotations

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.scene import Mesh


def below(mesh: Mesh, height_mm: float) -> Mesh:
    """Return the part of an upright closed mesh below a height, closed by a flat face.

    Raises
    ------
    GlassWorkbenchError
        If the section is not one outline that can be seen whole from its middle.
    """
    corners, normals = mesh.vertices_mm[mesh.triangles], mesh.normals[mesh.triangles]
    over = corners[:, :, 2] > height_mm
    count = over.sum(axis=1)
    kept, kept_normals = [corners[count == 0]], [normals[count == 0]]
    for many in (1, 2):
        rows = np.flatnonzero(count == many)
        # Turn each so that its first corner is the one alone on its side.
        alone = np.argmax(over[rows] if many == 1 else ~over[rows], axis=1)
        turn = ((alone[:, None] + np.arange(3)) % 3)[:, :, None]
        p, q, r = np.moveaxis(np.take_along_axis(corners[rows], turn, axis=1), 1, 0)
        n, m, o = np.moveaxis(np.take_along_axis(normals[rows], turn, axis=1), 1, 0)
        if many == 1:
            on_q, at_q = _crossing(q, p, m, n, height_mm)
            on_r, at_r = _crossing(r, p, o, n, height_mm)
            kept += [np.stack([on_q, q, r], 1), np.stack([on_q, r, on_r], 1)]
            kept_normals += [np.stack([at_q, m, o], 1), np.stack([at_q, o, at_r], 1)]
        else:
            on_q, at_q = _crossing(p, q, n, m, height_mm)
            on_r, at_r = _crossing(p, r, n, o, height_mm)
            kept.append(np.stack([p, on_q, on_r], 1))
            kept_normals.append(np.stack([n, at_q, at_r], 1))
    corners, normals = np.concatenate(kept), np.concatenate(kept_normals)
    # What touches the height with a corner or a side leaves triangles without area.
    whole = np.all(np.any(corners != np.roll(corners, 1, axis=1), axis=2), axis=1)
    corners, normals = corners[whole], normals[whole]
    lid = _lid(corners, height_mm)
    upward = np.broadcast_to(np.array([0.0, 0.0, 1.0]), lid.shape)
    both = np.concatenate([np.concatenate([corners, normals], 2), np.concatenate([lid, upward], 2)]).reshape(-1, 6)
    both, place = np.unique(both, axis=0, return_inverse=True)
    return Mesh(both[:, :3], place.reshape(-1, 3), both[:, 3:])


def _crossing(
    low: np.ndarray, high: np.ndarray, low_normals: np.ndarray, high_normals: np.ndarray, height_mm: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return where lines from below to above pass a height, the same for both triangles at a side, and the normals."""
    share = ((height_mm - low[:, 2]) / (high[:, 2] - low[:, 2]))[:, None]
    points = low + share * (high - low)
    points[:, 2] = height_mm
    normals = low_normals + share * (high_normals - low_normals)
    return points, normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)


def _lid(corners: np.ndarray, height_mm: float) -> np.ndarray:
    """Return the triangles (k, 3, 3) from the middle of the section to its sides."""
    _, place = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    place = place.reshape(-1, 3)
    starts, ends = place.ravel(order="F"), np.roll(place, -1, axis=1).ravel(order="F")
    size = int(place.max()) + 1
    free = ~np.isin(starts * size + ends, ends * size + starts)
    p = np.concatenate([corners[:, k] for k in (0, 1, 2)])[free]
    q = np.concatenate([corners[:, k] for k in (1, 2, 0)])[free]
    middle = np.array([*p[:, :2].sum(axis=0) / max(len(p), 1), height_mm])
    turns = np.cross((p - middle)[:, :2], (q - middle)[:, :2])
    if len(p) == 0 or np.any(turns >= 0.0):
        raise GlassWorkbenchError(f"its section at height {height_mm:.1f} mm is not one simple outline")
    return np.stack([q, p, np.broadcast_to(middle, p.shape)], axis=1)
