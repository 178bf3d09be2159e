"""Where straight lines cross the surfaces of bodies, in numpy: all crossings, their sense and normals.

Each crosser answers for n lines at once. Whether a crossing exists, and whether it enters or leaves, is decided by
signs at shared points (joints of a meridian, edges of triangles), never by comparing distances: neighbouring pieces
decide alike, so a line that enters a closed body also leaves it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np

from glassworkbench.scene import Ellipsoid, Ellipsoids, Mesh, Patches, Revolved, Surface
from glassworkbench.tracer.reference_patches import PatchesCrosser, winding
from glassworkbench.tracer.reference_revolved import RevolvedCrosser

LINES_AT_ONCE = 4096
"""Lines that are intersected together; bounds the memory of the tables of lines times pieces."""


@dataclass(frozen=True, eq=False)
class Crossings:
    """Crossings of lines with one surface, in no particular order.

    Parameters
    ----------
    line : int array (k,)
        Which line.
    distance_mm : array (k,)
        Along the line's unit direction; negative behind its origin.
    entering : bool array (k,)
        Whether the line enters the body there.
    normal : array (k, 3)
        Unit outward normal of the surface.
    smooth_normal : array (k, 3)
        Unit outward normal that light is bent by: the interpolated one on a mesh, else the same.
    """

    line: np.ndarray
    distance_mm: np.ndarray
    entering: np.ndarray
    normal: np.ndarray
    smooth_normal: np.ndarray


Crosser = Callable[[np.ndarray, np.ndarray], Crossings]
"""Takes origins (n, 3) in mm and unit directions (n, 3)."""


def crosser(surface: Surface) -> Crosser:
    """Return the function that finds all crossings of lines with `surface`."""
    if isinstance(surface, Revolved):
        return _in_chunks(_cross_revolved(RevolvedCrosser(surface)))
    if isinstance(surface, Mesh):
        return _in_chunks(_MeshCrosser(surface))
    if isinstance(surface, Patches):
        return _in_chunks(_cross_patches(PatchesCrosser(surface)))
    if isinstance(surface, Ellipsoids):
        return _in_chunks(_cross_ellipsoids(surface))
    return lambda origins, directions: _cross_ellipsoid(surface, origins, directions)


def largest_coordinate_mm(surface: Surface) -> float:
    """Return a number no smaller than any coordinate of the surface in magnitude."""
    if isinstance(surface, Revolved):
        return float(np.abs(surface.base_mm).max() + np.linalg.norm(surface.meridian[:, :, :2], axis=-1).max())
    if isinstance(surface, Mesh):
        return float(np.abs(surface.vertices_mm).max())
    if isinstance(surface, Patches):
        return 1.1 * float(np.abs(surface.mesh.vertices_mm).max())
    if isinstance(surface, Ellipsoids):
        return float((np.abs(surface.centres_mm) + surface.reaches_mm()).max())
    return float(np.abs(surface.centre_mm).max() + surface.semi_axes_mm.max())


def _in_chunks(cross: Crosser) -> Crosser:
    def cross_all(origins: np.ndarray, directions: np.ndarray) -> Crossings:
        parts = []
        for start in range(0, max(len(origins), 1), LINES_AT_ONCE):
            chunk = slice(start, start + LINES_AT_ONCE)
            part = cross(origins[chunk], directions[chunk])
            parts.append([part.line + start, *(getattr(part, f.name) for f in fields(part)[1:])])
        return Crossings(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    return cross_all


def _cross_revolved(cross: RevolvedCrosser) -> Crosser:
    def cross_lines(origins: np.ndarray, directions: np.ndarray) -> Crossings:
        line, distance, entering, normal = cross(origins, directions)
        return Crossings(line, distance, entering, normal, normal)

    return cross_lines


def _cross_patches(cross: PatchesCrosser) -> Crosser:
    tree = _BoxTree(cross.triangles.low_mm, cross.triangles.high_mm, TRIANGLES_A_LEAF)

    def cross_lines(origins: np.ndarray, directions: np.ndarray) -> Crossings:
        candidates = tree.candidates(origins, directions)
        line, distance, entering, normal = cross(origins, directions, *candidates)
        return Crossings(line, distance, entering, normal, normal)

    return cross_lines


# ---------------------------------------------------------------------------------------------------------------
# Ellipsoids

ELLIPSOIDS_A_LEAF = 4


def _cross_ellipsoid(ellipsoid: Ellipsoid, origins: np.ndarray, directions: np.ndarray) -> Crossings:
    to_sphere = ellipsoid.rotation / ellipsoid.semi_axes_mm
    return _cross_unit_spheres(origins - ellipsoid.centre_mm, directions, np.tile(to_sphere, (len(origins), 1, 1)))


def _cross_ellipsoids(ellipsoids: Ellipsoids) -> Crosser:
    reach = ellipsoids.reaches_mm()
    tree = _BoxTree(ellipsoids.centres_mm - reach, ellipsoids.centres_mm + reach, ELLIPSOIDS_A_LEAF)
    to_sphere = ellipsoids.rotations / ellipsoids.semi_axes_mm[:, None, :]

    def cross_lines(origins: np.ndarray, directions: np.ndarray) -> Crossings:
        line, number = tree.candidates(origins, directions)
        found = _cross_unit_spheres(origins[line] - ellipsoids.centres_mm[number], directions[line], to_sphere[number])
        return replace(found, line=line[found.line])

    return cross_lines


def _cross_unit_spheres(origins: np.ndarray, directions: np.ndarray, to_sphere: np.ndarray) -> Crossings:
    """Cross lines each with its own unit sphere, from the point nearest to its centre.

    Row vectors from the centre, times `to_sphere` (n, 3, 3), are in the sphere's coordinates.
    """
    origin = np.einsum("ki,kij->kj", origins, to_sphere)
    direction = np.einsum("ki,kij->kj", directions, to_sphere)
    speed_squared = _dot(direction, direction)
    nearest = -_dot(origin, direction) / speed_squared
    foot = origin + nearest[:, None] * direction
    # The first foot is as inexact as the origin is far; from there a second one is exact.
    correction = -_dot(foot, direction) / speed_squared
    foot = foot + correction[:, None] * direction
    foot_radius = np.sqrt(_dot(foot, foot))
    line = np.flatnonzero(foot_radius < 1.0)
    half = np.sqrt((1.0 - foot_radius[line]) * (1.0 + foot_radius[line]) / speed_squared[line])
    line = np.concatenate([line, line])
    step = np.concatenate([-half, half])
    point = foot[line] + step[:, None] * direction[line]
    normal = _unit(np.einsum("kj,kij->ki", point, to_sphere[line]))
    distance = nearest[line] + correction[line] + step
    return Crossings(line, distance, step < 0.0, normal, normal)


# ---------------------------------------------------------------------------------------------------------------
# Meshes

TRIANGLES_A_LEAF = 4


class _MeshCrosser:
    """Triangles in a tree of boxes, tested by the winding numbers of their projections about the line.

    Projected by the shear of Woop, Benthin and Wald, "Watertight ray/triangle intersection", JCGT 2 (2013). What an
    edge adds to the winding number it takes away in the triangle on its other side, so over a closed mesh every line
    enters as often as it leaves.
    """

    def __init__(self, mesh: Mesh) -> None:
        self.corners = mesh.vertices_mm[mesh.triangles]
        self.corner_normals = mesh.normals[mesh.triangles]
        a, b, c = (self.corners[:, k] for k in range(3))
        self.normal = _unit(np.cross(b - a, c - a))
        self.tree = _BoxTree(self.corners.min(axis=1), self.corners.max(axis=1), TRIANGLES_A_LEAF)

    def __call__(self, origins: np.ndarray, directions: np.ndarray) -> Crossings:
        line, triangle = self.tree.candidates(origins, directions)
        forward = np.argmax(np.abs(directions), axis=1)
        down = np.take_along_axis(directions, forward[:, None], 1)[:, 0] < 0.0
        axes = np.stack([(forward + 1) % 3, (forward + 2) % 3, forward], axis=1)
        axes[down, :2] = axes[down, 1::-1]
        direction = np.take_along_axis(directions, axes, 1)[line]
        origin = np.take_along_axis(origins, axes, 1)[line]
        corners = np.take_along_axis(self.corners[triangle], axes[line][:, None, :], 2) - origin[:, None, :]
        shear = direction[:, :2] / direction[:, 2:]
        x = corners[..., 0] - shear[:, :1] * corners[..., 2]
        y = corners[..., 1] - shear[:, 1:] * corners[..., 2]
        seen = np.stack([x, y], axis=2)
        ends = [(seen[:, (k + 1) % 3], seen[:, (k + 2) % 3]) for k in range(3)]
        areas = np.stack([p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1] for p, q in ends], axis=1)
        turns = sum(winding(p, q) for p, q in ends)
        hit = turns != 0
        line, triangle, areas, turns = line[hit], triangle[hit], areas[hit], turns[hit]
        # A triangle seen edge-on, to the last digit, is met at its middle.
        areas[areas.sum(axis=1) == 0.0] = 1.0
        total = areas.sum(axis=1)
        share = areas / total[:, None]
        distance = _dot(share, corners[hit, :, 2]) / direction[hit, 2]
        normal = self.normal[triangle]
        smooth = _unit(np.einsum("kc,kcx->kx", share, self.corner_normals[triangle]))
        smooth = np.where(_dot(smooth, normal)[:, None] < 0.0, -smooth, smooth)
        smooth = np.where(_dot(smooth, smooth)[:, None] == 0.0, normal, smooth)
        # Seen along the line, a triangle that turns clockwise shows its outside.
        return Crossings(line, distance, turns < 0, normal, smooth)


class _BoxTree:
    """Boxes halved at the median of their centres along the widest side, down to leaves of a few boxes."""

    def __init__(self, low: np.ndarray, high: np.ndarray, leaf_size: int) -> None:
        self.order = np.arange(len(low))
        centres = 0.5 * (low + high)
        margin = 1e-12 * max(np.abs(low).max(), np.abs(high).max())
        nodes: list[tuple[int, int]] = [(0, len(low))]
        first_child: list[int] = []
        boxes: list[tuple[np.ndarray, np.ndarray]] = []
        for start, stop in nodes:
            members = self.order[start:stop]
            boxes.append((low[members].min(axis=0) - margin, high[members].max(axis=0) + margin))
            if stop - start <= leaf_size:
                first_child.append(-1)
                continue
            widest = int(np.argmax(np.ptp(centres[members], axis=0)))
            self.order[start:stop] = members[np.argsort(centres[members, widest], kind="stable")]
            middle = (start + stop) // 2
            first_child.append(len(nodes))
            nodes += [(start, middle), (middle, stop)]
        self.range = np.array(nodes)
        self.first_child = np.array(first_child)
        self.low = np.array([box[0] for box in boxes])
        self.high = np.array([box[1] for box in boxes])

    def candidates(self, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return pairs (line, box number) among which are all that meet on the whole line."""
        lines, members = [], []
        line, node = np.arange(len(origins)), np.zeros(len(origins), dtype=np.int64)
        with np.errstate(divide="ignore"):
            inverse = 1.0 / directions
        while len(line):
            with np.errstate(invalid="ignore"):
                first = (self.low[node] - origins[line]) * inverse[line]
                second = (self.high[node] - origins[line]) * inverse[line]
            # fmin and fmax pass over the NaN of a line that runs within a side of the box.
            near = np.fmax.reduce(np.fmin(first, second), axis=1)
            far = np.fmin.reduce(np.fmax(first, second), axis=1)
            meets = near <= far
            line, node = line[meets], node[meets]
            leaf = self.first_child[node] < 0
            start, stop = self.range[node[leaf]].T
            counts = stop - start
            lines.append(np.repeat(line[leaf], counts))
            offsets = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
            members.append(self.order[np.repeat(start, counts) + offsets])
            child = self.first_child[node[~leaf]]
            line = np.repeat(line[~leaf], 2)
            node = np.stack([child, child + 1], axis=1).ravel()
        return np.concatenate(lines), np.concatenate(members)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...k,...k->...", a, b)


def _unit(vectors: np.ndarray) -> np.ndarray:
    """Scale to length 1; the zero vector stays."""
    length = np.sqrt(_dot(vectors, vectors))[..., None]
    return vectors / np.where(length > 0.0, length, 1.0)
