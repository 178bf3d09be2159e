"""Defects made with the wall: the thickness asked has them, the mold is deformed, the measured wall shows it."""

import numpy as np
import pytest

from glassworkbench.cli import main
from glassworkbench.errors import InputError
from glassworkbench.flaws import ChokedNeck, Lean, Ovality, Seed, Slug, ThinSpot, Washboard, make_defect, with_defects
from glassworkbench.freecad import Part
from glassworkbench.mold import mold_from_shape
from glassworkbench.staging import sample_container, station
from glassworkbench.wall import GridThickness, TabulatedThickness, flawed_mold, flawed_thickness
from glassworkbench.wall.measuring.outside import outside
from glassworkbench.wall.turning.inner_meridian import offset_meridian
from glassworkbench.wall.turning.profile import wall_meridian

HEIGHT, RADIUS = 100.0, 30.0


@pytest.fixture(scope="module")
def can():
    return mold_from_shape(Part.makeCylinder(RADIUS, HEIGHT), "can", up=(0, 0, 1))


def asked(thickness, mold, height, angle_deg):
    turn = np.radians(angle_deg)
    point = np.array([[RADIUS * np.cos(turn), RADIUS * np.sin(turn), height]])
    return float(thickness.on(mold).at(point, np.zeros(1, dtype=int))[0])


def extent(mold):
    """How far a mold reaches along x, y and z: OCC's box is that of the surfaces' control points."""
    return np.ptp([tuple(point) for point in mold.upright.tessellate(0.02)[0]], axis=0)


def test_a_thin_spot_and_a_slug_are_a_table_over_height_and_angle(can):
    flaws = [
        ThinSpot(height_mm=50, angle_deg=40, loss_mm=0.7, length_mm=20, width_mm=15),
        Slug(height_mm=50, angle_deg=220, gain_mm=1.2),
    ]
    thickness = flawed_thickness(3, can, flaws)
    assert isinstance(thickness, GridThickness)
    assert asked(thickness, can, 50, 40) == pytest.approx(2.3, abs=1e-3)
    assert asked(thickness, can, 50, 220) == pytest.approx(4.2, abs=1e-3)
    assert asked(thickness, can, 61, 40) == pytest.approx(3.0, abs=1e-6)
    assert asked(thickness, can, 50, 130) == pytest.approx(3.0, abs=1e-6)
    # Half way out a bump has half its height.
    assert asked(thickness, can, 55, 40) == pytest.approx(2.65, abs=0.02)


def test_what_goes_all_around_stays_a_table_over_height(can):
    thickness = flawed_thickness("0:4 50:3 100:3", can, [ChokedNeck(height_mm=80), Washboard(height_mm=40)])
    assert isinstance(thickness, TabulatedThickness)
    assert asked(thickness, can, 80, 0) == pytest.approx(4.5, abs=1e-3)
    assert asked(thickness, can, 42.5, 0) < asked(thickness, can, 40, 0) > asked(thickness, can, 37.5, 0)
    assert asked(thickness, can, 0, 0) == pytest.approx(4.0, abs=1e-6)


def test_without_such_defects_wall_and_mold_are_as_they_were(can):
    assert str(flawed_thickness(3, can, [Seed(height_mm=50, angle_deg=0)])) == "3"
    assert flawed_mold(can, [ThinSpot(height_mm=50, angle_deg=0)]) is can


def test_the_outside_has_points_in_a_spot_between_its_corners(can):
    """The mesh of a cylinder has no vertex between its rims; ends and middles of its sides may lie beside a spot."""
    spot = ThinSpot(height_mm=62, angle_deg=100, loss_mm=1.0, length_mm=12, width_mm=10)
    wall = outside(can, flawed_thickness(3, can, [spot]).on(can).at)
    assert wall.thickness_mm.min() < 2.1
    waves = Washboard(height_mm=50, length_mm=30, pitch_mm=5, amplitude_mm=0.1)
    wall = outside(can, flawed_thickness(3, can, [waves]).on(can).at)
    assert wall.thickness_mm.min() < 2.92
    assert wall.thickness_mm.max() > 3.09


def test_the_cavity_has_a_choked_neck(can):
    thickness = flawed_thickness(3, can, [ChokedNeck(height_mm=70, gain_mm=2.0, length_mm=20)])
    over_height = thickness.over_height(can.anatomy)
    inner = offset_meridian(wall_meridian(can.core, can.anatomy, over_height), over_height)
    points = inner.segments[:, 0, :2]
    near = (points[:, 1] > 65) & (points[:, 1] < 75)
    assert points[near, 0].min() == pytest.approx(25.0, abs=0.02)
    beside = (points[:, 1] > 20) & (points[:, 1] < 55)
    np.testing.assert_allclose(points[beside, 0], 27.0, atol=0.01)


def test_a_mold_leans_by_the_angle(can):
    leaning = flawed_mold(can, [Lean(angle_deg=90, lean_deg=2)])
    x, y, _ = extent(leaning)
    assert y == pytest.approx(2 * RADIUS + HEIGHT * np.tan(np.radians(2)), abs=0.05)
    assert x == pytest.approx(2 * RADIUS, abs=0.05)
    assert not leaning.anatomy.is_revolved


def test_an_oval_mold_is_out_of_round_by_the_difference_of_its_diameters(can):
    x, y, z = extent(flawed_mold(can, [Ovality(angle_deg=0, out_of_round_mm=1.5)]))
    assert (x - y, x + y, z) == pytest.approx((1.5, 4 * RADIUS, HEIGHT), abs=0.05)


@pytest.mark.parametrize(
    ("wall", "flaw", "words"),
    [
        (2, ThinSpot(height_mm=50, angle_deg=0, loss_mm=2.5), "thin spot at 50 mm, 0 deg: it takes more than the wall"),
        (2, ChokedNeck(height_mm=150), "choked neck at 150 mm, 0 deg: it must lie between"),
        ("2 bore=50", ChokedNeck(height_mm=50), "a wall by face or with a bore cannot have it"),
        ("Face1=3 else=2", Slug(height_mm=50, angle_deg=0), "a wall by face or with a bore cannot have it"),
    ],
)
def test_what_no_wall_can_have_is_refused(can, wall, flaw, words):
    with pytest.raises(InputError, match=words):
        flawed_thickness(wall, can, [flaw])


def test_a_lean_beyond_reason_and_a_shape_too_oval_are_refused(can):
    with pytest.raises(InputError, match="lean: lean_deg: must be at most 20"):
        Lean(angle_deg=0, lean_deg=50)
    with pytest.raises(InputError, match="ovality at 0 deg: 40 mm is too much"):
        flawed_mold(can, [Ovality(angle_deg=0, out_of_round_mm=40)])


def test_a_lean_needs_no_height_in_a_file():
    assert make_defect({"kind": "lean", "angle_deg": 5}) == Lean(angle_deg=5)
    with pytest.raises(InputError, match="'height_mm'"):
        make_defect({"kind": "lean", "angle_deg": 5, "height_mm": 3})


def test_a_scene_tells_what_its_wall_has_but_adds_no_body_for_it():
    geometry = sample_container()
    scene = with_defects(station("sidewall", geometry, "flint"), geometry, [Lean(angle_deg=0)])
    assert [body.name for body in scene.bodies] == ["outer", "cavity"]
    assert scene.metadata["defects"] == "lean at 0 deg (major)"


@pytest.mark.parametrize(
    ("verb", "kind", "words"),
    [
        (["hollow", "--wall", "3", "-o", "{folder}/x.step"], "seed", "lies in the glass, not in the wall's shape"),
        (["render", "-o", "{folder}/x.png"], "thin spot", "it is made with the wall; give --wall, too"),
    ],
)
def test_the_command_line_says_where_a_defect_belongs(tmp_path, capsys, verb, kind, words):
    container = tmp_path / "can.step"
    tube = Part.makeCylinder(RADIUS, HEIGHT).cut(Part.makeCylinder(RADIUS - 3, HEIGHT, Part.Vertex(0, 0, 3).Point))
    (tube if verb[0] == "render" else Part.makeCylinder(RADIUS, HEIGHT)).exportStep(str(container))
    listed = tmp_path / "d.toml"
    listed.write_text(f'[[defect]]\nkind = "{kind}"\nheight_mm = 50\nangle_deg = 0\n')
    arguments = [word.replace("{folder}", str(tmp_path)) for word in verb]
    assert main([arguments[0], str(container), *arguments[1:], "--defects", str(listed)]) == 2
    assert words in capsys.readouterr().err
