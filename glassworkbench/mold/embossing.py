"""What stands out a little from a container's outside: threads, lugs, lettering. The inside shall not show it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from glassworkbench.scene import Mesh

STANDING_SHARE = 0.1
"""Embossing stands out by less than this share of the body's largest radius."""

NARROW_SHARE = 0.25
"""No point of it is farther from the foot of its sides than this share of the largest radius."""

HOLLOW_RADIUS_MM = 3.0
"""A surface that curves inward more tightly than this is the fillet at the foot of something."""

CREASE_RAD = np.radians(15.0)
"""Where two faces meet inward at a larger angle something may begin to stand out."""

LEVEL = 0.7
"""The surface around embossing faces the same way as the embossing does on the whole (cosine); a pit's sides do not."""

BORDER_SAMPLES = 200
"""Places along a border at which it is looked at."""


def embossed(mesh: Mesh) -> np.ndarray:
    """Return which triangles (m,) of an upright outside are embossing.

    Embossing is bounded all around by a re-entrant edge or a tight fillet, stands out from the surface around it, by
    little, and is narrow. What goes once around the axis is none: a finish ring or a rim is a feature of the body.

    Parameters
    ----------
    mesh : Mesh
        The closed outside, its axis on z; its vertices lie on the surface.

    Returns
    -------
    bool array (m,)
        True on embossing and the fillets at its foot.
    """
    sides = _Sides(mesh)
    hollow = _hollow(mesh)
    open_side = ~sides.re_entrant & ~hollow[sides.left] & ~hollow[sides.right]
    piece = _connected(sides.left[open_side], sides.right[open_side], len(mesh.triangles))
    corners = mesh.vertices_mm[mesh.triangles]
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    area_of_piece = np.bincount(piece, areas, len(piece))
    # A fillet belongs to what stands on it: the foot of embossing is where the fillet ends.
    within = hollow[sides.left] & hollow[sides.right] & ~sides.re_entrant
    fillet = _connected(sides.left[within], sides.right[within], len(mesh.triangles))

    found = np.zeros(len(mesh.triangles), dtype=bool)
    radius = float(np.hypot(mesh.vertices_mm[:, 0], mesh.vertices_mm[:, 1]).max())
    largest = int(np.argmax(area_of_piece))
    for number in np.flatnonzero(np.bincount(piece[~hollow], minlength=len(piece))):
        if number == largest or area_of_piece[number] > 0.5 * area_of_piece[largest]:
            continue
        members = (piece == number) & ~hollow
        touched = np.concatenate(
            [
                fillet[sides.right[members[sides.left] & hollow[sides.right]]],
                fillet[sides.left[members[sides.right] & hollow[sides.left]]],
            ]
        )
        members |= hollow & np.isin(fillet, touched)
        if _stands_out(mesh, sides, members, areas, radius):
            found |= members
    return found


class _Sides:
    """The sides that two triangles share, matched by position."""

    def __init__(self, mesh: Mesh) -> None:
        _, place = np.unique(np.round(mesh.vertices_mm * 1e6).astype(np.int64), axis=0, return_inverse=True)
        ends = np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
        owner = np.tile(np.arange(len(mesh.triangles)), 3)
        places = np.sort(place.reshape(-1)[ends], axis=1).astype(np.int64)
        keys = places[:, 0] * (places.max() + 1) + places[:, 1]
        order = np.argsort(keys, kind="stable")
        pairs = np.flatnonzero(keys[order][1:] == keys[order][:-1])
        first, second = order[pairs], order[pairs + 1]
        self.left, self.right = owner[first], owner[second]
        self.ends = ends[first]
        """Vertex numbers (k, 2) of each side, in the left triangle's direction."""
        self.normals = mesh.normals[ends[first]].mean(axis=1), mesh.normals[ends[second]].mean(axis=1)
        """Mean normals of the left and of the right triangle's surface along each side."""
        self.places = place.reshape(-1)[ends[first]]
        self.re_entrant = self._meets_inward(mesh)

    def _meets_inward(self, mesh: Mesh) -> np.ndarray:
        centres = mesh.vertices_mm[mesh.triangles].mean(axis=1)
        middle = mesh.vertices_mm[self.ends].mean(axis=1)
        left, right = self.normals
        inward = _dot(left, centres[self.right] - middle) + _dot(right, centres[self.left] - middle) > 0.0
        lengths = np.linalg.norm(left, axis=1) * np.linalg.norm(right, axis=1)
        return inward & (_dot(left, right) < np.cos(CREASE_RAD) * lengths)


def _hollow(mesh: Mesh) -> np.ndarray:
    """Return which triangles curve inward tightly along one of their sides."""
    corners, normals = mesh.vertices_mm[mesh.triangles], mesh.normals[mesh.triangles]
    hollow = np.zeros(len(corners), dtype=bool)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        side = corners[:, j] - corners[:, i]
        hollow |= _dot(normals[:, j] - normals[:, i], side) < -_dot(side, side) / HOLLOW_RADIUS_MM
    return hollow


def _connected(left: np.ndarray, right: np.ndarray, count: int) -> np.ndarray:
    """Return for each of `count` things the lowest number of those that pairs connect it with."""
    lowest = np.arange(count)
    while True:
        a, b = lowest[left], lowest[right]
        apart = a != b
        if not np.any(apart):
            return lowest
        a, b, left, right = a[apart], b[apart], left[apart], right[apart]
        np.minimum.at(lowest, np.maximum(a, b), np.minimum(a, b))
        while not np.array_equal(lowest, lowest[lowest]):
            lowest = lowest[lowest]


def _stands_out(mesh: Mesh, sides: _Sides, members: np.ndarray, areas: np.ndarray, radius_mm: float) -> bool:
    border = members[sides.left] != members[sides.right]
    if not np.any(border) or any(abs(turns) > 0.5 for turns in _windings(mesh, sides, members, border)):
        return False
    left_is_member = members[sides.left[border]]
    around = np.where(left_is_member[:, None], sides.normals[1][border], sides.normals[0][border])
    around /= np.maximum(np.linalg.norm(around, axis=1, keepdims=True), 1e-300)
    foot = mesh.vertices_mm[sides.ends[border]].mean(axis=1)
    chosen = np.unique(np.linspace(0, len(foot) - 1, BORDER_SAMPLES).astype(int))
    corners = mesh.vertices_mm[mesh.triangles[members]]
    centres = corners.mean(axis=1)
    apart = np.linalg.norm(centres[:, None] - foot[None, chosen], axis=2)
    nearest, width = apart.argmin(axis=1), float(apart.min(axis=1).max())
    standing = _dot(centres - foot[chosen][nearest], around[chosen][nearest])
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # Around a point of the border, embossing as a whole faces the way its surroundings do.
    near = apart < 2.5 * width
    mean = np.einsum("mk,mx->kx", near, facing)
    level = _dot(mean, around[chosen]) / np.maximum(np.linalg.norm(mean, axis=1), 1e-300)
    return (
        float(np.median(level)) > LEVEL
        and float(np.average(standing, weights=areas[members])) > 0.0
        and standing.max() < STANDING_SHARE * radius_mm
        and width < NARROW_SHARE * radius_mm
    )


def _windings(mesh: Mesh, sides: _Sides, members: np.ndarray, border: np.ndarray) -> Iterator[float]:
    """Yield how often each closed line of a border goes around the axis."""
    start, end = sides.places[border].T
    numbers, joined = np.unique(np.concatenate([start, end]), return_inverse=True)
    line = _connected(joined[: len(start)], joined[len(start) :], len(numbers))[joined[: len(start)]]
    ends = mesh.vertices_mm[sides.ends[border]]
    angle = np.arctan2(ends[:, :, 1], ends[:, :, 0])
    turn = (angle[:, 1] - angle[:, 0] + np.pi) % (2.0 * np.pi) - np.pi
    # Sides run as the left triangle has them; along a border the members have to stay on one hand.
    member_left = members[sides.left[border]]
    return iter(np.bincount(line, np.where(member_left, turn, -turn)) / (2.0 * np.pi))


def _dot(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", p, q)
