"""Splits a solid where its curves and surfaces have kinks inside: OCC's offset refuses those."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from glassworkbench.freecad import Part
from glassworkbench.mold.read import silenced_output

RESOURCE = "GlassWorkbench"
"""Name of the reading rules; OCC looks for them in the folder that CSF_GlassWorkbenchDefaults names."""

RULES = """\
FromSTEP.exec.op: FixShape,SplitContinuity,FixShape
FromSTEP.SplitContinuity.Tolerance3d: 1.e-7
FromSTEP.SplitContinuity.SurfaceContinuity: C1
FromSTEP.SplitContinuity.CurveContinuity: C1
FromSTEP.SplitContinuity.Curve2dContinuity: C1
"""
"""OCC's shape-processing operators and their parameters, as its user's guide on shape healing lists them."""


def has_kinks(shape: Part.Shape) -> bool:
    """Tell whether a surface or a curve of a shape is only C0: continuous, with a kink inside."""
    return any(geometry.Continuity == "C0" for geometry in _geometries(shape))


def healed(solid: Part.Shape) -> Part.Shape:
    """Return a solid whose kinks lie on edges between faces, of the same form; itself if it has none.

    Parameters
    ----------
    solid : Part.Shape
        One solid. Its faces do not keep their numbers.

    Notes
    -----
    Only OCC's STEP reader can split so from FreeCAD's Python: the solid is written and read back with its rules. What
    does not come back as one closed solid is given up, and the solid returned as it was.
    """
    if not has_kinks(solid):
        return solid
    with tempfile.TemporaryDirectory(prefix="glassworkbench-") as name, _rules_in(Path(name)), silenced_output():
        path = str(Path(name) / "solid.step")
        solid.exportStep(path)
        split = Part.read(path)
    return split.Solids[0] if len(split.Solids) == 1 and split.Solids[0].isClosed() else solid


def _geometries(shape: Part.Shape) -> Iterator[Part.Geometry]:
    yield from (face.Surface for face in shape.Faces)
    yield from (edge.Curve for edge in shape.Edges if not edge.Degenerated)


@contextmanager
def _rules_in(folder: Path) -> Iterator[None]:
    (folder / RESOURCE).write_text(RULES, encoding="ascii")
    variable = f"CSF_{RESOURCE}Defaults"
    os.environ[variable] = str(folder)
    Part.setStaticValue("read.step.resource.name", RESOURCE)
    try:
        yield
    finally:
        Part.setStaticValue("read.step.resource.name", "STEP")
        del os.environ[variable]
