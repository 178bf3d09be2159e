"""Measures an upright body: the anatomy of a container."""

from __future__ import annotations

import numpy as np

from glassworkbench.mold.anatomy import Anatomy
from glassworkbench.mold.axis import Standing
from glassworkbench.mold.measures import crossings_on_axis, distance_to_polyline, smallest_width
from glassworkbench.mold.meridian import points
from glassworkbench.mold.silhouette import find_regions, find_stem, radius_spread, silhouette


def survey(
    standing: Standing,
    placement: np.ndarray,
    vertices_mm: np.ndarray,
    triangles: np.ndarray,
    profiles: list[np.ndarray | None],
    core: np.ndarray | None,
) -> Anatomy:
    """Return the anatomy of an upright body with a closed mesh.

    Parameters
    ----------
    standing : Standing
        How it stood in CAD coordinates.
    placement : array (4, 4)
        Takes upright coordinates to CAD coordinates.
    vertices_mm, triangles : arrays (n, 3), (m, 3)
        The mesh, upright.
    profiles : list of arrays (n, 4, 3) or None
        Each CAD face's profile, as from `face_profiles`; empty for a mesh.
    core : array (n, 4, 3) or None
        The profiles chained.
    """
    heights, radii = silhouette(vertices_mm, triangles)
    stem = find_stem(heights, radii)
    regions = find_regions(heights, radii, stem)
    height = float(vertices_mm[:, 2].max())
    departure, where = _departure(vertices_mm, triangles, profiles, core)
    finish_low = regions["finish"][0]
    from_axis = np.hypot(vertices_mm[:, 0], vertices_mm[:, 1])
    outline = points(core, 64) if core is not None else np.column_stack([from_axis, vertices_mm[:, 2]])
    lowest = outline[outline[:, 1] < 1e-6 * height]
    return Anatomy(
        axis=standing.axis,
        base_point_mm=placement[:3, 3],
        height_mm=height,
        finish_height_mm=height,
        finish_outer_radius_mm=float(radii[heights > finish_low].max()),
        finish_face=standing.finish_face,
        maximum_radius_mm=float(max(from_axis.max(), outline[:, 0].max())),
        smallest_width_mm=smallest_width(vertices_mm) if departure > 0.0 else float(2.0 * outline[:, 0].max()),
        bearing_radius_mm=float(lowest[:, 0].mean()),
        push_up_mm=float(core[0, 0, 1] if core is not None else crossings_on_axis(vertices_mm, triangles)[0]),
        departure_mm=departure,
        departure_at_mm=where,
        stem_top_mm=stem.top_mm if stem is not None else 0.0,
        regions=regions,
    )


def _departure(
    vertices_mm: np.ndarray, triangles: np.ndarray, profiles: list[np.ndarray | None], core: np.ndarray | None
) -> tuple[float, np.ndarray]:
    """Return the largest distance between the surface and its core in the meridian half-plane, and where it is."""
    if core is None:
        return radius_spread(vertices_mm, triangles, crossings_on_axis(vertices_mm, triangles)[0])
    if all(profile is not None for profile in profiles):
        return 0.0, np.array([core[0, 0, 0], 0.0, core[0, 0, 1]])
    flat = np.column_stack([np.hypot(vertices_mm[:, 0], vertices_mm[:, 1]), vertices_mm[:, 2]])
    distances = distance_to_polyline(flat, points(core, 32))
    worst = int(np.argmax(distances))
    return float(distances[worst]), vertices_mm[worst]
