"""The container is found as the void in a mold block, whatever the block is made of."""

from pathlib import Path

import numpy as np
import pytest

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import inspect, mold_from_shape, read_mold
from glassworkbench.mold.cavity import cavity_of_block, looks_like_block

ROOT = Path(__file__).resolve().parent.parent
MOLDS = ROOT / "examples" / "molds"
SETS = ROOT.parent / "shared" / "molds"


def at(x, y, z):
    return FreeCAD.Vector(x, y, z)


def bottle():
    body = Part.makeCylinder(30, 80).fuse(Part.makeCone(30, 12, 20, at(0, 0, 80)))
    return body.fuse(Part.makeCylinder(12, 20, at(0, 0, 100))).removeSplitter()


def parts_of_a_blow_mold():
    """Return two halves, a neck ring, a bottom plate with a push-up, and four bolts, around `bottle`."""
    around = Part.makeCylinder(55, 100).cut(bottle())
    halves = [around.common(Part.makeBox(200, 100, 100, at(-100, y, 0))) for y in (0, -100)]
    ring = Part.makeCylinder(25, 20, at(0, 0, 100)).cut(Part.makeCylinder(12, 20, at(0, 0, 100)))
    plate = Part.makeCylinder(55, 15, at(0, 0, -15)).fuse(Part.makeCone(20, 8, 6))
    bolts = [Part.makeCylinder(3, 30, at(45 * x, 30 * y, -10)) for x in (1, -1) for y in (1, -1)]
    return [*(half.cut(Part.Compound(bolts)) for half in halves), ring, plate.cut(Part.Compound(bolts)), *bolts]


def press_mold(clearance=0.2):
    """Return a block and a core whose shoulder closes a tumbler of 30 by 80 at 80, in a guide of 20."""
    block = Part.makeCylinder(50, 110, at(0, 0, -10)).cut(Part.makeCylinder(30, 100))
    core = Part.makeCone(24, 27, 76, at(0, 0, 4)).fuse(Part.makeCylinder(30 - clearance, 20, at(0, 0, 80)))
    return Part.Compound([block, core.removeSplitter()])


def test_one_block_with_a_cavity():
    mold = mold_from_shape(Part.makeBox(100, 90, 135, at(-50, -45, -15)).cut(bottle()), "block", block=True)
    assert mold.solid.Volume == pytest.approx(bottle().Volume, rel=1e-9)
    assert mold.anatomy.axis == pytest.approx([0, 0, 1], abs=1e-9)
    assert mold.anatomy.is_revolved
    assert "leaves the block" in mold.repairs[0]


@pytest.mark.parametrize("turned", [False, True])
def test_halves_with_a_neck_ring_a_bottom_plate_and_bolts(turned):
    block = Part.Compound(parts_of_a_blow_mold())
    up = FreeCAD.Rotation(at(1, 2, 0), 70) if turned else FreeCAD.Rotation()
    block.transformShape(FreeCAD.Placement(at(3, 4, 5), up).toMatrix(), True, False)
    assert looks_like_block(block)
    mold = mold_from_shape(block, "blow mold", block=True)
    frustum = np.pi * 6 * (20**2 + 20 * 8 + 8**2) / 3
    assert mold.solid.isValid()
    assert mold.solid.Volume == pytest.approx(bottle().Volume - frustum, rel=1e-6)
    assert mold.anatomy.axis == pytest.approx(tuple(up.multVec(at(0, 0, 1))), abs=1e-9)
    assert mold.anatomy.push_up_mm == pytest.approx(6, abs=1e-6)
    assert mold.anatomy.finish_outer_radius_mm == pytest.approx(12, abs=1e-2)
    assert "4 beside the axis" in mold.repairs[0]


@pytest.mark.parametrize("clearance", [0.0, 0.2])
def test_a_core_is_taken_out_and_its_shoulder_is_the_finish(clearance):
    mold = mold_from_shape(press_mold(clearance), "press mold", block=True)
    assert mold.solid.Volume == pytest.approx(np.pi * 30**2 * 80, rel=1e-9)
    assert mold.anatomy.axis == pytest.approx([0, 0, 1])
    assert "core's shoulder closes it, 80 mm above the base" in mold.repairs[0]


def test_a_block_around_a_bottle_of_free_form_faces():
    jar = read_mold(MOLDS / "perfume_flacon.step").upright
    box = jar.BoundBox
    size = 2 * max(box.XLength, box.YLength)
    block = Part.makeBox(size, size, 10 + box.ZMax, at(-size / 2, -size / 2, -10)).cut(jar)
    assert cavity_of_block(block).Volume == pytest.approx(jar.Volume, rel=1e-6)


def test_solids_without_a_void_are_refused():
    boxes = Part.Compound([Part.makeBox(40, 40, 40), Part.makeBox(40, 40, 40, at(0, 0, 40))])
    with pytest.raises(InputError, match="enclose no void"):
        mold_from_shape(boxes, "boxes", block=True)


def single_block(closed):
    """A block of one solid around a bottle; the void of a closed one has no mouth."""
    return Part.makeBox(100, 90, 145 if closed else 135, at(-50, -45, -15)).cut(bottle())


@pytest.mark.parametrize("closed", [False, True])
def test_a_block_of_one_solid_is_not_taken_for_a_container(tmp_path, closed):
    with pytest.raises(InputError, match="block=True"):
        mold_from_shape(single_block(closed), "block")
    path = tmp_path / "block.brep"
    single_block(closed).exportBrep(str(path))
    found = inspect(path)
    assert "block=True" in " ".join([*found["faults"], *found["notes"]])
    assert (found["axis"] is None) == closed
    found = inspect(path, block=True)
    assert found["faults"] == []
    assert found["notes"][0].startswith("the mold is the void in its solid;")


def test_several_solids_that_look_like_a_block_are_said_to_be_one():
    with pytest.raises(InputError, match="look like a mold block"):
        mold_from_shape(Part.Compound(parts_of_a_blow_mold()), "block")


def test_a_container_does_not_look_like_a_block():
    outside, inside = Part.makeCylinder(30, 90), Part.makeCylinder(24, 90, at(0, 0, 12))
    assert not looks_like_block(outside.cut(inside))


def test_two_containers_side_by_side_are_no_block():
    assert not looks_like_block(Part.Compound([bottle(), bottle().translated(at(80, 0, 0))]))
    assert not looks_like_block(bottle())


@pytest.mark.parametrize(
    ("name", "height_mm", "finish_radius_mm"), [("pp_mould_cup.step", 83, 37.4), ("pp_mould_bowl.step", 51, 98)]
)
def test_a_real_mold_set_gives_its_container(name, height_mm, finish_radius_mm):
    path = SETS / name
    if not path.exists():
        pytest.skip("the real mold sets are not beside this checkout")
    mold = read_mold(path, block=True)
    assert mold.solid.isValid()
    assert mold.anatomy.axis == pytest.approx([0, 1, 0], abs=1e-9)
    assert mold.anatomy.height_mm == pytest.approx(height_mm, abs=1e-3)
    assert mold.anatomy.finish_outer_radius_mm == pytest.approx(finish_radius_mm, abs=0.02)
    assert "core" in mold.repairs[0]
