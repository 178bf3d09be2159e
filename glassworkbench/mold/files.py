"""Opens a file as a mold, whether it holds CAD faces or a mesh."""

from __future__ import annotations

import dataclasses
import functools
import os
from pathlib import Path

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.mold.mesh_mold import mold_from_mesh
from glassworkbench.mold.mold import Mold, mold_from_shape
from glassworkbench.mold.read import MESH_ENDINGS, read_shape, sha256
from glassworkbench.scene.meshes import read_triangles
from glassworkbench.scene.validate import file_path, positive


def read_mold(
    path: str | os.PathLike,
    *,
    scale_to_mm: float | None = None,
    axis: object = None,
    up: object = None,
    finish_height_mm: float | None = None,
    outer_shell: bool = False,
    block: bool = False,
    close_open_shell: bool = False,
) -> Mold:
    """Return the mold in a CAD file or a mesh.

    Parameters
    ----------
    path : path
        STEP, IGES, BREP or FCStd file with one closed solid: the outer shape of a container, full inside. Or an STL,
        OBJ or PLY mesh of it, in mm, for which `finish_height_mm` and `block` are refused.
    scale_to_mm : float, optional
        Multiplies every length, for a file whose declared unit is wrong.
    axis, up, finish_height_mm, outer_shell, block, close_open_shell : optional
        Overrule what is found, as in `mold_from_shape`.

    Raises
    ------
    InputError
        If the file cannot be read, does not hold exactly one closed solid, or its axis or finish cannot be found.
    """
    path = file_path(path)
    options = {"axis": axis, "up": up, "outer_shell": outer_shell, "close_open_shell": close_open_shell}
    if path.suffix.lower() in MESH_ENDINGS:
        if finish_height_mm is not None or block:
            option = "block=True" if block else "finish_height_mm"
            raise InputError(f"{path}: {option} is for CAD solids, and this is a mesh; cut it flat where it comes from")
        vertices, triangles = read_mesh_mm(path, scale_to_mm)
        make = functools.partial(mold_from_mesh, vertices, triangles, path.stem, **options)
    else:
        shape = read_shape(path, scale_to_mm=scale_to_mm)
        options |= {"finish_height_mm": finish_height_mm, "block": block}
        make = functools.partial(mold_from_shape, shape, path.stem, **options)
    try:
        mold = make()
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return dataclasses.replace(mold, path=path, sha256=sha256(path))


def read_mesh_mm(path: Path, scale_to_mm: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices (n, 3) in mm and the triangles (m, 3) of an STL, OBJ or PLY file, as they are there."""
    vertices, triangles, _ = read_triangles(path)
    return vertices * (1.0 if scale_to_mm is None else positive(scale_to_mm, "scale_to_mm")), triangles
