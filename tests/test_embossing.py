"""What counts as embossing on the outside of a container, and what does not."""

from pathlib import Path

import numpy as np
import pytest

from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import mold_from_shape, read_mold
from glassworkbench.mold.embossing import embossed
from glassworkbench.mold.tessellation import tessellate
from glassworkbench.wall.measuring.outside import outside

ROOT = Path(__file__).resolve().parent.parent
SHARED = ROOT.parent / "shared" / "molds"


def can(*added, cut=()):
    """A can of radius 30 and height 100 with things fused to it and cut away."""
    body = Part.makeCylinder(30, 100)
    for thing in added:
        body = body.fuse(thing)
    for thing in cut:
        body = body.cut(thing)
    return body.removeSplitter()


def embossed_heights(shape):
    mesh = tessellate(shape, 0.05)
    found = embossed(mesh)
    heights = mesh.vertices_mm[mesh.triangles[found]][:, :, 2]
    return (float(heights.min()), float(heights.max())) if found.any() else None


def plate(low, high, out):
    """A plate 10 mm wide that stands out from the can."""
    return Part.makeBox(10 + out, 10, high - low, FreeCAD.Vector(20, -5, low)).common(
        Part.makeCylinder(30 + out, 200, FreeCAD.Vector(0, 0, -50))
    )


def test_a_raised_plate_is_embossing():
    assert embossed_heights(can(plate(40, 48, 1.0))) == pytest.approx((40, 48))


def test_its_fillet_belongs_to_it():
    shape = can(plate(40, 48, 1.0))
    foot = [
        edge
        for edge in shape.Edges
        if all(abs(np.hypot(vertex.X, vertex.Y) - 30) < 1e-6 and 39 < vertex.Z < 49 for vertex in edge.Vertexes)
    ]
    low, high = embossed_heights(shape.makeFillet(0.4, foot))
    assert low == pytest.approx(39.6, abs=0.02)
    assert high == pytest.approx(48.4, abs=0.02)


@pytest.mark.parametrize(
    "shape",
    [
        can(Part.makeCylinder(31, 4, FreeCAD.Vector(0, 0, 90))),
        can(cut=[plate(40, 48, -1.0).cut(Part.makeCylinder(29, 200))]),
        can(cut=[Part.makeBox(10, 8, 8, FreeCAD.Vector(28, -4, 40))]),
        can(plate(40, 80, 20.0)),
        can(Part.makeCylinder(10, 20, FreeCAD.Vector(0, 0, 100))),
        can(cut=[Part.makeCone(25, 15, 8)]),
    ],
    ids=["a ring", "a groove", "a pit with a flat floor", "a handle", "a neck", "a push-up"],
)
def test_what_is_no_embossing(shape):
    assert embossed_heights(shape) is None


def test_the_lugs_of_a_jar_are_embossing_and_its_ring_is_not():
    wall = outside(read_mold(ROOT / "examples" / "molds" / "jar.step"), lambda points, _: np.full(len(points), 3.0))
    radius = np.hypot(wall.corners_mm[..., 0], wall.corners_mm[..., 1])
    standing = (radius.mean(axis=1) > 31.05) & (wall.corners_mm[:, :, 2].min(axis=1) > 100.0)
    assert np.array_equal(wall.embossed, standing | wall.embossed)
    assert radius[wall.embossed].min() > 30.99
    assert not np.any(wall.embossed & wall.collar)
    assert len(wall.without_embossing().corners_mm) == np.count_nonzero(~wall.embossed)


@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared molds are not here")
def test_the_thread_of_a_flask_is_embossing_and_its_neck_is_not():
    mold = read_mold(SHARED / "occt_bottle.brep", outer_shell=True)
    wall = outside(mold, lambda points, _: np.full(len(points), 1.0))
    # The neck is a cylinder of radius 7.5 above z = 50, with 2.8 mm of thread in its middle.
    top = np.hypot(wall.corners_mm[..., 0], wall.corners_mm[..., 1]).max(axis=1)
    heights = wall.corners_mm[:, :, 2]
    assert wall.embossed.any()
    assert np.all(wall.embossed[(heights.min(axis=1) > 50.5) & (top > 7.6)])
    assert heights[wall.embossed].min() > 51.0
    assert heights[wall.embossed].max() < 54.0


def test_a_mold_without_any_has_none():
    mold = mold_from_shape(can(), "can", up=(0, 0, 1))
    wall = outside(mold, lambda points, _: np.full(len(points), 2.0))
    assert not wall.embossed.any()
    assert wall.embossing() is None
