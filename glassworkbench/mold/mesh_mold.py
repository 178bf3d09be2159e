"""A mold that is a mesh: where it stands, and its outside where it is hollow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.mold.axis import Standing, inertia, is_hollow, mouth_end, to_upright
from glassworkbench.mold.measures import FLAT_SHARE, crossings_on_axis, flat_top
from glassworkbench.mold.mending import boundary_loops, fan, mended
from glassworkbench.mold.mold import Mold, check_size
from glassworkbench.mold.placing import placement_of
from glassworkbench.mold.surveying import survey
from glassworkbench.scene import Mesh
from glassworkbench.scene.meshes import with_creased_normals
from glassworkbench.scene.validate import unit_vector

NEARLY_ALONG = np.cos(np.radians(3.0))
"""Triangles whose normals turn less than this from a direction may belong to a flat end across it."""

FLAT_TURN = np.cos(np.radians(0.3))
"""Triangles of a flat end turn less than this from each other; those around the pole of a ball turn more."""

SHARP = np.cos(np.radians(30.0))
"""Flat triangles that turn less than this into those around them may be a facet of something round."""

FACETS = 20.0
"""What is flat over more than this many times the area of a triangle beside it is more than a facet."""

NEAR_END_SHARE = 0.05
"""They lie in this share of the height below the end."""

ROUND_SHARE = 1e-3
"""A flat end whose edge keeps within this share of the radius of a circle is round, and its centre lies on the axis."""


@dataclass(frozen=True, eq=False)
class FlatEnd:
    """A flat end of a mesh: how the mesh stands on the line through its middle, its area, and whether it is a ring."""

    standing: Standing
    area_mm2: float
    is_ring: bool


def mold_from_mesh(
    vertices_mm: np.ndarray,
    triangles: np.ndarray,
    name: str,
    *,
    axis: object = None,
    up: object = None,
    outer_shell: bool = False,
    close_open_shell: bool = False,
) -> Mold:
    """Return the mold that a mesh is.

    The axis is the normal of a flat end that lies across a principal axis of inertia, through the middle of its edge
    where that is round, else through the centre of gravity.

    Parameters
    ----------
    vertices_mm, triangles : arrays (n, 3), (m, 3)
        As the file has them; see `mending.mended` for what is repaired.
    name : str
    axis, up, outer_shell, close_open_shell : optional
        As in `mold_from_shape`.

    Returns
    -------
    Mold
        Its `mesh` stores a vertex once for each smooth piece around it, so that sharp edges stay sharp.

    Raises
    ------
    InputError
        If the mesh cannot be mended, its mouth is not flat, or it is hollow and `outer_shell` is not given.
    """
    check_size(float(np.linalg.norm(np.ptp(vertices_mm, axis=0))))
    vertices, triangles, repairs = mended(vertices_mm, triangles, close_open_shell=close_open_shell)
    standing, rim = _find_standing(vertices, triangles, axis, up)
    if is_hollow(standing, vertices, triangles):
        if not outer_shell:
            raise InputError(
                "it is already hollow; take its outside as the mold (outer_shell=True) to hollow that anew"
            )
        if rim is None:
            raise InputError("its rim is not flat, so nothing parts outside from inside; give the mold's mesh instead")
        vertices, triangles = _outside(vertices, triangles, rim)
        standing, _ = _find_standing(vertices, triangles, None, rim.axis)
    placement = placement_of(standing, vertices)
    upright = to_upright(vertices, standing)
    anatomy = survey(standing, placement, upright, triangles, [], None)
    mesh = Mesh(*with_creased_normals(upright, triangles), has_averaged_normals=True)
    return Mold(None, None, placement, anatomy, name, mesh=mesh, repairs=tuple(repairs))


def _find_standing(
    vertices_mm: np.ndarray, triangles: np.ndarray, axis: object, up: object
) -> tuple[Standing, Standing | None]:
    """Return how a mesh stands, and of a hollow one how it stands on its flat rim, None where that is not flat."""
    centroid, directions = inertia(vertices_mm, triangles)
    wanted = up if up is not None else axis
    if wanted is not None:
        directions = [unit_vector(wanted, "axis" if up is None else "up")]
    for direction in directions:
        senses = (1.0,) if up is not None else (1.0, -1.0)
        ends = [
            end
            for sense in senses
            if (end := _flat_end(vertices_mm, triangles, sense * direction, centroid)) is not None
        ]
        full = [end for end in ends if not end.is_ring]
        rings = [end for end in ends if end.is_ring]
        for ring in rings:
            if is_hollow(ring.standing, vertices_mm, triangles):
                return ring.standing, ring.standing
        if full:
            areas = [end.area_mm2 for end in full]
            return mouth_end([end.standing for end in full], areas, vertices_mm, triangles), None
    raise InputError(
        "finish: no flat face closes the mesh at the end of its axis, so the mouth cannot be found; "
        "cut it flat where the mouth is, or name the direction from base to mouth (up=)"
    )


def _flat_end(
    vertices_mm: np.ndarray, triangles: np.ndarray, direction: np.ndarray, centroid: np.ndarray
) -> FlatEnd | None:
    """Return the flat end of a mesh that lies across a direction, or nearly; None without."""
    a, b, c = (vertices_mm[triangles[:, k]] for k in range(3))
    facets = 0.5 * np.cross(b - a, c - a)
    areas = np.linalg.norm(facets, axis=1)
    heights = vertices_mm @ direction
    near = heights.max() - NEAR_END_SHARE * np.ptp(heights)
    facing = (facets @ direction > NEARLY_ALONG * areas) & np.all(heights[triangles] > near, axis=1)
    if not np.any(facing):
        return None
    # The largest of them decides the direction, so that a rounded edge beside a flat end does not tilt it.
    largest = np.flatnonzero(facing)[np.argmax(areas[facing])]
    direction = facets[largest] / areas[largest]
    for _ in range(2):
        level = np.abs(vertices_mm @ direction - vertices_mm[triangles[largest, 0]] @ direction)
        flat = facing & np.all(level[triangles] < FLAT_SHARE * np.ptp(heights), axis=1)
        flat &= facets @ direction > FLAT_TURN * areas
        direction = facets[flat].sum(axis=0) / np.linalg.norm(facets[flat].sum(axis=0))
    if _is_facet(triangles, flat, areas, facets @ direction):
        return None
    centre = _outline_centre(vertices_mm, triangles[flat], direction)
    standing = Standing(direction, centroid if centre is None else centre, 0)
    upright = to_upright(vertices_mm, standing)
    if upright[triangles[largest, 0], 2] < (1.0 - FLAT_SHARE) * upright[:, 2].max():
        return None
    area = float(areas[flat].sum())
    covered = _covered(upright, triangles[flat], 0.1 * np.sqrt(area))
    return None if np.any(covered != covered[0]) else FlatEnd(standing, area, not covered[0])


def _is_facet(triangles: np.ndarray, flat: np.ndarray, areas: np.ndarray, facing: np.ndarray) -> bool:
    """Return whether flat triangles are a facet of something round (a ball): small, and turning little into the next.

    `facing` (m,) is each triangle's area as seen along the flat ones' normal.
    """
    around = np.any(np.isin(triangles, triangles[flat]), axis=1) & ~flat
    turns_little = np.median(facing[around] / np.maximum(areas[around], 1e-300)) > SHARP
    return bool(turns_little and areas[flat].sum() < FACETS * np.median(areas[around]))


def _covered(vertices_mm: np.ndarray, triangles: np.ndarray, radius_mm: float) -> np.ndarray:
    """Return whether each of 8 vertical lines around the z axis meets the triangles, bool (8,)."""
    angles = (np.arange(8) + 0.37) * 0.25 * np.pi
    around = radius_mm * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(8)])
    return np.array([len(crossings_on_axis(vertices_mm - place, triangles)) > 0 for place in around])


def _outline_centre(vertices_mm: np.ndarray, flat: np.ndarray, normal: np.ndarray) -> np.ndarray | None:
    """Return the centre (3,) of the circle that the outline of flat triangles (m, 3) is; None if it is none.

    Found by the algebraic fit: |p|^2 = 2 c.p + k is linear in c and k (Kasa 1976).
    """
    places = vertices_mm[np.unique(flat)]
    _, _, across = np.linalg.svd(normal[None])
    middle = places.mean(axis=0)
    points = (places - middle) @ across[1:].T
    from_middle = np.linalg.norm(points - 0.5 * (points.min(axis=0) + points.max(axis=0)), axis=1)
    points = points[from_middle > 0.95 * from_middle.max()]
    if len(points) < 6:
        return None
    system = np.column_stack([2.0 * points, np.ones(len(points))])
    (x, y, _), *_ = np.linalg.lstsq(system, (points**2).sum(axis=1), rcond=None)
    radii = np.hypot(points[:, 0] - x, points[:, 1] - y)
    if np.ptp(radii) > ROUND_SHARE * radii.mean():
        return None
    return middle + np.array([x, y]) @ across[1:]


def _outside(vertices_mm: np.ndarray, triangles: np.ndarray, rim: Standing) -> tuple[np.ndarray, np.ndarray]:
    """Return the closed mesh of what is outside of a flat rim, the mouth closed."""
    upright = to_upright(vertices_mm, rim)
    flat = flat_top(upright, triangles, float(upright[:, 2].max()))
    sides = triangles[~flat]
    loops = boundary_loops(vertices_mm, sides)
    outer = max(loops, key=lambda loop: np.hypot(*upright[loop, :2].T).mean())
    reached = np.zeros(len(vertices_mm), dtype=bool)
    reached[outer] = True
    while True:
        touched = np.any(reached[sides], axis=1)
        count = reached.sum()
        reached[sides[touched]] = True
        if reached.sum() == count:
            break
    if any(np.any(reached[loop]) for loop in loops if loop is not outer):
        raise InputError("its inside and its outside are joined apart from the rim; give the mold's mesh instead")
    outside = sides[touched]
    vertices, lid = fan(vertices_mm, outer)
    triangles = np.concatenate([outside, lid])
    used, place = np.unique(triangles, return_inverse=True)
    return vertices[used], place.reshape(-1, 3)
