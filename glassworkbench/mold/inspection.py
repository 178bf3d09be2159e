"""What a CAD file holds, in words and numbers that can be printed or written as JSON."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import Part
from glassworkbench.mold.anatomy import Anatomy
from glassworkbench.mold.axis import Standing, find_standing, is_hollow, to_upright
from glassworkbench.mold.cavity import is_closed_around
from glassworkbench.mold.closing import closed_solid
from glassworkbench.mold.faults import faults
from glassworkbench.mold.files import read_mesh_mm
from glassworkbench.mold.measures import measuring_deviation_mm, mesh_of, signed_volume, volume_behind
from glassworkbench.mold.mesh_mold import mold_from_mesh
from glassworkbench.mold.mold import (
    INSIDE_OUT,
    Mold,
    already_hollow,
    faces_inward,
    mold_from_shape,
    outward,
    single_solid,
)
from glassworkbench.mold.read import MESH_ENDINGS, STEP_ENDINGS, read_shape, sha256
from glassworkbench.mold.step_entities import count_entities
from glassworkbench.mold.tessellation import tessellate
from glassworkbench.mold.units import declared_unit
from glassworkbench.scene.validate import file_path

UNKNOWN = (
    "mesh_volume_mm3",
    "hollow",
    "axis",
    "base_point_mm",
    "height_mm",
    "finish_height_mm",
    "finish_outer_radius_mm",
    "finish_face",
    "push_up_mm",
    "departure_mm",
    "departure_at",
    "revolved",
    "nearly_round",
    "regions",
)
"""What is null in the answer where it cannot be found."""


def inspect(
    path: str | os.PathLike,
    *,
    scale_to_mm: float | None = None,
    finish_height_mm: float | None = None,
    outer_shell: bool = False,
    block: bool = False,
    close_open_shell: bool = False,
) -> dict:
    """Return what a CAD file holds, as a dictionary that JSON can carry.

    Parameters
    ----------
    path : path
        STEP, IGES, BREP, FCStd, or a mesh (STL, OBJ, PLY), whose only `faces` are triangles.
    scale_to_mm : float, optional
        Multiplies every length.
    finish_height_mm, outer_shell, block, close_open_shell : optional
        Overrule what is found, as in `mold_from_shape`.

    Returns
    -------
    dict
        path, sha256, unit, solids, `entities` (count by type, of a STEP file), `faces` (count by surface), `faults`
        (sentences on what is wrong), `notes` (sentences on what was taken for the mold, and what else may be), and
        those of `UNKNOWN` that can be found. Of a container that is already hollow they are those of its outside; where
        inside and outside cannot be parted, only axis, base and heights.

    Raises
    ------
    InputError
        If the file cannot be read at all; what can be read but not used is told under `faults`.
    """
    path = file_path(path)
    if path.suffix.lower() in MESH_ENDINGS:
        return _inspect_mesh(path, scale_to_mm, outer_shell, close_open_shell)
    shape = read_shape(path, scale_to_mm=scale_to_mm)
    text = path.read_text(encoding="latin-1") if path.suffix.lower() in STEP_ENDINGS else ""
    unit = declared_unit(path)
    found = {
        "path": str(path),
        "sha256": sha256(path),
        "unit": unit,
        "entities": count_entities(text),
        "faces": dict(Counter(type(face.Surface).__name__ for face in shape.Faces).most_common()),
        "solids": len(shape.Solids),
        **dict.fromkeys(UNKNOWN),
        "faults": faults(shape, unit),
        "notes": [],
    }
    try:
        if block or finish_height_mm is not None:
            options = {"block": block, "close_open_shell": close_open_shell, "finish_height_mm": finish_height_mm}
            mold = mold_from_shape(shape, path.stem, outer_shell=outer_shell, **options)
            return _with_mold(found | {"hollow": False}, mold)
        if close_open_shell:
            shape, repairs = closed_solid(shape)
            found["notes"] += repairs
        if faces_inward(shape):
            found["notes"].append(INSIDE_OUT)
        solid, vertices, triangles = outward(single_solid(shape))
        found["mesh_volume_mm3"] = _solid_volume_mm3(solid)
        standing = find_standing(solid, vertices, triangles)
        found["hollow"] = is_hollow(standing, vertices, triangles)
        if found["hollow"] and not outer_shell:
            if is_closed_around(solid):
                raise InputError(already_hollow(solid))
            found["notes"].append(already_hollow(solid))
            return _with_outside(found, solid, standing, vertices)
        return _with_mold(found, mold_from_shape(solid, path.stem, outer_shell=outer_shell))
    except InputError as error:
        found["faults"].append(str(error))
    return found


def _inspect_mesh(path: Path, scale_to_mm: float | None, outer_shell: bool, close_open_shell: bool) -> dict:
    vertices, triangles = read_mesh_mm(path, scale_to_mm)
    found = {
        "path": str(path),
        "sha256": sha256(path),
        "unit": None,
        "entities": {},
        "faces": {"Triangle": len(triangles)},
        "solids": 0,
        **dict.fromkeys(UNKNOWN),
        "faults": [],
        "notes": [],
    }
    try:
        options = {"outer_shell": outer_shell, "close_open_shell": close_open_shell}
        return _with_mold(found | {"hollow": False}, mold_from_mesh(vertices, triangles, path.stem, **options))
    except InputError as error:
        found["faults"].append(str(error))
    return found


def _with_mold(found: dict, mold: Mold) -> dict:
    told = {"notes": [*found["notes"], *mold.repairs]}
    return found | {"mesh_volume_mm3": _volume_mm3(mold)} | _full_mold(mold) | told


def _volume_mm3(mold: Mold) -> float:
    return _solid_volume_mm3(mold.upright) if mold.mesh is None else volume_behind(mold.mesh)


def _solid_volume_mm3(solid: Part.Shape) -> float:
    try:
        return volume_behind(tessellate(solid, measuring_deviation_mm(solid)))
    except GlassWorkbenchError:
        # A mesh with holes has no bulges, but a volume near enough.
        return signed_volume(*mesh_of(solid))


def _full_mold(mold: Mold) -> dict:
    anatomy = mold.anatomy
    return {
        "axis": anatomy.axis.tolist(),
        "base_point_mm": anatomy.base_point_mm.tolist(),
        "height_mm": anatomy.height_mm,
        "finish_height_mm": anatomy.finish_height_mm,
        "finish_outer_radius_mm": anatomy.finish_outer_radius_mm,
        "finish_face": (mold.file_faces[anatomy.finish_face - 1] or None) if anatomy.finish_face else None,
        "push_up_mm": anatomy.push_up_mm,
        "departure_mm": anatomy.departure_mm,
        "departure_at": {"height_mm": float(anatomy.departure_at_mm[2]), "angle_deg": _angle_deg(anatomy)},
        "revolved": anatomy.is_revolved,
        "nearly_round": mold.is_nearly_round,
        "regions": {region: list(heights) for region, heights in anatomy.regions.items()},
    }


def _angle_deg(anatomy: Anatomy) -> float:
    """Return the angle about the axis, from the upright container's x axis, at which it departs the most."""
    x, y, _ = anatomy.departure_at_mm
    # Rounded first: the remainder of what is just below 0 would be 360.
    return float(np.round(np.degrees(np.arctan2(y, x)), 6) % 360.0)


def _with_outside(found: dict, solid: Part.Shape, standing: Standing, vertices_mm: np.ndarray) -> dict:
    rim = {"finish_face": standing.finish_face or None}
    try:
        mold = mold_from_shape(solid, "", outer_shell=True)
    except InputError as error:
        return found | _heights(standing, vertices_mm) | rim | {"faults": [*found["faults"], str(error)]}
    return found | _full_mold(mold) | rim | {"notes": [*found["notes"], *mold.repairs]}


def _heights(standing: Standing, vertices_mm: np.ndarray) -> dict:
    heights = (vertices_mm - standing.point_mm) @ standing.axis
    upright = to_upright(vertices_mm, standing)
    near_rim = upright[:, 2] > 0.98 * upright[:, 2].max()
    return {
        "axis": standing.axis.tolist(),
        "base_point_mm": (standing.point_mm + heights.min() * standing.axis).tolist(),
        "height_mm": float(np.ptp(heights)),
        "finish_height_mm": float(np.ptp(heights)),
        "finish_outer_radius_mm": float(np.hypot(*upright[near_rim, :2].T).max()),
    }
