"""The glass as one closed mesh, for molds that are meshes: outside and inside, joined by a level rim."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.scene import Mesh
from glassworkbench.wall.measuring.measure import in_finish_plane


def glass_mesh(outer: Mesh, mouth: np.ndarray, inside: Mesh) -> Mesh:
    """Return the closed mesh between an outside and an inside, both upright.

    Parameters
    ----------
    outer : Mesh
    mouth : bool array (m,)
        The triangles of `outer` that close the mouth.
    inside : Mesh
        Closed level at the finish plane.

    Raises
    ------
    GlassWorkbenchError
        If the edges of mouth and inside do not run around the axis once, so that no rim joins them.
    """
    outside = outer.vertices_mm[outer.triangles[~mouth]]
    cavity = inside.vertices_mm[inside.triangles[~in_finish_plane(inside)]][:, ::-1]
    corners = np.concatenate([outside, cavity, _rim(_edge(outside), _edge(cavity))])
    vertices, place = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    try:
        return Mesh(vertices, place.reshape(-1, 3))
    except InputError as error:
        raise GlassWorkbenchError(f"the outside and the inside do not join at the mouth ({error})") from error


def write_stl(mesh: Mesh, placement: np.ndarray, path: Path) -> None:
    """Write a mesh, moved by a rigid motion (4, 4), as STL."""
    corners = (mesh.vertices_mm @ placement[:3, :3].T + placement[:3, 3])[mesh.triangles]
    importlib.import_module("Mesh").Mesh(corners.tolist()).write(str(path), "STL")


def _edge(corners: np.ndarray) -> np.ndarray:
    """Return the points (n, 3) of the free edge of triangles (m, 3, 3), by their angle about the axis."""
    points, place = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    place = place.reshape(-1, 3)
    starts, ends = place.ravel(), np.roll(place, -1, axis=1).ravel()
    free = ~np.isin(starts * len(points) + ends, ends * len(points) + starts)
    edge = points[np.unique(starts[free])]
    return edge[np.argsort(np.arctan2(edge[:, 1], edge[:, 0]))]


def _rim(outer: np.ndarray, inner: np.ndarray) -> np.ndarray:
    """Return the triangles (k, 3, 3) between two rings about the axis, facing up."""
    turns = [np.append(angle, angle[:1] + 2.0 * np.pi) for angle in (_angles(outer), _angles(inner))]
    i = j = 0
    triangles = []
    while i < len(outer) or j < len(inner):
        here, there = outer[i % len(outer)], inner[j % len(inner)]
        if j == len(inner) or (i < len(outer) and turns[0][i + 1] <= turns[1][j + 1]):
            i += 1
            triangles.append((here, outer[i % len(outer)], there))
        else:
            j += 1
            triangles.append((here, inner[j % len(inner)], there))
    return np.array(triangles)


def _angles(points: np.ndarray) -> np.ndarray:
    return np.arctan2(points[:, 1], points[:, 0])
