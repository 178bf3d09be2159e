"""Volumes and centres of gravity, from exact integrals or fine meshes: OCC's own lie on long turned faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.scene import Mesh
from glassworkbench.spatial import sags
from glassworkbench.wall.measuring.surface import facets
from glassworkbench.wall.turning.bezier import evaluate


@dataclass(frozen=True, eq=False)
class Volume:
    """Volume (mm^3) and centroid (3,) (mm) of a body."""

    volume_mm3: float
    centroid_mm: np.ndarray

    def minus(self, other: Volume) -> Volume:
        """Return this body without another that lies inside it."""
        volume = self.volume_mm3 - other.volume_mm3
        moment = self.volume_mm3 * self.centroid_mm - other.volume_mm3 * other.centroid_mm
        return Volume(volume, moment / volume)


def revolved_volume(chain: np.ndarray) -> Volume:
    """Return the volume that a meridian chain (n, 4, 3) from axis to axis turns through.

    Notes
    -----
    V = pi int r^2 dz and V z_c = pi int r^2 z dz along the chain, by Gauss's rule with 16 points a segment.
    """
    nodes, weights = np.polynomial.legendre.leggauss(16)
    u, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    volume = moment = 0.0
    for segment in chain:
        points, slopes = evaluate(segment, u)
        slice_volume = np.pi * weights * points[:, 0] ** 2 * slopes[:, 1]
        volume += float(slice_volume.sum())
        moment += float(slice_volume @ points[:, 1])
    return Volume(volume, np.array([0.0, 0.0, moment / volume]))


def mesh_volume(mesh: Mesh) -> Volume:
    """Return the volume inside the surface behind a closed mesh."""
    return volume_below(mesh, float(mesh.vertices_mm[:, 2].max()))


def volume_below(mesh: Mesh, level_mm: float) -> Volume:
    """Return the volume inside the surface behind a closed mesh, below the height z = `level_mm`.

    Notes
    -----
    The divergence theorem with the fields (0, 0, z - l), and for the moments (0, 0, x (z - l)), (0, 0, y (z - l)) and
    (0, 0, (z^2 - l^2) / 2): none flows through the plane z = l, so the triangles, cut there, give the volume without a
    lid. On each triangle the surface adds the mean of its bulge. The centroid of nothing is the lowest point.
    """
    whole = mesh.vertices_mm[mesh.triangles]
    corners, parts, shares = _below(whole, level_mm)
    upward = facets(corners)[:, 2]
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
    x, y, z = np.moveaxis(middles, 2, 0)
    volume = upward @ (z - level_mm).mean(axis=1)
    moment = np.array([upward @ field.mean(axis=1) for field in (x * (z - level_mm), y * (z - level_mm))])
    moment = np.append(moment, upward @ (0.5 * (z**2 - level_mm**2)).mean(axis=1))
    areas = np.linalg.norm(facets(whole), axis=1)
    bulge = (areas * sags(whole, mesh.normals[mesh.triangles]).sum(axis=1) / 12.0)[parts] * shares
    volume += bulge.sum()
    moment += bulge @ corners.mean(axis=1)
    if volume <= 0.0:
        return Volume(0.0, mesh.vertices_mm[int(np.argmin(mesh.vertices_mm[:, 2]))])
    return Volume(float(volume), moment / volume)


def _below(corners: np.ndarray, level_mm: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what triangles (m, 3, 3) have below a height: triangles, of which they are parts, and its shares."""
    low_first = np.argsort(corners[:, :, 2], axis=1)
    # Turned, not sorted: the sense of each triangle must stay.
    corners = np.take_along_axis(corners, ((low_first[:, :1] + np.arange(3)) % 3)[:, :, None], axis=1)
    below = corners[:, :, 2] <= level_mm
    whole = np.flatnonzero(below.all(axis=1))
    found = [(corners[whole], whole, np.ones(len(whole)))]
    # With the lowest corner first, a cut triangle keeps that corner, or a second one beside it.
    for second, third in ((False, False), (True, False), (False, True)):
        cut = np.flatnonzero(below[:, 0] & (below[:, 1] == second) & (below[:, 2] == third))
        a, b, c = np.moveaxis(corners[cut], 1, 0)
        if not second and not third:
            found.append(_part(cut, a, _at(a, b, level_mm), _at(a, c, level_mm), corners))
        elif second:
            at_b, at_c = _at(b, c, level_mm), _at(a, c, level_mm)
            found += [_part(cut, a, b, at_b, corners), _part(cut, a, at_b, at_c, corners)]
        else:
            at_b, at_c = _at(a, b, level_mm), _at(c, b, level_mm)
            found += [_part(cut, a, at_b, at_c, corners), _part(cut, a, at_c, c, corners)]
    return tuple(np.concatenate(column) for column in zip(*found, strict=True))


def _part(
    numbers: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray, corners: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    part = np.stack([a, b, c], axis=1)
    area = np.maximum(np.linalg.norm(facets(corners[numbers]), axis=1), 1e-300)
    return part, numbers, np.linalg.norm(facets(part), axis=1) / area


def _at(low: np.ndarray, high: np.ndarray, level_mm: float) -> np.ndarray:
    share = (level_mm - low[:, 2]) / (high[:, 2] - low[:, 2])
    return low + share[:, None] * (high - low)
