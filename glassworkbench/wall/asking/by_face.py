"""The thickness of a wall that is given for each CAD face: a step across sharp edges, a blend across smooth ones."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.freecad import Part
from glassworkbench.mold import Mold
from glassworkbench.spatial import NearestTriangles

SMOOTH_EDGE = np.radians(5.0)
"""Faces whose normals differ by less along their edge are one surface to whoever looks at it."""

BLEND_WALLS = 3.0
"""Width of a blend, both sides together, in walls: the thickest of the faces that are joined smoothly."""

EDGE_DEFLECTION_MM = 1e-3
"""How near the chords of an edge follow it."""


@dataclass(frozen=True, eq=False)
class FaceBlend:
    """Faces that are joined smoothly but ask for different thicknesses.

    Parameters
    ----------
    faces : frozenset of int
    thicknesses_mm : tuple of float
        The different ones, ascending.
    borders : tuple of NearestTriangles
        For each thickness, the edges at which it ends.
    reach_mm : float
        Half the width of the blend.

    Notes
    -----
    Each thickness weighs f(d), d the distance to the nearest edge at which it ends, and 1 on its own faces; f falls
    from 1 to 0 within the reach such that across one edge the thickness follows the smoothest cubic,
    1/2 - (3 u - u^3) / 4 with u = d / reach, whose slope is continuous.
    """

    faces: frozenset[int]
    thicknesses_mm: tuple[float, ...]
    borders: tuple[NearestTriangles, ...]
    reach_mm: float

    def at(self, points_mm: np.ndarray, own_mm: np.ndarray) -> np.ndarray:
        """Return the thickness (n,) at points (n, 3) on these faces, whose own thickness is `own_mm` (n,)."""
        total, weights = np.zeros(len(points_mm)), np.zeros(len(points_mm))
        for thickness, border in zip(self.thicknesses_mm, self.borders, strict=True):
            weight = (own_mm == thickness).astype(float)
            low, high = border.corners_mm.min(axis=(0, 1)), border.corners_mm.max(axis=(0, 1))
            near = np.all((points_mm > low - self.reach_mm) & (points_mm < high + self.reach_mm), axis=1)
            near = np.flatnonzero(near & (own_mm != thickness))
            if len(near):
                weight[near] = _weight(border.search(points_mm[near]).distance_mm / self.reach_mm)
            total += weight * thickness
            weights += weight
        return total / weights


def _weight(share: np.ndarray) -> np.ndarray:
    share = np.minimum(share, 1.0)
    across = 0.5 - 0.25 * (3.0 * share - share**3)
    return across / (1.0 - across)


@dataclass(frozen=True, eq=False)
class ByFace:
    """The thickness of each face of a mold, and the blends between them.

    Parameters
    ----------
    thicknesses_mm : array (n + 1,)
        By the faces' numbers; the first, 0, stands for points on no face.
    blends : tuple of FaceBlend
    """

    thicknesses_mm: np.ndarray
    blends: tuple[FaceBlend, ...]

    def at(self, points_mm: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Return the thickness (n,) at points (n, 3) on faces (n,)."""
        thickness = self.thicknesses_mm[faces]
        own = thickness.copy()
        for blend in self.blends:
            here = np.flatnonzero(np.isin(faces, list(blend.faces)))
            if len(here):
                thickness[here] = blend.at(points_mm[here], own[here])
        return thickness


def thickness_by_face(mold: Mold, named_mm: Mapping[int, float], otherwise_mm: float) -> ByFace:
    """Return the thickness of every face of a mold.

    Parameters
    ----------
    mold : Mold
    named_mm : mapping of int to float
        By the 1-based number of the face in what the file holds; see `Mold.file_faces`.
    otherwise_mm : float
        Of all the others.

    Raises
    ------
    InputError
        If the mold has no CAD faces, or not those that are named, or one of them closes the mouth.
    """
    if mold.upright is None:
        raise InputError(
            f"wall: {mold.name} is a mesh and has no CAD faces; name regions, or give a table over height and angle"
        )
    numbers = np.array([0, *mold.file_faces])
    mouth = mold.anatomy.finish_face
    outside = [number for number in sorted(set(numbers)) if number not in (0, numbers[mouth])]
    thicknesses = np.full(len(numbers), float(otherwise_mm))
    for number, thickness in named_mm.items():
        if number == numbers[mouth]:
            raise InputError(f"wall Face{number}: it closes the mouth, where no wall is; name another face")
        if number not in outside:
            raise InputError(
                f"wall Face{number}: {mold.name} has no such face outside; its faces are {_ranges(outside)}"
            )
        thicknesses[numbers == number] = thickness
    # The mouth has no thickness to blend into.
    edges = [edge for edge in _smooth_edges(mold.upright) if mold.anatomy.finish_face not in edge[:2]]
    blends = [_blend(group, edges, thicknesses) for group in _groups(edges) if len(set(thicknesses[group])) > 1]
    return ByFace(thicknesses, tuple(blends))


def _ranges(numbers: list[int]) -> str:
    """Return ascending numbers in short, as 1 to 4, 7."""
    starts = [number for number in numbers if number - 1 not in numbers]
    ends = [number for number in numbers if number + 1 not in numbers]
    return ", ".join(f"{a}" if a == b else f"{a} to {b}" for a, b in zip(starts, ends, strict=True))


def _smooth_edges(shape: Part.Shape) -> list[tuple[int, int, Part.Edge]]:
    """Return the edges across which the surface goes on smoothly, with the numbers of the two faces they part."""
    found: dict[int, list[list]] = defaultdict(list)
    for number, face in enumerate(shape.Faces, start=1):
        for edge in face.Edges:
            known = next((entry for entry in found[edge.hashCode()] if entry[0].isSame(edge)), None)
            if known is None:
                found[edge.hashCode()].append([edge, number])
            elif number not in known[1:]:
                known.append(number)
    pairs = [entry for entries in found.values() for entry in entries if len(entry) == 3]
    return [(a, b, edge) for edge, a, b in pairs if not edge.Degenerated and _is_smooth(shape, edge, a, b)]


def _is_smooth(shape: Part.Shape, edge: Part.Edge, a: int, b: int) -> bool:
    faces = shape.Faces[a - 1], shape.Faces[b - 1]
    first, last = edge.ParameterRange
    turns = []
    for share in (0.2, 0.5, 0.8):
        point = edge.valueAt(first + share * (last - first))
        normals = [np.array(face.normalAt(*face.Surface.parameter(point))) for face in faces]
        # Whether a face is turned over in its shell says nothing about its edge.
        turns.append(np.arccos(min(abs(float(normals[0] @ normals[1])), 1.0)))
    return float(np.median(turns)) < SMOOTH_EDGE


def _groups(edges: list[tuple[int, int, Part.Edge]]) -> list[list[int]]:
    """Return the faces that are joined by edges, directly or through others."""
    group = {number: {number} for a, b, _ in edges for number in (a, b)}
    for a, b, _ in edges:
        if group[a] is not group[b]:
            group[a] |= group[b]
            for number in group[b]:
                group[number] = group[a]
    return [sorted(numbers) for numbers in {id(numbers): numbers for numbers in group.values()}.values()]


def _blend(faces: list[int], edges: list[tuple[int, int, Part.Edge]], thicknesses: np.ndarray) -> FaceBlend:
    values = sorted(set(thicknesses[faces]))
    borders = []
    for value in values:
        ends = [
            _segments(edge)
            for a, b, edge in edges
            if a in faces and (thicknesses[a] == value) != (thicknesses[b] == value)
        ]
        corners = np.concatenate(ends)
        # A segment is a triangle without width; with one normal all over it does not bulge.
        borders.append(NearestTriangles(corners, np.tile([0.0, 0.0, 1.0], (len(corners), 3, 1))))
    return FaceBlend(frozenset(faces), tuple(map(float, values)), tuple(borders), 0.5 * BLEND_WALLS * values[-1])


def _segments(edge: Part.Edge) -> np.ndarray:
    points = np.array([tuple(point) for point in edge.discretize(Deflection=EDGE_DEFLECTION_MM)])
    return np.stack([points[:-1], points[1:], points[1:]], axis=1)
