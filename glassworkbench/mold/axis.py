"""Finds the axis a container stands on and which way is up."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold.measures import crossings_on_axis
from glassworkbench.mold.silhouette import find_stem, silhouette
from glassworkbench.scene.validate import unit_vector

ALIGNED = 1e-6
"""Two directions (or a line and a point, relative to the shape's size) closer than this are the same one."""

HOLLOW_SHARE = 0.5
"""A container whose axis runs through glass over less than this share of its height is already hollow."""

OFF_CENTRE_SHARE = 0.1
"""A line that passes the centre of gravity farther off than this share of the size is the axis of a detail (a grip)."""

NARROW_END = 0.6
"""Of two flat ends, one whose area is below this share of the other's is the mouth."""


@dataclass(frozen=True, eq=False)
class Standing:
    """Where a container stands in CAD coordinates.

    Parameters
    ----------
    axis : array (3,)
        Unit vector, pointing from the base to the finish.
    point_mm : array (3,)
        Any point of the axis.
    finish_face : int
        1-based number of the planar face that closes the mouth, or of the flat rim of a hollow container; 0 without,
        and for a mesh.
    """

    axis: np.ndarray
    point_mm: np.ndarray
    finish_face: int


def find_standing(
    solid: Part.Shape, vertices_mm: np.ndarray, triangles: np.ndarray, *, axis: object = None, up: object = None
) -> Standing:
    """Return the axis and the finish of a solid.

    The axis is the one about which most of the curved surface is turned; without such surface, a principal axis of
    inertia. The finish is the outermost planar face across it, or the rim of a container that is already hollow.

    Parameters
    ----------
    solid : Part.Shape
    vertices_mm, triangles : arrays (n, 3), (m, 3)
        A closed mesh of the solid.
    axis, up : array (3,), optional
        The user's word on the axis (either sense), and on the direction from base to finish.

    Raises
    ------
    InputError
        If no planar face lies across any axis at the solid's end, or the axis does not meet the solid at all.
    """
    for direction, point in axis_lines(solid, vertices_mm, triangles, axis=axis, up=up):
        line = Standing(direction, point, 0)
        ends = _flat_ends(solid, vertices_mm, direction, point)
        open_end = _open_end(vertices_mm, triangles, line)
        if open_end is not None:
            rims = [end for end in ends if end.axis @ open_end.axis > 0.0 and _surrounds(solid, vertices_mm, end)]
            return dataclasses.replace(open_end, finish_face=rims[0].finish_face if rims else 0)
        ends = [end for end in ends if _holds(solid.Faces[end.finish_face - 1], vertices_mm, end)]
        if up is not None:
            ends = [end for end in ends if end.axis @ np.asarray(up, dtype=float) > 0.0]
        if ends:
            areas = [solid.Faces[end.finish_face - 1].Area for end in ends]
            return mouth_end(ends, areas, vertices_mm, triangles)
    raise InputError(
        "finish: no flat face closes the shape at the end of its axis, so the mouth cannot be found; "
        "cut the shape flat where the mouth is, or name the finish's height (finish_height_mm)"
    )


def axis_lines(
    solid: Part.Shape, vertices_mm: np.ndarray, triangles: np.ndarray, *, axis: object = None, up: object = None
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the lines (direction (3,), point (3,)) that may be the axis, the likeliest first; see `find_standing`."""
    centroid, inertia_axes = inertia(vertices_mm, triangles)
    size = float(np.ptp(vertices_mm, axis=0).max())
    lines = [line for line in _turned_lines(solid, size) if _distance(centroid, *line) < OFF_CENTRE_SHARE * size]
    wanted = up if up is not None else axis
    if wanted is None:
        return [*lines, *((direction, centroid) for direction in inertia_axes)]
    direction = unit_vector(wanted, "axis" if up is None else "up")
    along = [(line if line @ direction > 0.0 else -line, point) for line, point in lines if _parallel(line, direction)]
    return along or [(direction, centroid)]


def _distance(place: np.ndarray, direction: np.ndarray, point: np.ndarray) -> float:
    return float(np.linalg.norm(np.cross(place - point, direction)))


def _parallel(line: np.ndarray, direction: np.ndarray) -> bool:
    # The user types a direction with a few digits; the file's own axis is then the exact one.
    return abs(line @ direction) > 1.0 - 1e-4


def is_hollow(standing: Standing, vertices_mm: np.ndarray, triangles: np.ndarray) -> bool:
    """Return whether a solid is a container already: its axis runs through air rather than through glass."""
    return _open_end(vertices_mm, triangles, standing) is not None


def _open_end(vertices_mm: np.ndarray, triangles: np.ndarray, line: Standing) -> Standing | None:
    """Return the line, pointing to the mouth, of a container that is already hollow; None for a full one."""
    upright = to_upright(vertices_mm, line)
    crossings = crossings_on_axis(upright, triangles)
    if len(crossings) == 0:
        raise InputError(
            "base: its axis runs through air from end to end, as in a ring or a tube, "
            "so it has neither base nor mouth; give the outer shape of a container"
        )
    height = upright[:, 2].max()
    if len(crossings) % 2 or np.sum(crossings[1::2] - crossings[::2]) > HOLLOW_SHARE * height:
        return None
    return line if crossings.mean() < 0.5 * height else dataclasses.replace(line, axis=-line.axis)


def _turned_lines(solid: Part.Shape, size: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the lines (direction, point) about which curved faces are turned, the largest area first."""
    lines: list[list] = []
    for face in solid.Faces:
        for direction, point, area in _own_axes(face):
            for line in lines:
                parallel = np.linalg.norm(np.cross(direction, line[0])) < ALIGNED
                if parallel and _distance(point, line[0], line[1]) < ALIGNED * size:
                    line[2] += area
                    break
            else:
                lines.append([direction, point, area])
    return [(direction, point) for direction, point, _ in sorted(lines, key=lambda line: -line[2])]


def _own_axes(face: Part.Face) -> list[tuple[np.ndarray, np.ndarray, float]]:
    surface = face.Surface
    name = type(surface).__name__
    if name in ("Cylinder", "Cone", "Toroid"):
        point = surface.Center
        return [(_unit(surface.Axis), np.array(point), face.Area)]
    if name == "SurfaceOfRevolution":
        return [(_unit(surface.Direction), np.array(surface.Location), face.Area)]
    if name in ("BSplineSurface", "BezierSurface", "Sphere", "OffsetSurface", "Plane"):
        # Free-form faces keep no axis of their own, but CAD writes the circles that bound them as circles.
        circles = [edge.Curve for edge in face.Edges if _is_circle(edge)]
        share = 1.0 if name != "Plane" else 1e-3
        return [(_unit(c.Axis), np.array(c.Center), share * face.Area / len(circles)) for c in circles]
    return []


def _is_circle(edge: Part.Edge) -> bool:
    try:
        return type(edge.Curve).__name__ == "Circle"
    except TypeError:
        # A degenerate edge (the pole of a sphere) has no curve.
        return False


def _unit(vector: object) -> np.ndarray:
    array = np.array(vector, dtype=float)
    array /= np.linalg.norm(array)
    return array if array[np.argmax(np.abs(array))] > 0.0 else -array


def _flat_ends(solid: Part.Shape, vertices_mm: np.ndarray, direction: np.ndarray, point: np.ndarray) -> list[Standing]:
    """Return the planar faces across the line that close the solid at one of its ends."""
    ends = []
    heights = (vertices_mm - point) @ direction
    for sense in (1.0, -1.0):
        top = (sense * heights).max()
        tolerance = 1e-4 * np.ptp(heights)
        for number, face in enumerate(solid.Faces, start=1):
            if not face.Surface.isPlanar():
                continue
            normal = np.array(face.normalAt(*face.Surface.parameter(face.CenterOfMass)))
            if sense * normal @ direction < 1.0 - ALIGNED:
                continue
            if sense * ((np.array(face.CenterOfMass) - point) @ direction) > top - tolerance:
                ends.append(Standing(sense * direction, point, number))
    return ends


def _holds(face: Part.Face, vertices_mm: np.ndarray, end: Standing) -> bool:
    """Return whether the face at a solid's end covers the axis there, as a mouth does and a ring does not."""
    height = ((vertices_mm - end.point_mm) @ end.axis).max()
    return face.isInside(FreeCAD.Vector(*(end.point_mm + height * end.axis).tolist()), 1e-4, True)


def _surrounds(solid: Part.Shape, vertices_mm: np.ndarray, end: Standing) -> bool:
    """Return whether the face at a solid's end is a ring around the axis (a thread may cut into it on one side)."""
    face = solid.Faces[end.finish_face - 1]
    return not _holds(face, vertices_mm, end) and _holds(Part.Face(face.OuterWire), vertices_mm, end)


def mouth_end(ends: list[Standing], areas_mm2: list[float], vertices_mm: np.ndarray, triangles: np.ndarray) -> Standing:
    """Return the flat end that is the mouth: far from a stem, else clearly narrower, else the one that CAD has up."""
    first, second = ends[0], ends[-1]
    if first is second:
        return first
    heights, radii = silhouette(to_upright(vertices_mm, first), triangles)
    stem = find_stem(heights, radii)
    if stem is not None:
        return first if stem.thinnest_mm < 0.5 * heights[-1] else second
    areas = areas_mm2[0], areas_mm2[-1]
    if min(areas) < NARROW_END * max(areas):
        return (first, second)[int(np.argmin(areas))]
    return first


def rotation_to_upright(axis: np.ndarray) -> np.ndarray:
    """Return the smallest rotation (3, 3) that takes the unit vector `axis` to +z."""
    x, y, z = axis
    if z < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    cross = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])
    return np.eye(3) + cross + cross @ cross / (1.0 + z)


def to_upright(points_mm: np.ndarray, standing: Standing) -> np.ndarray:
    """Return points (n, 3) turned and moved so that the axis is z and the lowest lies at z = 0."""
    upright = (points_mm - standing.point_mm) @ rotation_to_upright(standing.axis).T
    upright[:, 2] -= upright[:, 2].min()
    return upright


def inertia(vertices_mm: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the centroid of a closed mesh and its principal axes, the longest extent first."""
    a, b, c = (vertices_mm[triangles[:, k]] for k in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    total = volumes.sum()
    centroid = (volumes[:, None] * (a + b + c)).sum(axis=0) / (4.0 * total)
    a, b, c = a - centroid, b - centroid, c - centroid
    sums = a + b + c
    second = sum(np.einsum("i,ij,ik->jk", volumes, p, p) for p in (a, b, c, sums)) / 20.0
    _, vectors = np.linalg.eigh(second / total)
    return centroid, [_unit(vector) for vector in vectors.T[::-1]]
