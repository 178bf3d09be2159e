"""The simplest ways to hollow: the whole mold scaled about its middle, and opened at the mouth.

They are kept for comparison: but for a ball about its middle, or a box per axis, no wall comes out as asked everywhere.
"""

from __future__ import annotations

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import Mold, outside_mesh
from glassworkbench.scene import Mesh
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.candidate import Candidate
from glassworkbench.wall.levels.lids import PAST_MOUTH_MM, lifted
from glassworkbench.wall.measuring.outside import DEVIATION_MM, Outside
from glassworkbench.wall.solids import SEWING_MM, hollow_solid


def scaled(mold: Mold, asked: AskedThickness, wall: Outside, seconds: float) -> Candidate:
    """Scale the mold by one factor, so that the wall is as asked where it is widest."""
    points, thickness = _glass(wall)
    from_axis = np.hypot(points[:, 0], points[:, 1])
    widest = int(np.argmax(from_axis))
    factor = 1.0 - thickness[widest] / from_axis[widest]
    return _candidate(mold, wall, np.array([0.0, 0.0, 0.5 * mold.anatomy.height_mm]), np.full(3, factor))


def scaled_per_axis(mold: Mold, asked: AskedThickness, wall: Outside, seconds: float) -> Candidate:
    """Scale the mold along each axis by itself, so that the wall is as asked on all sides and under the base."""
    points, thickness = _glass(wall)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = 0.5 * (low + high)
    sides = [thickness[[points[:, k].argmin(), points[:, k].argmax()]].mean() for k in (0, 1)]
    walls = np.array([*sides, thickness[points[:, 2].argmin()]])
    return _candidate(mold, wall, middle, 1.0 - 2.0 * walls / (high - low))


def _glass(wall: Outside) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners (n, 3) of the outside's triangles, the collar left out, and the thickness (n,) asked there."""
    return wall.corners_mm[~wall.collar].reshape(-1, 3), wall.thickness_mm[~wall.collar].ravel()


def _candidate(mold: Mold, wall: Outside, middle: np.ndarray, factors: np.ndarray) -> Candidate:
    if np.any(factors <= 0.0):
        raise InputError(
            f"wall: {wall.thickness_mm.max():.3g} mm is as thick as {mold.name} is wide; ask for a thinner wall"
        )
    outer, _ = outside_mesh(mold, DEVIATION_MM)
    points = middle + factors * (outer.vertices_mm - middle)
    normals = outer.normals / factors
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    level = float(middle[2] + factors[2] * (mold.anatomy.finish_height_mm - middle[2]))
    # What OCC or a file rounds off a flat mouth must not part it from its own height.
    mouth = np.abs(points[:, 2] - level) < 1e-4 * mold.anatomy.height_mm * factors[2]
    points[mouth, 2] = level
    small = Mesh(points, outer.triangles, normals)
    rise = wall.finish_height_mm - level
    solid, notes = None, ()
    if mold.upright is not None:
        try:
            cavity = _opened(mold.upright.Faces, mold.anatomy.finish_face, middle, factors, rise)
            solid = hollow_solid(mold.upright, cavity, mold.anatomy.finish_face)
        except (GlassWorkbenchError, Part.OCCError) as error:
            notes = (f"no solid could be made of it ({error}), so it cannot be saved as STEP",)
    return Candidate(solid, lifted(small, level, rise + PAST_MOUTH_MM), lifted(small, level, rise), notes)


def _opened(faces: list, finish_face: int, middle: np.ndarray, factors: np.ndarray, rise_mm: float) -> Part.Shape:
    """Return the solid that the scaled faces bound, its mouth extruded upward."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.diag(factors)
    matrix[:3, 3] = middle - factors * middle
    # One factor keeps cylinders cylinders; three make splines of them.
    scaled_faces = [face.transformGeometry(FreeCAD.Matrix(*matrix.ravel().tolist())).Faces[0] for face in faces]
    mouth = scaled_faces[finish_face - 1]
    prism = mouth.extrude(FreeCAD.Vector(0.0, 0.0, rise_mm))
    level = mouth.CenterOfMass.z
    band = [face for face in prism.Faces if face.CenterOfMass.z > level + 1e-9 * rise_mm]
    shell = Part.Shell([face for k, face in enumerate(scaled_faces, start=1) if k != finish_face] + band)
    shell.sewShape(SEWING_MM)
    if len(shell.Shells) != 1 or not shell.Shells[0].isClosed():
        raise GlassWorkbenchError("the scaled faces do not join")
    return Part.Solid(shell.Shells[0])
