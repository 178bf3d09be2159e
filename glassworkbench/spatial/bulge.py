"""How far a curved surface stands out from the triangles whose corners lie on it."""

from __future__ import annotations

import numpy as np

SIDES = ((0, 1), (1, 2), (2, 0))


def sags(corners_mm: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return four times the height (m, 3) at which a surface stands over the middles of triangles' sides 01, 12, 20.

    Parameters
    ----------
    corners_mm, normals : array (m, 3, 3)
        Of each triangle, on the surface, and the surface's unit normals there.

    Notes
    -----
    At the two ends of a side the surface leaves it with the slopes f = -n_i . e and g = n_j . e, e the side's vector.
    Where they are equal it is an arc, to second order: it stands b_i b_j f above the side at the barycentric
    coordinates b, and a mesh so corrected is as good as one with many times the triangles. Where they differ the
    curvature is concentrated at one end, as on a long triangle along a straight body whose end reaches into the
    shoulder. There the mean of the slopes would put the surface far off; their harmonic mean follows the flatter end.
    """
    heights = np.empty((len(corners_mm), 3))
    for side, (i, j) in enumerate(SIDES):
        along = corners_mm[:, j] - corners_mm[:, i]
        start, end = -np.einsum("ij,ij->i", normals[:, i], along), np.einsum("ij,ij->i", normals[:, j], along)
        agree = start * end > 0.0
        heights[:, side] = np.where(agree, 2.0 * start * end / np.where(agree, start + end, 1.0), 0.0)
    return heights
