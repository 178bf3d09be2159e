"""The wall measured in space: against walls that are known, and against the meridian's own measure."""

from pathlib import Path

import numpy as np
import pytest
from measure_meridian import measure_revolved

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import mold_from_shape, read_mold
from glassworkbench.mold.tessellation import tessellate
from glassworkbench.wall.asking.thickness_text import parse_thickness
from glassworkbench.wall.measuring.measure import measure_wall, points_on_wall, wall_at
from glassworkbench.wall.measuring.outside import outside
from glassworkbench.wall.methods.revolved import offset_meridian
from glassworkbench.wall.solids import revolved_solid
from glassworkbench.wall.turning.profile import wall_meridian

EXAMPLES = Path(__file__).resolve().parent.parent / "examples" / "molds"


def uniform(thickness_mm):
    return lambda points, faces: np.full(len(points), thickness_mm)


def cylinder(radius, low, high, x=0.0):
    return Part.makeCylinder(radius, high - low, FreeCAD.Vector(x, 0, low))


@pytest.fixture(scope="module")
def can():
    return mold_from_shape(cylinder(30, 0, 100), "can", up=(0, 0, 1))


def inside_of(*shapes):
    body = shapes[0]
    for shape in shapes[1:]:
        body = body.fuse(shape)
    return tessellate(body.removeSplitter(), 0.05)


def test_a_wall_as_asked_has_no_deviation(can):
    found = measure_wall(inside_of(cylinder(27, 3, 100)), outside(can, uniform(3.0)))
    assert found.deviation_max_mm < 1e-3
    assert found.minimum_mm == pytest.approx(3.0, abs=1e-3)
    assert found.thinner_than_asked_max < 1e-3
    assert 2000 <= found.samples <= 3000


def test_a_cavity_beside_the_axis_is_too_thin_on_one_side_and_too_thick_on_the_other(can):
    wall = outside(can, uniform(3.0))
    inside = inside_of(cylinder(27, 3, 100, x=0.5))
    found = measure_wall(inside, wall)
    assert found.minimum_mm == pytest.approx(2.5, abs=0.01)
    assert found.minimum_at_mm[0] == pytest.approx(27.5, abs=0.05)
    assert found.deviation_max_mm == pytest.approx(0.5, abs=0.01)
    assert found.thinner_than_asked_max == pytest.approx(0.5 / 3.0, abs=0.005)
    deviation = wall_at(points_on_wall(inside, 2000), wall).deviation_mm
    assert deviation.min() == pytest.approx(-0.5, abs=0.01)
    assert deviation.max() == pytest.approx(0.5, abs=0.01)


def test_behind_embossing_a_smooth_inside_is_no_deviation_but_a_thin_wall_is():
    plate = Part.makeBox(12, 12, 12, FreeCAD.Vector(20, -6, 44)).common(cylinder(31.5, 0, 100))
    mold = mold_from_shape(cylinder(30, 0, 100).fuse(plate).removeSplitter(), "can", up=(0, 0, 1))
    wall = outside(mold, uniform(3.0))
    smooth = measure_wall(inside_of(cylinder(27, 3, 100)), wall, samples=8000)
    assert smooth.deviation_max_mm < 0.01
    # A dent behind the plate reaches too near to it.
    dent = Part.makeBox(6, 6, 6, FreeCAD.Vector(25, -3, 47)).common(cylinder(29, 0, 100))
    dented = measure_wall(inside_of(cylinder(27, 3, 100), dent), wall, samples=8000)
    assert dented.minimum_mm < 3.0
    assert dented.thinner_than_asked_max > 0.05


def test_a_thin_place_between_the_samples_is_found_from_either_side(can):
    wall = outside(can, uniform(3.0))
    pin = Part.makeBox(28, 0.2, 0.2, FreeCAD.Vector(0, -0.1, 50))
    inside = inside_of(cylinder(27, 3, 100), pin)
    assert measure_wall(inside, wall, samples=50).minimum_mm == pytest.approx(2.0, abs=1e-3)
    # A notch of the outside comes near to a smooth inside, far from its vertices.
    notched = cylinder(30, 0, 100).cut(Part.makeBox(2, 0.2, 0.2, FreeCAD.Vector(29, -0.1, 50)))
    wall = outside(mold_from_shape(notched, "can", up=(0, 0, 1)), uniform(3.0))
    found = measure_wall(inside_of(cylinder(27, 3, 100)), wall, samples=50)
    assert found.minimum_mm == pytest.approx(2.0, abs=1e-3)
    assert found.thinner_than_asked_max == pytest.approx(1.0 / 3.0, abs=1e-3)
    assert found.minimum_at_mm[2] == pytest.approx(50.1, abs=0.15)


@pytest.mark.parametrize(("name", "spec"), [("wine_glass", "2"), ("beer_bottle", "0:5 40:2 230:3")])
def test_in_space_a_turned_cavity_measures_as_in_its_meridian(name, spec):
    mold = read_mold(EXAMPLES / f"{name}.step")
    thickness = parse_thickness(spec).over_height(mold.anatomy)
    meridian = wall_meridian(mold.core, mold.anatomy, thickness)
    cavity = offset_meridian(meridian, thickness)
    exact = measure_revolved(meridian, cavity.segments, thickness)
    wall = outside(mold, lambda points, _: thickness.at(points[:, 2]), 0.02)
    inside = tessellate(revolved_solid(cavity), 0.02)
    found = measure_wall(inside, wall, stem_top_mm=mold.anatomy.stem_top_mm)
    assert found.minimum_mm == pytest.approx(exact.minimum_mm, abs=0.02)
    assert found.deviation_rms_mm == pytest.approx(exact.deviation_rms_mm, abs=2e-3)
    assert found.deviation_p99_mm == pytest.approx(exact.deviation_p99_mm, abs=0.01)


def test_a_cavity_within_the_lip_cannot_be_measured(can):
    with pytest.raises(GlassWorkbenchError, match="below the lip"):
        measure_wall(inside_of(cylinder(20, 99, 100)), outside(can, uniform(3.0)))
