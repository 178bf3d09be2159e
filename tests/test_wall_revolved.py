import itertools
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from measure_meridian import measure_revolved

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.mold import read_mold, tessellate
from glassworkbench.scene import Revolved
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.asking.bore import Bore
from glassworkbench.wall.asking.thickness_text import parse_thickness
from glassworkbench.wall.measuring.outside import outside
from glassworkbench.wall.measuring.volumes import mesh_volume, revolved_volume
from glassworkbench.wall.methods.revolved import revolved
from glassworkbench.wall.turning.along_meridian import AlongMeridian
from glassworkbench.wall.turning.bezier import crossings, evaluate, fit_cubic, line, polyline, unit
from glassworkbench.wall.turning.inner_meridian import offset_meridian
from glassworkbench.wall.turning.profile import wall_meridian
from glassworkbench.wall.turning.turned_mesh import turned_mesh
from glassworkbench.wall.turning.unfolding import clearance


def arc(centre, radius, start_deg, end_deg):
    """Return an exact circular arc of at most a right angle as one rational cubic (4, 3)."""
    start, end = np.radians([start_deg, end_deg])
    half = 0.5 * (end - start)
    weight = np.cos(half)
    ends = [np.add(centre, radius * np.array([np.cos(a), np.sin(a)])) for a in (start, end)]
    middle = np.add(centre, radius / weight * np.array([np.cos(start + half), np.sin(start + half)]))
    inner = (1.0 + 2.0 * weight) / 3.0
    handles = [(point + 2.0 * weight * middle) / (3.0 * inner) for point in ends]
    return np.column_stack([[ends[0], *handles, ends[1]], [1.0, inner, inner, 1.0]])


def lines(*points):
    return np.array([line(a, b) for a, b in itertools.pairwise(points)])


def cubic(*points):
    return np.column_stack([np.array(points, dtype=float), np.ones(4)])


def hollowed(outer, height, wall, stem_top=0.0, regions=None):
    anatomy = SimpleNamespace(finish_height_mm=height, stem_top_mm=stem_top, regions=regions or {})
    thickness = parse_thickness(wall).over_height(anatomy)
    profile = wall_meridian(outer, anatomy, thickness)
    return profile, offset_meridian(profile, thickness), thickness


def bottle(push_up=20.0, heel=6.0, radius=38.0, body=180.0, neck=14.0):
    """Return a bottle with a push-up, a rounded heel, a shoulder and a lip rounded by 1 mm; height 300."""
    return np.array(
        [
            cubic((0, push_up), (9, push_up), (0.7 * radius - 12, 0), (0.7 * radius, 0)),
            line((0.7 * radius, 0), (radius - heel, 0)),
            arc((radius - heel, heel), heel, -90, 0),
            line((radius, heel), (radius, body)),
            cubic((radius, body), (radius, body + 30), (neck, body + 20), (neck, 250)),
            line((neck, 250), (neck, 299)),
            arc((neck - 1, 299), 1.0, 0, 90),
            line((neck - 1, 300), (0, 300)),
        ]
    )


def least_gap(chain, points, asked=lambda height: 0.0):
    """Return min over the chain of |p - s| - asked(s) for each point: a grid search, refined twice."""
    best = np.full(len(points), np.inf)
    for segment in chain:
        u = np.broadcast_to(np.linspace(0, 1, 201), (len(points), 201))
        for _ in range(3):
            feet = evaluate(segment, u.ravel())[0].reshape(*u.shape, 2)
            gap = np.linalg.norm(points[:, None] - feet, axis=2) - asked(feet[:, :, 1])
            nearest = gap.argmin(axis=1)
            best = np.minimum(best, gap.min(axis=1))
            row = np.arange(len(points))
            low, high = u[row, np.maximum(nearest - 1, 0)], u[row, np.minimum(nearest + 1, u.shape[1] - 1)]
            u = low[:, None] + np.linspace(0, 1, 41) * (high - low)[:, None]
    return best


def test_a_cylinder_becomes_a_cylinder():
    outer = lines((0, 0), (20, 0), (20, 100), (0, 100))
    _, cavity, _ = hollowed(outer, 100.0, "3")
    volume = revolved_volume(cavity.segments)
    assert volume.volume_mm3 == pytest.approx(np.pi * 17**2 * 97, rel=1e-12)
    assert volume.centroid_mm[2] == pytest.approx(51.5, rel=1e-12)
    glass = revolved_volume(outer).minus(volume)
    assert glass.volume_mm3 == pytest.approx(np.pi * (20**2 * 100 - 17**2 * 97), rel=1e-12)


def test_a_round_end_keeps_its_centre():
    outer = np.array([arc((0, 25), 25, -90, 0), line((25, 25), (25, 80)), line((25, 80), (0, 80))])
    _, cavity, _ = hollowed(outer, 80.0, "4")
    expected = 2 / 3 * np.pi * 21**3 + np.pi * 21**2 * 55
    assert revolved_volume(cavity.segments).volume_mm3 == pytest.approx(expected, rel=1e-5)
    bottom = polyline(cavity.segments, 50)
    bottom = bottom[bottom[:, 1] < 25]
    assert np.abs(np.hypot(bottom[:, 0], bottom[:, 1] - 25) - 21).max() < 4e-4


def test_a_thickness_that_grows_along_a_straight_wall_tilts_the_inside_by_its_arc_sine():
    outer = lines((0, 0), (30, 0), (30, 200), (0, 200))
    _, cavity, _ = hollowed(outer, 200.0, "0:2 200:12")
    growth = 10 / 200
    points = polyline(cavity.segments, 20)
    wall = points[(points[:, 1] > 10) & (points[:, 1] < 199.9)]
    # The common tangent of circles with radii 2 + growth z centred on the wall.
    radial = 30 - (2 + growth * wall[:, 1]) / np.sqrt(1 - growth**2)
    assert np.abs(wall[:, 0] - radial).max() < 4e-4


def test_a_cone_with_growing_thickness_has_a_conical_inside():
    outer = lines((0, 0), (20, 0), (50, 150), (0, 150))
    _, cavity, _ = hollowed(outer, 150.0, "0:2 150:5")
    tangent = np.array([30, 150]) / np.hypot(30, 150)
    normal = np.array([-tangent[1], tangent[0]])
    growth = 3 / 150 * tangent[1]
    direction = -growth * tangent + np.sqrt(1 - growth**2) * normal
    low, high = np.array([20, 0]) + 2 * direction, np.array([50, 150]) + 5 * direction
    points = polyline(cavity.segments, 20)
    wall = points[(points[:, 1] > 6) & (points[:, 1] < 149)]
    expected = low[0] + (wall[:, 1] - low[1]) * (high - low)[0] / (high - low)[1]
    assert np.abs(wall[:, 0] - expected).max() < 4e-4


def test_a_reentrant_corner_is_rounded_by_the_wall():
    outer = lines((0, 0), (30, 0), (30, 50), (20, 50), (20, 100), (0, 100))
    _, cavity, _ = hollowed(outer, 100.0, "4")
    points = polyline(cavity.segments, 50)
    corner = np.array([20, 50])
    near = points[np.linalg.norm(points - corner, axis=1) < 4.001]
    assert len(near) > 20
    assert np.abs(np.linalg.norm(near - corner, axis=1) - 4).max() < 4e-4


@pytest.mark.parametrize("wall", ["1", "3", "6", "9", "0:2 300:5", "0:6 30:2 300:3", "0:3 300:1 linear"])
def test_no_inner_point_is_nearer_to_an_outer_point_than_that_points_thickness(wall):
    profile, cavity, thickness = hollowed(bottle(), 300.0, wall)
    inside = polyline(cavity.segments[:-1], 8)
    inside = inside[inside[:, 1] < profile.lip[1] - thickness.maximum_mm]
    left = least_gap(profile.segments, inside, thickness.at)
    tolerance = 1.1 * max(cavity.fit_error_mm, 1e-4)
    assert cavity.fit_error_mm <= min(1e-3, 1e-4 * thickness.minimum_mm)
    assert left.min() > -tolerance
    assert left.max() < tolerance


@given(
    push_up=st.floats(2.0, 40.0),
    heel=st.floats(0.5, 12.0),
    radius=st.floats(25.0, 60.0),
    neck=st.floats(9.0, 20.0),
    wall=st.floats(0.3, 8.0),
)
@settings(deadline=None, max_examples=15, derandomize=True, phases=[Phase.explicit, Phase.generate])
def test_the_wall_is_what_was_asked_for_whatever_the_bottle(push_up, heel, radius, neck, wall):
    profile, cavity, thickness = hollowed(bottle(push_up, heel, radius, neck=neck), 300.0, str(wall))
    inside = polyline(cavity.segments[:-1], 5)
    inside = inside[inside[:, 1] < 299.0 - wall]
    assert np.abs(least_gap(profile.segments, inside) - wall).max() < 1e-3
    assert len(crossings(polyline(cavity.segments, 20))) == 0
    measure = measure_revolved(profile, cavity.segments, thickness)
    assert measure.deviation_p99_mm < 1e-3


def test_the_chain_is_closed_smooth_within_its_runs_and_free_of_crossings():
    _, cavity, _ = hollowed(bottle(), 300.0, "3")
    for chain in (cavity.segments, cavity.past_mouth):
        assert chain[0, 0, 0] == 0.0
        assert chain[-1, 3, 0] == 0.0
        assert np.array_equal(chain[1:, 0, :2], chain[:-1, 3, :2])
        Revolved(chain)
    for first, last in cavity.smooth_runs:
        run = cavity.segments[first:last]
        ends = unit(run[:-1, 3, :2] - run[:-1, 2, :2])
        starts = unit(run[1:, 1, :2] - run[1:, 0, :2])
        assert np.linalg.norm(ends - starts, axis=1).max(initial=0.0) < 1e-3
    assert cavity.fit_error_mm <= 3e-4


def test_the_cavity_for_the_tracer_is_the_same_below_the_mouth_and_clears_the_body_above():
    _, cavity, _ = hollowed(bottle(), 300.0, "3")
    below = polyline(cavity.past_mouth, 100)
    assert below[:, 1].max() == pytest.approx(305.0)
    inside = below[below[:, 1] < 299.9]
    assert least_gap(cavity.segments, inside[::20]).max() < 1e-3
    assert revolved_volume(cavity.past_mouth).volume_mm3 == pytest.approx(
        revolved_volume(cavity.segments).volume_mm3 + np.pi * 11**2 * 5, rel=1e-6
    )


def test_the_bore_runs_straight_through_the_rounding_of_the_lip():
    _, cavity, _ = hollowed(bottle(), 300.0, "3")
    mouth = cavity.segments[-1, 0]
    assert mouth[0] == pytest.approx(11.0, abs=1e-3)
    assert mouth[1] == pytest.approx(300.0, abs=1e-9)


@pytest.mark.parametrize("knot", [180.0, 180.0000004, 179.997, 180.003, 100.0])
def test_a_thickness_that_turns_at_or_beside_a_joint_of_the_outside_leaves_a_sharp_bend_inside(knot):
    wall = f"0:3.5 {knot}:2.4 300:3.6 linear"
    profile, cavity, thickness = hollowed(bottle(), 300.0, wall)
    points = polyline(cavity.segments[:-1], 16)
    near = points[np.abs(points[:, 1] - knot) < 2.0]
    assert np.all(np.diff(near[:, 1]) > 0.0)
    gap = least_gap(profile.segments, near, lambda height: thickness.at(height))
    assert np.abs(gap).max() < 2e-3


def test_a_convex_corner_stays_sharp_inside():
    _, cavity, _ = hollowed(lines((0, 0), (20, 0), (21, 60), (20, 100), (0, 100)), 100.0, "0.3")
    lower, upper = unit(np.array([[1.0, 60.0], [-1.0, 40.0]]))
    inward = unit(np.array([[-60.0, 1.0], [-40.0, -1.0]]))
    # Where the two lines, each moved inward by the wall, meet.
    moved = np.array([21.0, 60.0]) + 0.3 * inward
    along = np.linalg.solve(np.column_stack([lower, -upper]), moved[1] - moved[0])
    corner = moved[0] + along[0] * lower
    assert np.linalg.norm(cavity.segments[:, 0, :2] - corner, axis=1).min() < 1e-6


def test_a_lip_rounder_than_the_wall_keeps_half_the_wall_as_sealing_surface():
    outer = np.array(
        [line((0, 0), (30, 0)), line((30, 0), (30, 96)), arc((26, 96), 4.0, 0, 90), line((26, 100), (0, 100))]
    )
    _, cavity, _ = hollowed(outer, 100.0, "2")
    assert cavity.segments[-1, 0, 0] == pytest.approx(25.0, abs=1e-6)


def test_above_a_stem_the_bowl_has_a_round_floor_and_the_stem_stays_solid():
    outer = np.array(
        [
            line((0, 0), (35, 0)),
            line((35, 0), (35, 2)),
            cubic((35, 2), (12, 4), (4, 8), (4, 25)),
            line((4, 25), (4, 80)),
            cubic((4, 80), (4, 95), (42, 95), (43, 140)),
            line((43, 140), (40, 210)),
            line((40, 210), (0, 210)),
        ]
    )
    profile, cavity, thickness = hollowed(outer, 210.0, "2", stem_top=84.0)
    floor = cavity.segments[0]
    assert floor[0, 1] > 84.0
    assert floor[1, 1] == pytest.approx(floor[0, 1], abs=1e-9)
    assert np.all(np.diff(polyline(cavity.segments[:-1], 20)[:, 1]) > -1e-9)
    assert measure_revolved(profile, cavity.segments, thickness).deviation_max_mm < 2e-3


@pytest.mark.parametrize("wall", ["13.9", "20"])
def test_a_wall_that_closes_the_neck_is_refused_with_place_and_room(wall):
    outer = np.concatenate([bottle()[:-3], lines((14, 250), (12, 275), (14, 299), (0, 299))])
    with pytest.raises(InputError, match="fills the container at height") as caught:
        hollowed(outer, 299.0, wall)
    words = str(caught.value).split()
    height, fits = float(words[words.index("height") + 1]), float(words[words.index("than") + 1])
    assert 240.0 < height < 290.0
    assert 11.9 < fits < 12.1


def test_fitting_a_cubic_says_how_far_it_is_off():
    segment = cubic((0, 0), (2, 1), (4, 1.5), (6, 1.5))
    points, slopes = evaluate(segment, np.linspace(0, 1, 17))
    fitted, error = fit_cubic(points, *unit(slopes[[0, -1]]))
    assert error < 2e-3
    assert least_gap([fitted], points).max() == pytest.approx(error, abs=1e-5)


def test_crossings_finds_a_loop_and_passes_a_spiral():
    angle = np.linspace(0, 6 * np.pi, 500)
    spiral = (1 + angle)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    assert len(crossings(spiral)) == 0
    loop = np.array([(0, 0), (2, 2), (2, 0), (0, 2)], dtype=float)
    assert crossings(loop) == pytest.approx(np.array([[1.0, 1.0]]))


RINGED = np.array(
    [
        line((0, 0), (32, 0)),
        arc((32, 6), 6.0, -90, 0),
        line((38, 6), (38, 180)),
        cubic((38, 180), (38, 210), (14, 200), (14, 250)),
        line((14, 250), (14, 285)),
        line((14, 285), (16, 287)),
        line((16, 287), (16, 292)),
        line((16, 292), (14, 294)),
        line((14, 294), (14, 300)),
        line((14, 300), (0, 300)),
    ]
)
"""A bottle with a ring around its finish, which begins at 286 mm."""


def bored(diameter, wall="3", full_from=286.0, none_below=272.0):
    anatomy = SimpleNamespace(finish_height_mm=300.0, stem_top_mm=0.0, regions={})
    thickness = parse_thickness(wall).over_height(anatomy)
    profile = wall_meridian(RINGED, anatomy, thickness)
    return offset_meridian(profile, thickness, Bore(0.5 * diameter, full_from, none_below))


@pytest.mark.parametrize("diameter", [18.5, 22.0, 25.0])
def test_a_bore_is_a_cylinder_through_the_finish_whatever_its_rings(diameter):
    cavity = bored(diameter)
    for chain in (cavity.segments[:-1], cavity.past_mouth[:-1]):
        points = polyline(chain, 20)
        finish = points[points[:, 1] >= 286.0 - 1e-6]
        assert np.ptp(finish[:, 1]) >= 13.9
        assert np.abs(finish[:, 0] - 0.5 * diameter).max() < 1e-6


@pytest.mark.parametrize("diameter", [18.5, 22.0, 25.0])
def test_below_a_bore_the_inside_leads_smoothly_to_the_wall_that_was_asked(diameter):
    cavity = bored(diameter)
    points = polyline(cavity.segments[:-1], 50)
    blend = points[(points[:, 1] > 255.0) & (points[:, 1] < 288.0)]
    steps = np.diff(blend, axis=0)
    turns = np.diff(np.arctan2(steps[:, 0], steps[:, 1]))
    assert np.abs(turns).max() < 0.01
    assert np.all(steps[:, 1] > 0.0)
    straight = blend[blend[:, 1] < 268.0]
    assert np.abs(straight[:, 0] - 11.0).max() < 1e-4


def test_the_glass_around_a_bore_keeps_what_is_asked_of_every_outer_point():
    cavity, bore = bored(18.5), Bore(9.25, 286.0, 272.0)
    outside = polyline(RINGED[:-1], 4000)
    inside = polyline(cavity.segments[:-1], 10)
    asked = bore.thickness(outside[:, 0], outside[:, 1], np.full(len(outside), 3.0))
    assert np.abs(clearance(inside, outside, asked)).max() < 2e-3


def test_a_bore_that_nothing_smooth_leads_to_is_refused():
    with pytest.raises(InputError, match=r"wall bore: .* too far from the 22\.00 mm"):
        bored(2.0)


def test_clearance_by_groups_is_that_of_every_pair():
    rng = np.random.default_rng(7)
    feet = np.cumsum(rng.normal(size=(333, 2)), axis=0)
    points = np.cumsum(rng.normal(size=(205, 2)), axis=0)
    asked = rng.uniform(0.0, 3.0, 333)
    pairs = np.linalg.norm(points[:, None] - feet, axis=2) - asked
    assert clearance(points, feet, asked) == pytest.approx(pairs.min(axis=1), abs=1e-12)


def test_the_mesh_of_a_meridian_holds_its_volume_and_lies_on_it():
    _, cavity, _ = hollowed(bottle(), 300.0, "3")
    mesh = turned_mesh(cavity.segments, cavity.smooth_runs, 0.02)
    assert mesh_volume(mesh).volume_mm3 == pytest.approx(revolved_volume(cavity.segments).volume_mm3, rel=1e-5)
    flat = np.column_stack([np.hypot(mesh.vertices_mm[:, 0], mesh.vertices_mm[:, 1]), mesh.vertices_mm[:, 2]])
    assert np.abs(least_gap(cavity.segments, flat[::97])).max() < 2e-3
    assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(1.0, abs=1e-12)
    assert mesh.vertices_mm[:, 2].max() == 300.0


@pytest.fixture(scope="module")
def beer_bottle():
    return read_mold(Path(__file__).resolve().parent.parent / "examples" / "molds" / "beer_bottle.step")


def wall_of(mold, bore=None):
    along = AlongMeridian(parse_thickness("3").over_height(mold.anatomy), bore)

    def at(points, faces):
        return along.at(np.column_stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]]))

    return AskedThickness(at, 3.0, 3.0, along.over_height, bore), outside(mold, at, 0.2)


@pytest.fixture(scope="module")
def beer_wall(beer_bottle):
    return wall_of(beer_bottle)


def test_the_method_hands_over_a_sound_solid_the_cavity_past_the_mouth_and_the_inside(beer_bottle, beer_wall):
    asked, outer = beer_wall
    made = revolved(beer_bottle, asked, outer, 60.0)
    assert made.solid.isValid()
    assert len(made.solid.Solids) == 1
    assert polyline(made.cavity.meridian, 8)[:, 1].max() == pytest.approx(235.0)
    capacity = mesh_volume(made.inside).volume_mm3
    assert made.inside.vertices_mm[:, 2].max() == pytest.approx(230.0, abs=1e-9)
    glass = mesh_volume(tessellate(made.solid, 0.1)).volume_mm3
    assert glass == pytest.approx(revolved_volume(beer_bottle.core).volume_mm3 - capacity, rel=2e-3)
    below_lip = made.inside.vertices_mm[made.inside.vertices_mm[:, 2] < 225.0]
    assert np.abs(outer.clearance(below_lip[::5]).clearance_mm).max() < 0.06


def test_the_method_refuses_what_is_not_a_function_of_the_height(beer_bottle, beer_wall):
    asked, outer = beer_wall
    with pytest.raises(GlassWorkbenchError, match="varies with angle or face"):
        revolved(beer_bottle, replace(asked, over_height=None), outer, 60.0)


def test_a_bore_that_leaves_no_sealing_surface_is_refused(beer_bottle, beer_wall):
    asked, outer = beer_wall
    with pytest.raises(InputError, match=r"wall bore: 23 mm leaves nothing of the sealing surface at height 230\.0 mm"):
        revolved(beer_bottle, replace(asked, bore=Bore(11.5, 216.5, 205.0)), outer, 60.0)


def test_behind_the_rings_of_a_bottle_the_bore_is_straight(beer_bottle):
    low, high = beer_bottle.anatomy.regions["finish"]
    asked, outer = wall_of(beer_bottle, Bore(8.0, low, low - (high - low)))
    made = revolved(beer_bottle, asked, outer, 60.0)
    points = polyline(made.cavity.meridian[:-1], 20)
    finish = points[points[:, 1] >= low - 1e-6]
    assert np.abs(finish[:, 0] - 8.0).max() < 1e-6
    assert made.solid.isValid()
