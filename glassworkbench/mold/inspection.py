"""What a CAD file holds, in words and numbers that can be printed or written as JSON."""

from __future__ import annotations

import os
import re
from collections import Counter
from pathlib import Path

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.freecad import Part
from glassworkbench.mold.anatomy import Anatomy
from glassworkbench.mold.axis import Standing, find_standing, is_hollow, to_upright
from glassworkbench.mold.cavity import looks_like_block
from glassworkbench.mold.closing import closed_solid
from glassworkbench.mold.measures import signed_volume
from glassworkbench.mold.mold import mold_from_shape, outward, single_solid
from glassworkbench.mold.read import STEP_ENDINGS, read_shape, sha256

STEP_ENTITY = re.compile(r"#\d+\s*=\s*([A-Z][A-Z0-9_]*)\s*\(")
STEP_SI_LENGTH = re.compile(r"LENGTH_UNIT\s*\(\s*\)[^;]*?SI_UNIT\s*\(\s*(?:\.(\w+)\.|\$)\s*,\s*\.METRE\.")
STEP_NAMED_LENGTH = re.compile(r"CONVERSION_BASED_UNIT\s*\(\s*'(\w+)'[^;]*?LENGTH_UNIT")

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
    "revolved",
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
        STEP, IGES, BREP or FCStd.
    scale_to_mm : float, optional
        Multiplies every length.
    finish_height_mm, outer_shell, block, close_open_shell : optional
        Overrule what is found, as in `mold_from_shape`.

    Returns
    -------
    dict
        path, sha256, unit, solids, `entities` (count by type, of a STEP file), `faces` (count by surface), `faults`
        (sentences), and those of `UNKNOWN` that can be found. Of a container that is already hollow they are those of
        its outside; where inside and outside cannot be parted, only axis, base and heights.

    Raises
    ------
    InputError
        If the file cannot be read at all; what can be read but not used is told under `faults`.
    """
    path = Path(path)
    shape = read_shape(path, scale_to_mm=scale_to_mm)
    text = path.read_text(encoding="latin-1") if path.suffix.lower() in STEP_ENDINGS else ""
    found = {
        "path": str(path),
        "sha256": sha256(path),
        "unit": _unit(text),
        "entities": dict(Counter(STEP_ENTITY.findall(text)).most_common()),
        "faces": dict(Counter(type(face.Surface).__name__ for face in shape.Faces).most_common()),
        "solids": len(shape.Solids),
        **dict.fromkeys(UNKNOWN),
        "faults": _faults(shape),
    }
    try:
        if block:
            mold = mold_from_shape(shape, path.stem, finish_height_mm=finish_height_mm, block=True)
            volume = signed_volume(*outward(mold.solid)[1:])
            return (
                found
                | {"mesh_volume_mm3": volume, "hollow": False, "faults": [*found["faults"], *mold.repairs]}
                | (_full_mold(mold.anatomy))
            )
        if looks_like_block(shape):
            raise InputError(
                f"it holds {len(shape.Solids)} solids that look like a mold block; use --block (block=True)"
            )
        if close_open_shell:
            shape, repairs = closed_solid(shape)
            found["faults"] += repairs
        solid, vertices, triangles = outward(single_solid(shape))
        found["mesh_volume_mm3"] = signed_volume(vertices, triangles)
        if finish_height_mm is None:
            standing = find_standing(solid, vertices, triangles)
            found["hollow"] = is_hollow(standing, vertices, triangles)
        if found["hollow"] and not outer_shell:
            found |= _hollow_container(solid, standing, vertices)
        else:
            mold = mold_from_shape(solid, path.stem, finish_height_mm=finish_height_mm, outer_shell=outer_shell)
            found |= _full_mold(mold.anatomy)
    except InputError as error:
        found["faults"].append(str(error))
    return found


def _full_mold(anatomy: Anatomy) -> dict:
    return {
        "axis": anatomy.axis.tolist(),
        "base_point_mm": anatomy.base_point_mm.tolist(),
        "height_mm": anatomy.height_mm,
        "finish_height_mm": anatomy.finish_height_mm,
        "finish_outer_radius_mm": anatomy.finish_outer_radius_mm,
        "finish_face": anatomy.finish_face,
        "push_up_mm": anatomy.push_up_mm,
        "departure_mm": anatomy.departure_mm,
        "revolved": anatomy.is_revolved,
        "regions": {region: list(heights) for region, heights in anatomy.regions.items()},
    }


def _hollow_container(solid: Part.Shape, standing: Standing, vertices_mm: np.ndarray) -> dict:
    rim = {"finish_face": standing.finish_face or None}
    try:
        return _full_mold(mold_from_shape(solid, "", outer_shell=True).anatomy) | rim
    except InputError:
        return _heights(standing, vertices_mm) | rim


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


def _unit(step_text: str) -> str | None:
    """Return the length unit that a STEP file declares, like millimetre or inch; None for another kind of file."""
    named = STEP_NAMED_LENGTH.search(step_text)
    if named:
        return named.group(1).lower()
    si = STEP_SI_LENGTH.search(step_text)
    return f"{(si.group(1) or '').lower()}metre" if si else None


def _faults(shape: Part.Shape) -> list[str]:
    faults = []
    if not shape.isValid():
        faults.append("OCC finds the shape invalid; repair it in the CAD program if hollowing fails")
    broken = sum(
        type(face.Surface).__name__ == "BSplineSurface" and face.Surface.Continuity == "C0" for face in shape.Faces
    )
    if broken:
        faults.append(f"{broken} B-spline faces have kinks (C0), which OCC cannot offset before it splits them")
    return faults
