"""Reads a CAD file into OCC shapes, quietly, and says in one sentence what is wrong with it."""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.scene.validate import file_path, positive

STEP_ENDINGS = (".step", ".stp")
IGES_ENDINGS = (".iges", ".igs")
ENDINGS = (*STEP_ENDINGS, *IGES_ENDINGS, ".brep", ".brp", ".fcstd")
MESH_ENDINGS = (".stl", ".obj", ".ply")


def read_shape(
    path: str | os.PathLike, *, scale_to_mm: float | None = None, made_container: bool = False
) -> Part.Shape:
    """Return what a CAD file holds as one shape, in mm.

    Parameters
    ----------
    path : path
        STEP, IGES, BREP or FCStd. A STEP file's units are honoured.
    scale_to_mm : float, optional
        Multiplies every length, for a file whose declared unit is wrong.
    made_container : bool
        Of an FCStd document in which this workbench made a container, return that, rather than the mold it is made of.

    Raises
    ------
    InputError
        If the file is missing, empty, of another kind, cut short, or holds no shape.
    """
    path = file_path(path)
    _check_file(path)
    try:
        with silenced_output():
            shape = _read_document(path, made_container) if path.suffix.lower() == ".fcstd" else Part.read(str(path))
            empty = shape.isNull() or not shape.Faces
    except (Part.OCCError, OSError, RuntimeError, ValueError) as error:
        raise InputError(
            f"{path}: it cannot be read as a CAD file; it is damaged or of another kind; export it again"
        ) from error
    if empty:
        raise InputError(f"{path}: it holds no surface that could be a container; export the container as a solid")
    if scale_to_mm is not None:
        scale_to_mm = positive(scale_to_mm, "scale_to_mm")
        shape = shape.scaled(scale_to_mm, FreeCAD.Vector()) if scale_to_mm != 1.0 else shape
    return shape


def sha256(path: str | os.PathLike) -> str:
    """Return the SHA-256 digest of a file, in hexadecimal."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def _check_file(path: Path) -> None:
    if path.suffix.lower() not in ENDINGS:
        raise InputError(
            f"{path}: {path.suffix or 'no ending'} is not a CAD file this reads; "
            f"give one of {', '.join((*ENDINGS, *MESH_ENDINGS))}"
        )
    if not path.is_file():
        raise InputError(f"{path}: there is no such file; check the path")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: it cannot be opened ({error.strerror}); check its permissions") from error
    if not content.strip():
        raise InputError(f"{path}: the file is empty; export it again")
    if path.suffix.lower() in STEP_ENDINGS:
        if b"ISO-10303-21" not in content[:1024]:
            raise InputError(
                f"{path}: this is not a STEP file (it does not begin with ISO-10303-21); export it as STEP"
            )
        if b"END-ISO-10303-21" not in content[-1024:]:
            raise InputError(f"{path}: the STEP file is cut short (its last line is missing); export or copy it again")


def _read_document(path: Path, made_container: bool) -> Part.Shape:
    document = FreeCAD.openDocument(str(path), True)
    try:
        items = [item for item in document.Objects if _has_faces(item)]
        # Groups and pictures refer to a solid, too, but only what has a shape of its own is made of it.
        tops = [item for item in items if not any(_has_faces(user) for user in item.InList)]
        tops = [item for item in tops if item.Shape.Solids] or tops
        if not made_container:
            tops = list({item.Name: item for item in map(_mold_of, tops)}.values())
        shapes = [item.Shape.copy() for item in tops]
    finally:
        FreeCAD.closeDocument(document.Name)
    return shapes[0] if len(shapes) == 1 else Part.Compound(shapes)


def _has_faces(item: FreeCAD.DocumentObject) -> bool:
    return item.isDerivedFrom("Part::Feature") and bool(item.Shape.Faces)


def _mold_of(item: FreeCAD.DocumentObject) -> FreeCAD.DocumentObject:
    """Return the solid that a container of this workbench is the hollow form of; of anything else, the item itself."""
    made_here = {"Source", "WallThickness", "MethodUsed"} <= set(item.PropertiesList)
    return item.Source if made_here and item.Source is not None else item


@contextlib.contextmanager
def silenced_output() -> Iterator[None]:
    """Keep what OCC writes to the process's standard output and error away from the user."""
    sys.stdout.flush()
    sys.stderr.flush()
    with contextlib.ExitStack() as stack:
        sink = stack.enter_context(tempfile.TemporaryFile())
        for descriptor in (1, 2):
            try:
                saved = os.dup(descriptor)
            except OSError:
                # A windowed program may have no standard streams at all: then there is nothing to keep quiet.
                continue
            stack.callback(os.close, saved)
            stack.callback(os.dup2, saved, descriptor)
            os.dup2(sink.fileno(), descriptor)
        yield
