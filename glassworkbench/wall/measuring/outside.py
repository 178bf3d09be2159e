"""The outside of a mold as every method and the measurement see it: small triangles, each with the thickness asked.

The cavity that a thickness asks for is the set of points p that keep the distance t(s) from every outer point s.
`Outside.clearance` says how far inside that set a point lies: it is 0 on the wanted inner surface, whatever the method.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from glassworkbench.mold import Mold
from glassworkbench.mold.embossing import embossed as find_embossed
from glassworkbench.mold.tessellation import MOUTH, outside_mesh
from glassworkbench.scene import Mesh
from glassworkbench.spatial import SIDES, Nearest, NearestTriangles, sags
from glassworkbench.wall.asking.limits import LAND_SHARE

DEVIATION_MM = 0.05
"""Distance of the triangles from the outside; their bulge brings them to a few micrometres."""

LIP_ZONE_MM = 4.0
"""Near the mouth, what leans inward this close to the finish plane is the lip's rounding: the bore runs straight."""

LEANING = 0.35
"""A facet whose outward normal rises by more than this is part of a lip's rounding."""

LEVEL_MM = 1e-4
"""An edge whose ends are nearer than this, seen from above, carries no collar."""

LONGEST_MM = 10.0
"""Where the thickness varies, no triangle is longer: a narrow step of the thickness must not fall between corners."""

THICKNESS_ERROR_MM = 2e-3
"""Triangles are halved until the thickness is this close to linear along their sides (but see `SHORTEST_MM`)."""

PROBED_AREA_MM2, MOST_PROBES = 10.0, 20_000
"""One random point of the outside to so much of it tells whether the thickness varies at all."""

QUARTERS = (0.25, 0.75)
"""Where sides are looked at besides their middles: waves of the thickness may pass through ends and middle alike."""

SHORTEST_MM = 0.2
"""Sides are not halved below this length, so that a step of the thickness ends the halving."""


@dataclass(frozen=True, eq=False)
class Outside:
    """The outside of an upright mold without its mouth, continued straight up above it.

    Parameters
    ----------
    corners_mm : array (m, 3, 3)
        Of triangles whose corners lie on the surface.
    normals : array (m, 3, 3)
        Unit outward normals of the surface at the corners.
    thickness_mm : array (m, 3)
        Asked at the corners, linear in between.
    faces : int array (m,)
        1-based number of the CAD face each triangle lies on; 0 without CAD faces, and on the collar.
    collar : bool array (m,)
        The triangles above the lip, which are no glass but guide the bore through the mouth.
    finish_height_mm : float
    embossed : bool array (m,)
        The triangles of threads, lugs and lettering, which stand out from the outside and shall not show inside.
    """

    corners_mm: np.ndarray
    normals: np.ndarray
    thickness_mm: np.ndarray
    faces: np.ndarray
    collar: np.ndarray
    finish_height_mm: float
    embossed: np.ndarray

    def clearance(self, points_mm: np.ndarray) -> Nearest:
        """Return how far inside the wanted cavity points (n, 3) lie, and the outer points that decide.

        The clearance is min over s of |p - s| - t(s): 0 on the wanted inner surface, above 0 in the cavity, below 0 in
        the glass. It is exact to second order in the triangles' size: a few micrometres where their deviation from the
        surface is 0.05 mm. Points outside the mold are not told from points inside.
        """
        return self._by_thickness.search(points_mm)

    def distance(self, points_mm: np.ndarray) -> Nearest:
        """Return the distance of points (n, 3) to the outside, the mouth and the collar left out."""
        return self._by_distance.search(points_mm)

    @property
    def lip_height_mm(self) -> float:
        """The height where the lip's rounding begins; that of the finish where there is none."""
        return float(self.corners_mm[self.collar, :, 2].min()) if np.any(self.collar) else self.finish_height_mm

    def without_embossing(self) -> Outside:
        """Return the outside with holes where there is embossing: what a smooth inside is the offset of."""
        return self._only(~self.embossed)

    def embossing(self) -> Outside | None:
        """Return the embossing alone, None where there is none."""
        return self._only(self.embossed) if np.any(self.embossed) else None

    def _only(self, kept: np.ndarray) -> Outside:
        return replace(
            self,
            corners_mm=self.corners_mm[kept],
            normals=self.normals[kept],
            thickness_mm=self.thickness_mm[kept],
            faces=self.faces[kept],
            collar=self.collar[kept],
            embossed=self.embossed[kept],
        )

    @cached_property
    def _by_thickness(self) -> NearestTriangles:
        return NearestTriangles(self.corners_mm, self.normals, self.thickness_mm)

    @cached_property
    def _by_distance(self) -> NearestTriangles:
        glass = ~self.collar
        return NearestTriangles(self.corners_mm[glass], self.normals[glass])


ThicknessAt = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Takes points of the outside (n, 3), upright, and their CAD faces' numbers (n,); returns the thickness (n,), mm."""


def outside(mold: Mold, thickness_at: ThicknessAt, deviation_mm: float = DEVIATION_MM) -> Outside:
    """Return the outside of a mold.

    Parameters
    ----------
    mold : Mold
    thickness_at : callable
    deviation_mm : float
        Largest distance of the triangles, before their bulge, from the CAD faces.
    """
    return outside_as_meshed(mold, *outside_mesh(mold, deviation_mm), thickness_at)


def outside_as_meshed(mold: Mold, mesh: Mesh, faces: np.ndarray, thickness_at: ThicknessAt) -> Outside:
    """Return the outside of a mold from the mesh and its faces (m,) that `outside_mesh` gave."""
    mouth = is_mouth(mold, faces)
    return outside_of_mesh(mesh, np.maximum(faces, 0), mouth, mold.anatomy.finish_height_mm, thickness_at)


def is_mouth(mold: Mold, faces: np.ndarray) -> np.ndarray:
    """Return which of the triangles that `outside_mesh` gives close the mouth, from their faces' numbers (m,)."""
    return np.isin(faces, (mold.anatomy.finish_face, MOUTH)) & (faces != 0)


def outside_of_mesh(
    mesh: Mesh, faces: np.ndarray, mouth: np.ndarray, finish_height_mm: float, thickness_at: ThicknessAt
) -> Outside:
    """Return the outside of an upright, closed mesh whose vertices lie on the surface.

    Parameters
    ----------
    mesh : Mesh
    faces : int array (m,)
        CAD face of each triangle, 0 without.
    mouth : bool array (m,)
        The triangles that close the mouth.
    finish_height_mm : float
    thickness_at : callable
    """
    embossed = find_embossed(mesh)
    # The upper flank of a thread near the mouth leans inward, too.
    keep = ~mouth & (embossed | ~_lip(mesh, finish_height_mm))
    corners, normals, face = mesh.vertices_mm[mesh.triangles[keep]], mesh.normals[mesh.triangles[keep]], faces[keep]
    thickness = _at_corners(corners, face, thickness_at)
    top = finish_height_mm + 2.0 * float(thickness.max()) + LIP_ZONE_MM
    # Halved triangles have free edges that are no rim.
    collar, collar_normals, collar_thickness = (
        np.concatenate(parts)
        for parts in zip(
            _collar(corners, normals, thickness, finish_height_mm, top),
            _land(mesh.vertices_mm[mesh.triangles[mouth]], thickness_at, top),
            strict=True,
        )
    )
    corners, normals, thickness, face, origin = _refined(corners, normals, face, thickness_at)
    return Outside(
        np.concatenate([corners, collar]),
        np.concatenate([normals, collar_normals]),
        np.concatenate([thickness, collar_thickness]),
        np.concatenate([face, np.zeros(len(collar), dtype=face.dtype)]),
        np.arange(len(corners) + len(collar)) >= len(corners),
        finish_height_mm,
        np.concatenate([embossed[keep][origin], np.zeros(len(collar), dtype=bool)]),
    )


def _at_corners(corners: np.ndarray, faces: np.ndarray, thickness_at: ThicknessAt) -> np.ndarray:
    return np.stack([thickness_at(corners[:, k], faces) for k in range(3)], axis=1)


def _lip(mesh: Mesh, finish_height_mm: float) -> np.ndarray:
    corners = mesh.vertices_mm[mesh.triangles]
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    rising = facets[:, 2] > LEANING * np.maximum(np.linalg.norm(facets, axis=1), 1e-300)
    zone = min(LIP_ZONE_MM, 0.2 * finish_height_mm)
    return rising & (corners[:, :, 2].min(axis=1) > finish_height_mm - zone)


def _refined(
    corners: np.ndarray, normals: np.ndarray, faces: np.ndarray, thickness_at: ThicknessAt
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Halve triangles, onto the surface, until the thickness is nearly linear over each.

    Returns corners, normals, thickness, faces, and which of the given triangles each is a part of.
    """
    thickness = _at_corners(corners, faces, thickness_at)
    varies = _varies(corners, faces, thickness_at)
    origin = np.arange(len(corners))
    done: list[tuple[np.ndarray, ...]] = []
    while len(corners):
        sides = np.stack([corners[:, j] - corners[:, i] for i, j in SIDES], axis=1)
        lengths = np.linalg.norm(sides, axis=2)
        middles, _ = _middles(corners, normals)
        at_middles = np.stack([thickness_at(middles[:, k], faces) for k in range(3)], axis=1)
        linear = np.stack([0.5 * (thickness[:, i] + thickness[:, j]) for i, j in SIDES], axis=1)
        error = np.abs(at_middles - linear).max(axis=1)
        if varies:
            error = np.maximum(error, _error_at_quarters(corners, faces, thickness, thickness_at))
        longest = lengths.argmax(axis=1)
        length = lengths[np.arange(len(corners)), longest]
        coarse = (error > THICKNESS_ERROR_MM) & (length > SHORTEST_MM)
        if varies:
            coarse |= length > LONGEST_MM
        done.append(tuple(array[~coarse] for array in (corners, normals, thickness, faces, origin)))
        corners, normals, thickness, faces, origin = (
            array[coarse] for array in (corners, normals, thickness, faces, origin)
        )
        thickness = _split(thickness, at_middles[coarse], longest[coarse])
        corners, normals = halved(corners, normals, longest[coarse])
        faces, origin = np.concatenate([faces, faces]), np.concatenate([origin, origin])
    return tuple(np.concatenate(part) for part in zip(*done, strict=True))


def _varies(corners: np.ndarray, faces: np.ndarray, thickness_at: ThicknessAt) -> bool:
    """Tell whether the thickness varies over triangles, by points spread at random over them."""
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    rng = np.random.default_rng(1)
    count = min(MOST_PROBES, len(corners) + int(areas.sum() / PROBED_AREA_MM2))
    chosen = rng.choice(len(corners), count, p=areas / areas.sum())
    shares = rng.dirichlet((1.0, 1.0, 1.0), count)
    points = np.einsum("kc,kcx->kx", shares, corners[chosen])
    found = np.concatenate([thickness_at(points, faces[chosen]), _at_corners(corners, faces, thickness_at).ravel()])
    return bool(np.ptp(found) > THICKNESS_ERROR_MM)


def _error_at_quarters(
    corners: np.ndarray, faces: np.ndarray, thickness: np.ndarray, thickness_at: ThicknessAt
) -> np.ndarray:
    """Return how far the thickness is from linear along the sides of each triangle, at `QUARTERS` of them, (m,)."""
    error = np.zeros(len(corners))
    for i, j in SIDES:
        for share in QUARTERS:
            at = thickness_at((1.0 - share) * corners[:, i] + share * corners[:, j], faces)
            error = np.maximum(error, np.abs(at - (1.0 - share) * thickness[:, i] - share * thickness[:, j]))
    return error


def halved(corners: np.ndarray, normals: np.ndarray, side: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return triangles (m, 3, 3) cut in two through the middle, on the surface, of one side (m,) each; and normals."""
    middles, turned = _middles(corners, normals)
    return _split(corners, middles, side), _split(normals, turned, side)


def _split(at_corners: np.ndarray, at_middles: np.ndarray, side: np.ndarray) -> np.ndarray:
    row = np.arange(len(side))
    p, q, r = (at_corners[row, (side + turn) % 3] for turn in range(3))
    m = at_middles[row, side]
    return np.concatenate([np.stack([p, m, r], axis=1), np.stack([m, q, r], axis=1)])


def _middles(corners: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the surface's points (m, 3, 3) over the middles of each triangle's sides 01, 12, 20, and its normals."""
    points, turned = np.empty_like(corners), np.empty_like(corners)
    sag = sags(corners, normals)
    for side, (i, j) in enumerate(SIDES):
        p, q, n, m = corners[:, i], corners[:, j], normals[:, i], normals[:, j]
        normal = n + m
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        points[:, side], turned[:, side] = 0.5 * (p + q) + 0.25 * sag[:, side, None] * normal, normal
    return points, turned


def _collar(
    corners: np.ndarray, normals: np.ndarray, thickness: np.ndarray, finish_height_mm: float, top_mm: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return upright sheets of triangles over the free edges of the outside near its mouth."""
    number, side = _free_sides(corners)
    p, q = corners[number, side], corners[number, (side + 1) % 3]
    zone = min(2.0 * LIP_ZONE_MM, 0.4 * finish_height_mm)
    lowest = np.minimum(p[:, 2], q[:, 2])
    free = (lowest > finish_height_mm - zone) & (np.linalg.norm((q - p)[:, :2], axis=1) > LEVEL_MM)
    number, side, p, q = number[free], side[free], p[free], q[free]
    upright = normals[number, side] * np.array([1.0, 1.0, 0.0]), normals[number, (side + 1) % 3] * [1.0, 1.0, 0.0]
    n, m = (vector / np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), 1e-300) for vector in upright)
    t, s = thickness[number, side], thickness[number, (side + 1) % 3]
    return _sheets(p, q, (n, m), (t, s), top_mm)


def _land(mouth: np.ndarray, thickness_at: ThicknessAt, top_mm: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return upright sheets over the edge of the mouth's plane (m, 3, 3), which keep the sealing surface wide enough.

    Where the lip's rounding reaches far, the bore would come out through it.
    """
    number, side = _free_sides(mouth)
    p, q = mouth[number, side], mouth[number, (side + 1) % 3]
    along = q - p
    normal = np.column_stack([along[:, 1], -along[:, 0], np.zeros(len(p))])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    t, s = (LAND_SHARE * thickness_at(points, np.zeros(len(points), dtype=int)) for points in (p, q))
    return _sheets(p, q, (normal, normal), (t, s), top_mm)


def _free_sides(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles (k,) and the sides (k,) of them that no other of the triangles (m, 3, 3) shares."""
    keys = np.round(corners.reshape(-1, 3) * 1e5).astype(np.int64)
    _, place = np.unique(keys, axis=0, return_inverse=True)
    place = place.reshape(-1, 3)
    starts, ends = place.ravel(), np.roll(place, -1, axis=1).ravel()
    keys = np.minimum(starts, ends) * (place.max(initial=0) + 1) + np.maximum(starts, ends)
    _, row, count = np.unique(keys, return_index=True, return_counts=True)
    return np.divmod(row[count == 1], 3)


def _sheets(
    p: np.ndarray,
    q: np.ndarray,
    normals: tuple[np.ndarray, np.ndarray],
    thickness: tuple[np.ndarray, np.ndarray],
    top_mm: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the triangles (2 n, 3, 3) of upright sheets over edges from p to q (n, 3), their normals and thickness."""
    (n, m), (t, s) = normals, thickness
    p_top, q_top = p * [1.0, 1.0, 0.0] + [0.0, 0.0, top_mm], q * [1.0, 1.0, 0.0] + [0.0, 0.0, top_mm]
    sheets = np.concatenate([np.stack([p, q, q_top], 1), np.stack([p, q_top, p_top], 1)])
    sheet_normals = np.concatenate([np.stack([n, m, m], 1), np.stack([n, m, n], 1)])
    return sheets, sheet_normals, np.concatenate([np.stack([t, s, s], 1), np.stack([t, s, t], 1)])
