"""Volumes, areas, levels and centres of gravity against closed forms, and against OCC's."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import read_mold
from glassworkbench.mold.tessellation import tessellate
from glassworkbench.scene import Mesh
from glassworkbench.wall.measuring.contents import Cavity, centre_of_gravity, weight_g
from glassworkbench.wall.measuring.surface import surface_area
from glassworkbench.wall.measuring.volumes import Volume, mesh_volume, volume_below

EXAMPLES = Path(__file__).resolve().parent.parent / "examples" / "molds"


def mesh_of(shape, deviation=0.05):
    return tessellate(shape, deviation)


@pytest.fixture(scope="module")
def cylinder():
    return mesh_of(Part.makeCylinder(20, 60))


@pytest.fixture(scope="module")
def sphere():
    return mesh_of(Part.makeSphere(20, FreeCAD.Vector(0, 0, 20)))


SHAPES = {
    "cylinder": (lambda: Part.makeCylinder(20, 60), np.pi * 20**2 * 60, 30.0, 2 * np.pi * 20 * 80),
    "cone": (
        lambda: Part.makeCone(20, 0, 60),
        np.pi * 20**2 * 60 / 3,
        15.0,
        np.pi * 20 * (20 + np.hypot(20, 60)),
    ),
    "sphere": (lambda: Part.makeSphere(20), 4 / 3 * np.pi * 20**3, 0.0, 4 * np.pi * 20**2),
    "torus": (lambda: Part.makeTorus(20, 6), 2 * np.pi**2 * 20 * 6**2, 0.0, 4 * np.pi**2 * 20 * 6),
}


@pytest.mark.parametrize("name", SHAPES)
def test_volume_centroid_and_area_are_those_of_the_formula(name):
    make, volume, height, area = SHAPES[name]
    mesh = mesh_of(make())
    found = mesh_volume(mesh)
    assert found.volume_mm3 == pytest.approx(volume, rel=2e-5)
    assert found.centroid_mm == pytest.approx([0, 0, height], abs=2e-3)
    assert surface_area(mesh) == pytest.approx(area, rel=1e-3)


@pytest.mark.parametrize("level", [0.0, 1.0, 17.3, 30.0, 59.0, 60.0])
def test_a_cylinder_holds_its_cross_section_times_the_level(cylinder, level):
    found = volume_below(cylinder, level)
    assert found.volume_mm3 == pytest.approx(np.pi * 20**2 * level, rel=3e-5, abs=1e-6)
    assert found.centroid_mm[2] == pytest.approx(level / 2, abs=2e-3)


@pytest.mark.parametrize("level", [0.5, 8.0, 20.0, 33.0, 39.5])
def test_a_sphere_holds_the_cap_below_the_level(sphere, level):
    found = volume_below(sphere, level)
    cap = np.pi * level**2 * (60 - level) / 3
    # z dV of the cap: pi int_0^h z (40 z - z^2) dz.
    moment = np.pi * (40 * level**3 / 3 - level**4 / 4)
    assert found.volume_mm3 == pytest.approx(cap, rel=2e-3 if level < 1 else 1e-4)
    assert found.centroid_mm[2] == pytest.approx(moment / cap, abs=3e-3)


def test_a_tilted_block_is_cut_exactly():
    box = Part.makeBox(10, 20, 30)
    box.Placement = FreeCAD.Placement(FreeCAD.Vector(1, 2, 3), FreeCAD.Rotation(FreeCAD.Vector(1, 2, 0.5), 37))
    mesh = mesh_of(box)
    level = float(mesh.vertices_mm[:, 2].mean()) + 4.0
    lower = box.common(Part.makeBox(400, 400, 200 + level, FreeCAD.Vector(-200, -200, -200)))
    found = volume_below(mesh, level)
    assert found.volume_mm3 == pytest.approx(lower.Volume, rel=1e-9)
    assert found.centroid_mm == pytest.approx(tuple(lower.Solids[0].CenterOfMass), abs=1e-7)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.02, 0.999))
def test_the_level_is_the_inverse_of_the_capacity(share):
    cavity = Cavity(_cone())
    wanted = share * 1e-3 * cavity.brimful().volume_mm3
    level = cavity.level_mm(wanted)
    assert cavity.capacity_ml(level) == pytest.approx(wanted, rel=1e-6)
    assert level == pytest.approx(60.0 * share ** (1 / 3), abs=5e-3)


def _cone():
    """A funnel, its tip down, of the exact normals."""
    angle = np.linspace(0, 2 * np.pi, 120, endpoint=False)
    rim = np.column_stack([20 * np.cos(angle), 20 * np.sin(angle), np.full(120, 60.0)])
    out = np.column_stack([60 * np.cos(angle), 60 * np.sin(angle), np.full(120, -20.0)]) / np.hypot(60, 20)
    k, after = np.arange(120), (np.arange(120) + 1) % 120
    tips = np.tile([0.0, 0.0, 0.0], (120, 1))
    middle = out + np.roll(out, -1, axis=0)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    vertices = np.concatenate([rim, tips, rim, [[0, 0, 60.0]]])
    normals = np.concatenate([out, middle, np.tile([0, 0, 1.0], (121, 1))])
    side = np.column_stack([k, 120 + k, after])
    lid = np.column_stack([240 + k, 240 + after, np.full(120, 360)])
    return Mesh(vertices, np.concatenate([side, lid]), normals)


def test_levels_and_quantities_that_cannot_be_are_refused(sphere):
    cavity = Cavity(sphere)
    for level in (-1.0, 41.0, float("nan")):
        with pytest.raises(InputError, match="fill level"):
            cavity.capacity_ml(level)
    with pytest.raises(InputError, match="more than"):
        cavity.level_mm(34.0)
    with pytest.raises(InputError, match="capacity_ml"):
        cavity.level_mm(-1.0)


def test_a_glass_with_liquid_balances_between_the_two():
    glass, liquid = Volume(1000.0, np.array([0.0, 0.0, 10.0])), Volume(2000.0, np.array([1.0, 0.0, 40.0]))
    assert weight_g(glass.volume_mm3) == pytest.approx(2.5)
    assert weight_g(glass.volume_mm3, 2.4) == pytest.approx(2.4)
    assert centre_of_gravity(glass, liquid) == pytest.approx([2.0 / 4.5, 0.0, (25.0 + 80.0) / 4.5])
    assert centre_of_gravity(glass, liquid, 2.0, 0.5) == pytest.approx([1 / 3, 0, 20.0])


@pytest.mark.parametrize("name", ["whisky_flask", "perfume_flacon"])
def test_real_molds_have_the_volume_and_area_that_occ_integrates(name):
    upright = read_mold(EXAMPLES / f"{name}.step").upright
    mesh = mesh_of(upright)
    assert mesh_volume(mesh).volume_mm3 == pytest.approx(upright.Volume, rel=2e-4)
    assert surface_area(mesh) == pytest.approx(upright.Area, rel=5e-4)


def test_where_occ_gets_the_volume_of_a_long_turned_face_wrong_the_mesh_does_not():
    height = np.linspace(0, 300, 60)
    side = Part.BSplineCurve()
    side.interpolate([FreeCAD.Vector(30 + 8 * np.sin(z / 9), 0, z) for z in height])
    top, bottom = side.EndPoint, side.StartPoint
    axis = FreeCAD.Vector(0, 0, 300), FreeCAD.Vector()
    edges = [side.toShape(), Part.makeLine(top, axis[0]), Part.makeLine(*axis), Part.makeLine(axis[1], bottom)]
    solid = Part.Face(Part.Wire(edges)).revolve(FreeCAD.Vector(), FreeCAD.Vector(0, 0, 1), 360)
    points = np.array([tuple(side.value(u)) for u in np.linspace(side.FirstParameter, side.LastParameter, 20001)])
    exact = np.trapz(np.pi * points[:, 0] ** 2, points[:, 2])
    assert mesh_volume(mesh_of(solid)).volume_mm3 == pytest.approx(exact, rel=1e-4)
    assert solid.isValid()
    assert abs(solid.Volume / exact - 1.0) > 5e-3
