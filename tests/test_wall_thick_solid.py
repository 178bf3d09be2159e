import numpy as np
import pytest

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.wall.methods import thick_solid as method
from glassworkbench.wall.methods.thick_solid import thick_wall, thick_wall_per_face
from glassworkbench.wall.offsetting.healing import has_kinks, healed
from glassworkbench.wall.offsetting.offset_check import check_offset, facets, facets_volume
from glassworkbench.wall.offsetting.offset_ways import WAYS, cavity_past_mouth
from glassworkbench.wall.offsetting.zones import zones_over_height

HEIGHT, HALF, CORNER = 100.0, 30.0, 10.0


@pytest.fixture(scope="module")
def square():
    """Return an upright solid 60 x 60 x 100 with upright edges rounded by 10."""
    box = Part.makeBox(2 * HALF, 2 * HALF, HEIGHT, FreeCAD.Vector(-HALF, -HALF, 0))
    upright = [edge for edge in box.Edges if abs(edge.tangentAt(edge.FirstParameter).z) > 0.5]
    return box.makeFillet(CORNER, upright)


def finish_of(solid):
    return 1 + max(range(len(solid.Faces)), key=lambda number: solid.Faces[number].CenterOfMass.z)


def section_area(wall):
    return (2 * (HALF - wall)) ** 2 - (4 - np.pi) * (CORNER - wall) ** 2


def volume_of(shape):
    return facets_volume(facets(shape, 0.005))


def kinked():
    """Return a solid whose side is one surface with a kink at half its height."""
    square = [(-20, -20), (20, -20), (20, 20), (-20, 20), (-20, -20)]
    rows = [[FreeCAD.Vector(k * x, k * y, z) for x, y in square] for k, z in ((1.0, 0), (1.3, 30), (0.8, 60))]
    surface = Part.BSplineSurface()
    surface.buildFromPolesMultsKnots(rows, [2, 1, 2], [2, 1, 1, 1, 2], [0, 1, 2], [0, 1, 2, 3, 4], False, False, 1, 1)
    side = surface.toShape()
    ends = [
        Part.Face(Part.Wire([edge for edge in side.Edges if all(abs(v.Z - z) < 1e-6 for v in edge.Vertexes)]))
        for z in (0, 60)
    ]
    shell = Part.Shell([side, *ends])
    shell.sewShape(1e-6)
    return Part.Solid(shell)


def test_kinks_inside_a_face_become_edges_and_the_form_stays():
    solid = kinked()
    assert has_kinks(solid)
    whole = healed(solid)
    assert not has_kinks(whole)
    assert len(whole.Faces) > len(solid.Faces)
    assert whole.isValid()
    # Two frusta of pyramids, of sides 40, 52 and 32, each 30 high.
    expected = 10 * (40**2 + 40 * 52 + 52**2) + 10 * (52**2 + 52 * 32 + 32**2)
    assert volume_of(whole) == pytest.approx(expected, rel=1e-9)


def test_a_solid_without_kinks_is_left_alone(square):
    assert healed(square) is square


@pytest.mark.parametrize("name", [name for name in WAYS if name != "rounded lip"])
def test_each_way_leaves_the_wall_asked_in_a_plain_solid(square, name):
    past_mouth = cavity_past_mouth(square, finish_of(square), 4.0, WAYS[name])
    corners = facets(past_mouth, 0.01)
    expected = section_area(4.0) * (corners[:, :, 2].max() - 4.0)
    assert corners[:, :, 2].min() == pytest.approx(4.0, abs=1e-6)
    assert facets_volume(corners) == pytest.approx(expected, rel=1e-4)


def test_a_heel_tighter_than_the_wall_gets_a_level_floor():
    cylinder = Part.makeCylinder(30, 80)
    heel = min(cylinder.Edges, key=lambda edge: edge.CenterOfMass.z)
    rounded = cylinder.makeFillet(2.0, [heel])
    past_mouth = cavity_past_mouth(rounded, finish_of(rounded), 5.0, WAYS["level floor"])
    corners = facets(past_mouth, 0.005)
    assert corners[:, :, 2].min() == pytest.approx(5.0, abs=1e-6)
    assert facets_volume(corners) == pytest.approx(np.pi * 25**2 * (corners[:, :, 2].max() - 5.0), rel=2e-3)


@pytest.mark.parametrize(
    ("cavity", "why"),
    [
        (Part.makeBox(52, 52, 96, FreeCAD.Vector(-25.5, -26, 4)), "not what was asked"),
        (Part.makeBox(52, 52, 60, FreeCAD.Vector(-26, -26, 40)), "leaves out|not what was asked"),
        (Part.makeBox(52, 26, 96, FreeCAD.Vector(-26, -26, 4)), "leaves out|not what was asked"),
    ],
    ids=["shifted", "cut short", "half"],
)
def test_a_valid_cavity_that_is_no_offset_is_refused(cavity, why):
    outer = Part.makeBox(60, 60, 100, FreeCAD.Vector(-30, -30, 0))
    check_offset(outer, Part.makeBox(52, 52, 96, FreeCAD.Vector(-26, -26, 4)), 100.0, 4.0, 5.0)
    with pytest.raises(GlassWorkbenchError, match=why):
        check_offset(outer, cavity, 100.0, 4.0, 5.0)


def test_a_cavity_with_a_bubble_of_glass_is_refused():
    outer = Part.makeBox(60, 60, 100, FreeCAD.Vector(-30, -30, 0))
    cavity = Part.makeBox(52, 52, 96, FreeCAD.Vector(-26, -26, 4)).cut(Part.makeSphere(15, FreeCAD.Vector(0, 0, 50)))
    with pytest.raises(GlassWorkbenchError, match=r"not what was asked|must be"):
        check_offset(outer, cavity, 100.0, 4.0, 5.0)


def test_a_uniform_wall_is_one_zone(square):
    made = thick_wall(square, finish_of(square), [(0.0, HEIGHT, 4.0)])
    assert made.tries[-1].endswith("good")
    assert made.solid.isValid()
    assert volume_of(made.cavity) == pytest.approx(section_area(4.0) * (HEIGHT - 4.0), rel=1e-3)
    assert volume_of(made.solid) == pytest.approx(volume_of(square) - volume_of(made.cavity), rel=1e-3)
    assert facets(made.past_mouth, 0.1)[:, :, 2].max() > HEIGHT + 1.0


def test_zones_and_a_bore_have_the_volumes_of_their_formulas(square):
    zones = [(0.0, 6.0, 6.0), (6.0, 60.0, 2.0), (60.0, 90.0, 4.0), (90.0, HEIGHT, 4.0)]
    made = thick_wall(square, finish_of(square), zones, bore_mm=30.0)
    expected = section_area(2.0) * 54.0 + section_area(4.0) * 30.0 + np.pi * 15.0**2 * 10.0
    assert volume_of(made.cavity) == pytest.approx(expected, rel=1e-3)
    assert volume_of(made.solid) == pytest.approx(volume_of(square) - expected, rel=1e-3)
    assert made.solid.isValid()
    assert len(made.solid.Solids) == 1


def test_below_the_first_zone_all_is_glass(square):
    made = thick_wall(square, finish_of(square), [(40.0, HEIGHT, 3.0)])
    assert volume_of(made.cavity) == pytest.approx(section_area(3.0) * 60.0, rel=1e-3)


def test_a_stem_thinner_than_two_walls_stays_full():
    stem, bowl = Part.makeCylinder(3, 40), Part.makeCylinder(30, 60, FreeCAD.Vector(0, 0, 40))
    solid = stem.fuse(bowl).Solids[0]
    made = thick_wall(solid, finish_of(solid), [(44.0, HEIGHT, 4.0)])
    assert volume_of(made.cavity) == pytest.approx(np.pi * 26**2 * 56, rel=1e-3)
    assert volume_of(made.solid) == pytest.approx(np.pi * (9 * 40 + 900 * 60 - 676 * 56), rel=2e-3)


def test_a_smooth_wall_becomes_a_stair_within_the_deviation():
    heights = np.linspace(0.0, 100.0, 401)
    asked = 3.0 + np.sin(heights / 20.0)
    zones = zones_over_height(heights, asked, 0.1)
    assert zones[0][0] == 0.0
    assert zones[-1][1] == 100.0
    for low, high, thickness in zones:
        within = asked[(heights >= low) & (heights <= high)]
        assert np.abs(within - thickness).max() <= 0.1 + 1e-12
    assert zones_over_height(heights, np.full(401, 2.0), 0.1) == [(0.0, 100.0, 2.0)]


@pytest.mark.parametrize(
    ("zones", "bore", "why"),
    [
        ([], None, "no zone"),
        ([(0, 50, 2), (60, 100, 2)], None, "next begins at 60"),
        ([(0, 90, 2)], None, "end at 90"),
        ([(0, 100, -2)], None, "correct it"),
        ([(0, 100, 2)], 61.0, "bore"),
    ],
)
def test_impossible_zones_are_refused(square, zones, bore, why):
    with pytest.raises(InputError, match=why):
        thick_wall(square, finish_of(square), zones, bore)


def test_a_way_that_hangs_leaves_time_for_the_others(square, monkeypatch):
    monkeypatch.setattr(method, "offset_solid", hang_unless_last)
    monkeypatch.setattr(method, "TRY_SHARE", 0.1)
    made = thick_wall(square, finish_of(square), [(0.0, HEIGHT, 4.0)], seconds=40.0)
    assert "did not finish" in made.tries[0]
    assert "crashed (SIGABRT)" in made.tries[1]
    assert made.tries[2].endswith("good")


def hang_unless_last(outer, finish_face, thickness_mm, ways, floor_mm):
    import os
    import time

    names = list(WAYS)
    if ways == names[:1]:
        time.sleep(600)
    if ways == names[1:2]:
        os.abort()
    return [outer, outer, outer]


def test_faces_across_sharp_edges_have_walls_of_their_own():
    box = Part.makeBox(60, 60, 100, FreeCAD.Vector(-30, -30, 0))
    numbers = {tuple(round(x) for x in face.normalAt(0, 0)): n for n, face in enumerate(box.Faces, start=1)}
    faces = [(numbers[0, 0, -1], 8.0), (numbers[1, 0, 0], 2.0), (numbers[0, 1, 0], 5.0)]
    made = thick_wall_per_face(box, finish_of(box), 3.0, faces)
    low, high = facets(made.cavity, 0.1).min(axis=(0, 1)), facets(made.cavity, 0.1).max(axis=(0, 1))
    assert low == pytest.approx([-27, -27, 8], abs=1e-5)
    assert high == pytest.approx([28, 25, 100], abs=1e-5)
    assert volume_of(made.solid) == pytest.approx(60 * 60 * 100 - 55 * 52 * 92, rel=1e-6)


def test_a_round_vessel_has_a_base_of_its_own():
    cylinder = Part.makeCylinder(30, 80)
    base = 1 + min(range(3), key=lambda number: cylinder.Faces[number].CenterOfMass.z)
    for thickness in (6.0, 1.5):
        made = thick_wall_per_face(cylinder, finish_of(cylinder), 3.0, [(base, thickness)])
        assert volume_of(made.cavity) == pytest.approx(np.pi * 27**2 * (80 - thickness), rel=1e-3)


def test_a_face_that_meets_its_neighbours_smoothly_is_refused(square):
    side = next(n for n, face in enumerate(square.Faces, start=1) if face.CenterOfMass.x < -HALF + 1e-6)
    with pytest.raises(InputError, match="smoothly"):
        thick_wall_per_face(square, finish_of(square), 3.0, [(side, 5.0)])
