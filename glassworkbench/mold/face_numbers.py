"""Which face of a file each face of the mold is, where the mold is only part of what the file holds."""

from __future__ import annotations

import numpy as np

from glassworkbench.freecad import FreeCAD, Part

SAME_SHARE = 1e-6
"""A place of the mold this near a face of the file, as a share of the file's size, lies on it."""

BOX_SHARE = 0.01
"""Farther than this share of the file's size beyond the box around a face no place is looked for on it."""


def numbers_in_file(solid: Part.Shape, shape: Part.Shape) -> tuple[int, ...]:
    """Return for each face of a solid the 1-based number of the file's face that it is, or is a part of.

    Parameters
    ----------
    solid : Part.Shape
        The mold's solid.
    shape : Part.Shape
        What the file holds, in the same coordinates.

    Returns
    -------
    tuple of int
        0 for faces that the file does not have, as the one that closes the mouth.
    """
    faces = shape.Faces
    if len(faces) == len(solid.Faces) and all(a.isSame(b) for a, b in zip(solid.Faces, faces, strict=True)):
        return tuple(range(1, len(faces) + 1))
    near = SAME_SHARE * shape.BoundBox.DiagonalLength
    boxes = [face.BoundBox for face in faces]
    for box in boxes:
        # A box around a face's mesh is smaller than the face.
        box.enlarge(BOX_SHARE * shape.BoundBox.DiagonalLength)
    return tuple(_number_at(_place_on(face), faces, boxes, near) for face in solid.Faces)


def _number_at(place: FreeCAD.Vector, faces: list, boxes: list, near_mm: float) -> int:
    vertex = Part.Vertex(place)
    distances = {
        number: vertex.distToShape(face)[0]
        for number, (face, box) in enumerate(zip(faces, boxes, strict=True), start=1)
        if box.isInside(place)
    }
    nearest = min(distances, key=distances.get, default=0)
    return nearest if nearest and distances[nearest] < near_mm else 0


def _place_on(face: Part.Face) -> FreeCAD.Vector:
    """Return a place on a face well within its edges."""
    vertices, triangles = face.tessellate(1e-2 * face.BoundBox.DiagonalLength)
    corners = np.array([tuple(vertex) for vertex in vertices])[np.array(triangles)]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    middle = FreeCAD.Vector(*corners[np.argmax(areas)].mean(axis=0).tolist())
    return face.Surface.value(*face.Surface.parameter(middle))
