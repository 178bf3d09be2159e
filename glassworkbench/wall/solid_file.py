"""Writes a solid into a CAD file, and reads the file again: what OCC writes need not be what it reads."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold.read import STEP_ENDINGS, read_shape
from glassworkbench.wall.step_file import write_step

VOLUME_SHARE = 1e-3
"""The volumes before and after agree to this, as the same faces are integrated in the same way."""


def write_solid(solid: Part.Shape, name: str, path: Path) -> None:
    """Write a solid as STEP, BREP or FCStd, by the path's ending.

    Parameters
    ----------
    solid : Part.Shape
    name : str
        Of the product in a STEP file, and its label in a document of FreeCAD.
    path : Path
        Overwritten; what is left there after an error is no solid.

    Raises
    ------
    GlassWorkbenchError
        If the file does not hold the same solid, valid and closed, when it is read again.

    Notes
    -----
    With every edge a STEP file holds its curves in the parameters of the faces. Some of these OCC reads wrongly, as
    where an edge runs once around a B-spline surface against the sense of its parameter; without them it finds its own.
    """
    ending = path.suffix.lower()
    if ending in STEP_ENDINGS:
        write_step(solid, name, path)
        if not _fault(solid, path):
            return
        with _without_parameter_curves():
            write_step(solid, name, path)
    elif ending == ".brep":
        solid.exportBrep(str(path))
    else:
        _write_document(solid, name, path)
    fault = _fault(solid, path)
    if fault:
        raise GlassWorkbenchError(f"read again, {fault}; save it in another CAD format")


def _fault(solid: Part.Shape, path: Path) -> str:
    """Return what is wrong with the solid that a file holds; empty if it is the one that was written."""
    try:
        read = read_shape(path, made_container=True)
    except InputError:
        return "the file holds no shape"
    if len(read.Solids) != 1:
        return f"the file holds {len(read.Solids)} solids"
    if not read.isValid():
        return "the solid is not valid"
    if not all(shell.isClosed() for shell in read.Solids[0].Shells):
        return "the solid is open"
    if abs(read.Volume - solid.Volume) > VOLUME_SHARE * abs(solid.Volume):
        return f"the solid holds {read.Volume:.0f} mm3 instead of {solid.Volume:.0f}"
    return ""


@contextlib.contextmanager
def _without_parameter_curves() -> Iterator[None]:
    Part.setStaticValue("write.surfacecurve.mode", 0)
    try:
        yield
    finally:
        Part.setStaticValue("write.surfacecurve.mode", 1)


def _write_document(solid: Part.Shape, name: str, path: Path) -> None:
    document = FreeCAD.newDocument("Container", hidden=True, temp=True)
    try:
        document.addObject("Part::Feature", "Container").Shape = solid
        document.Objects[0].Label = name
        document.recompute()
        document.saveCopy(str(path))
    finally:
        FreeCAD.closeDocument(document.Name)
