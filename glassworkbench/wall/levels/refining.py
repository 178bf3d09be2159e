"""Halves the sides of triangles that are too far from a level surface."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from glassworkbench.wall.levels.creases import crease_points
from glassworkbench.wall.levels.room import Room

ROUNDS = 4

EASINGS = 3
"""How often what still dents the glass is moved out of it."""

NEAR_SHARE = 0.3
"""A middle may be moved along a crease by this share of its side; more would fold its triangles."""

FOLDED = 0.2
"""A triangle whose normal has a smaller product with the surface's is folded over."""

DENTED_SHARE = 1.5
"""The middle of a triangle may be off by this much more than those of its sides: over a sphere it is by a third."""

SHORTEST_SHARE = 0.15
"""Sides shorter than this share of the grid's step are not halved: creases less sharp than that are left blunt."""


@dataclass(frozen=True, eq=False)
class Facets:
    """Triangles between points of a room's surface.

    Parameters
    ----------
    points_mm, gradients : array (n, 3)
    creased : bool array (n,)
        The points that lie on creases; the gradient of one of their sides is theirs.
    triangles : int array (m, 3)
    """

    points_mm: np.ndarray
    gradients: np.ndarray
    creased: np.ndarray
    triangles: np.ndarray


def refined(room: Room, facets: Facets, deviation_mm: float, step_mm: float, left_mm: np.ndarray) -> Facets:
    """Return the triangles with their sides' and their own middles close to the surface, if a few halvings do it.

    Dents near the places left alone (k, 3) stay: to mend them the triangles would cross there.
    """
    shortest = SHORTEST_SHARE * step_mm
    given = len(facets.points_mm)
    known = 0
    for _ in range(ROUNDS):
        sides, number = _sides(facets.triangles)
        new = np.flatnonzero((facets.triangles >= known).any(axis=1) & ~_near(facets, left_mm, step_mm))
        chosen = np.union1d(
            _too_far(room, facets, sides, deviation_mm, shortest),
            _across_dents(room, facets, number, new, DENTED_SHARE * deviation_mm, shortest),
        )
        if len(chosen) == 0:
            break
        known = len(facets.points_mm)
        facets = _halved(room, facets, sides, number, chosen, deviation_mm)
    doubtful = ((facets.triangles >= given) | facets.creased[facets.triangles]).any(axis=1)
    doubtful &= ~_near(facets, left_mm, step_mm)
    for _ in range(EASINGS):
        facets = _eased(room, facets, np.flatnonzero(doubtful), DENTED_SHARE * deviation_mm)
    return facets


def _near(facets: Facets, places_mm: np.ndarray, within_mm: float) -> np.ndarray:
    """Return which triangles (m,) have a corner near one of the places (k, 3)."""
    near = np.zeros(len(facets.points_mm), dtype=bool)
    for place in places_mm:
        near |= np.linalg.norm(facets.points_mm - place, axis=1) < within_mm
    return near[facets.triangles].any(axis=1)


def folded(room: Room, points_mm: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return which triangles (m,) do not face the glass at their middles."""
    corners = points_mm[triangles]
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets /= np.maximum(np.linalg.norm(facets, axis=1, keepdims=True), 1e-300)
    _, gradients = room.value_and_gradient(corners.mean(axis=1))
    return -np.einsum("ij,ij->i", facets, gradients) < FOLDED


def _sides(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return each side once (k, 2), and the numbers (m, 3) of the triangles' sides 01, 12, 20."""
    ends = np.sort(np.stack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]], axis=1), axis=2)
    keys = ends[..., 0].astype(np.int64) * (triangles.max() + 1) + ends[..., 1]
    keys, number = np.unique(keys, return_inverse=True)
    return np.column_stack(np.divmod(keys, triangles.max() + 1)), number.reshape(-1, 3)


def _too_far(room: Room, facets: Facets, sides: np.ndarray, deviation_mm: float, shortest_mm: float) -> np.ndarray:
    points, gradients, creased = facets.points_mm[sides], facets.gradients[sides], facets.creased[sides]
    along = points[:, 1] - points[:, 0]
    # An arc leaves its chord at both ends by the angle that makes its height an eighth of length times turn.
    rise = np.abs(np.einsum("nkj,nj->nk", gradients, along)).max(axis=1)
    suspect = (rise > 4.0 * deviation_mm) | creased.any(axis=1)
    chosen = np.flatnonzero(suspect & (np.linalg.norm(along, axis=1) > shortest_mm))
    return chosen[np.abs(room.value(points[chosen].mean(axis=1))) > deviation_mm]


def _across_dents(
    room: Room, facets: Facets, number: np.ndarray, looked_at: np.ndarray, deviation_mm: float, shortest_mm: float
) -> np.ndarray:
    """Return the longest sides of those of the triangles looked at (k,) whose middles are too far off.

    What stands out from the outside, like the end of a thread, can dent a triangle between sides that are good.
    """
    corners = facets.points_mm[facets.triangles[looked_at]]
    lengths = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    long = lengths.max(axis=1) > shortest_mm
    corners, looked_at, longest = corners[long], looked_at[long], lengths[long].argmax(axis=1)
    dented = room.value(corners.mean(axis=1)) < -deviation_mm
    return np.unique(number[looked_at, longest][dented])


def _halved(
    room: Room, facets: Facets, sides: np.ndarray, number: np.ndarray, chosen: np.ndarray, deviation_mm: float
) -> Facets:
    count = len(facets.points_mm)
    ends = facets.points_mm[sides[chosen]]
    middles = ends.mean(axis=1)
    plain, _, gradients = room.on_surface(middles)
    row = np.full(len(sides), -1)
    row[chosen] = np.arange(len(chosen))
    owner = row[number]
    touched, side = np.nonzero(owner >= 0)
    around = facets.points_mm[facets.triangles[touched]].reshape(-1, 3)
    sharp, on_crease = crease_points(room, middles, np.repeat(owner[touched, side], 3), around, deviation_mm)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    on_crease &= np.linalg.norm(sharp - middles, axis=1) < NEAR_SHARE * length
    triangles = _cut(facets, owner, count, plain)
    triangles_of_new = triangles[(triangles >= count).any(axis=1)]
    choice = np.where(on_crease, 0, 1)
    while True:
        new = np.choose(choice[:, None], [sharp, plain, middles])
        points = np.concatenate([facets.points_mm, new])
        wrong = triangles_of_new[folded(room, points, triangles_of_new)]
        back = np.unique(wrong[wrong >= count]) - count
        back = back[choice[back] < 2]
        if len(back) == 0:
            break
        choice[back] += 1
        triangles_of_new = triangles_of_new[np.isin(triangles_of_new, back + count).any(axis=1)]
    return Facets(
        points,
        np.concatenate([facets.gradients, gradients]),
        np.concatenate([facets.creased, choice == 0]),
        triangles,
    )


def _eased(room: Room, facets: Facets, doubtful: np.ndarray, deviation_mm: float) -> Facets:
    """Return the triangles without dents of the glass in the doubtful ones (k,): too thick is better than too thin.

    Where the surface is too sharp for its triangles, their corners are moved off it, unless that would fold one.
    """
    points, triangles = facets.points_mm, facets.triangles
    corners = np.unique(triangles[doubtful])
    value, gradients = room.value_and_gradient(
        np.concatenate([points[triangles[doubtful]].mean(axis=1), points[corners]])
    )
    # What each place asks of which points: a triangle's middle of its three corners, a corner of itself.
    moved = np.concatenate([triangles[doubtful], np.repeat(corners[:, None], 3, axis=1)])
    deep = value < -deviation_mm
    moved, moves = moved[deep].ravel(), np.repeat((-value[:, None] * gradients)[deep], 3, axis=0)
    eased = points.copy()
    np.add.at(eased, moved, moves / np.bincount(moved, minlength=len(points))[moved, None])
    near = triangles[np.isin(triangles, moved).any(axis=1)]
    back = np.unique(near[folded(room, eased, near) & ~folded(room, points, near)])
    eased[back] = points[back]
    return replace(facets, points_mm=eased)


def _cut(facets: Facets, owner: np.ndarray, count: int, middles: np.ndarray) -> np.ndarray:
    """Return the triangles, those with chosen sides (owner >= 0 numbers the middle) cut."""
    marked = owner >= 0
    marks = marked.sum(axis=1)
    triangles = [facets.triangles[marks == 0]]
    points = np.concatenate([facets.points_mm, middles])
    for many in (1, 2, 3):
        rows = np.flatnonzero(marks == many)
        # Turn each so that its side 01 is chosen, and with two chosen 12 as well.
        first = np.argmax(marked[rows], axis=1)
        if many == 2:
            first = (np.argmin(marked[rows], axis=1) + 1) % 3
        turn = (first[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(facets.triangles[rows], turn, axis=1).T
        p, q, r = (np.take_along_axis(owner[rows], turn, axis=1) + count).T
        if many == 1:
            triangles += [np.column_stack([a, p, c]), np.column_stack([p, b, c])]
        elif many == 3:
            triangles += [np.column_stack(part) for part in ((a, p, r), (p, b, q), (r, q, c), (p, q, r))]
        else:
            shorter = np.linalg.norm(points[a] - points[q], axis=1) < np.linalg.norm(points[p] - points[c], axis=1)
            triangles.append(np.column_stack([p, b, q]))
            triangles.append(np.where(shorter[:, None], np.column_stack([a, p, q]), np.column_stack([a, p, c])))
            triangles.append(np.where(shorter[:, None], np.column_stack([a, q, c]), np.column_stack([p, q, c])))
    return np.concatenate(triangles)
