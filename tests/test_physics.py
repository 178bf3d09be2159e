"""What both tracers make of textbook optics, against its closed forms."""

from dataclasses import replace
from itertools import pairwise

import closed_forms
import numpy as np
import pytest
import tracer_scenes
from tracer_scenes import CAMERA, SODA_LIME, WATER, box_mesh, cylinder, prism_mesh, revolved_ball

from glassworkbench.scene import Body, Ellipsoid, Environment, Medium, Panel, Scene
from glassworkbench.tracer import native, reference

RELATIVE = 1e-9
TRACERS = {"reference": reference} | ({"native": native} if native.available() else {})
SLABS = {
    "revolved": lambda thickness: cylinder(900.0, 0.0, thickness),
    "mesh": lambda thickness: box_mesh((-900.0, -900.0, 0.0), (900.0, 900.0, thickness)),
}
BALLS = {
    "revolved": lambda radius: revolved_ball(radius),
    "revolved_lying": lambda radius: revolved_ball(radius, axis=(1.0, 0.0, 0.0)),
    "ellipsoid": lambda radius: Ellipsoid((0.0, 0.0, 0.0), (radius, radius, radius)),
}
FAR = Body("far", Ellipsoid((0.0, 0.0, 0.0), (5000.0, 5000.0, 5000.0)))
"""Marks where a ray leaves for good: a medium like air, whose surface `follow` reports."""


@pytest.fixture(params=TRACERS)
def tracer(request):
    return TRACERS[request.param]


@pytest.fixture(params=SLABS)
def slab(request):
    return SLABS[request.param]


@pytest.fixture(params=BALLS)
def ball(request):
    return BALLS[request.param]


def one_body(surface, index=SODA_LIME, absorption=(0.0, 0.0, 0.0), lights=()):
    return Scene((Body("glass", surface),), (Medium("glass", index, absorption),), lights, CAMERA)


def path_with_exit(tracer, scene, origin, direction, **options):
    """Return the interfaces of a path in the scene, and the point and unit direction in which it leaves."""
    marked = replace(scene, bodies=(*scene.bodies, FAR), media=(*scene.media, Medium("far", 1.0)))
    *path, last = tracer.follow(marked, np.array(origin, float), np.array(direction, float), **options)
    assert last.body == "far"
    away = last.point_mm - path[-1].point_mm
    return path, path[-1].point_mm, away / np.linalg.norm(away)


def slab_light(tracer, surface, incidence, absorption=0.0):
    """Return the shares of light that a slab on z = 0 reflects and transmits."""
    up = Panel((-900.0, -900.0, 90.0), (1800.0, 0.0, 0.0), (0.0, 1800.0, 0.0), (1.0, 0.0, 0.0))
    down = Panel((-900.0, -900.0, -90.0), (1800.0, 0.0, 0.0), (0.0, 1800.0, 0.0), (0.0, 1.0, 0.0))
    scene = one_body(surface, absorption=(absorption,) * 3, lights=(up, down))
    direction = np.array([[np.sin(incidence), 0.0, -np.cos(incidence)]])
    seen = tracer.radiance(scene, np.array([[1.0, 2.0, 50.0]]), direction, cutoff=1e-14)
    assert seen.leaks[0] == 0
    return seen.radiance[0, :2]


def test_glass_reflects_four_percent_at_normal_incidence(tracer, slab):
    first = tracer.follow(one_body(slab(3.0)), np.array([1.0, 2.0, 9.0]), np.array([0.0, 0.0, -1.0]))[0]
    assert first.reflectance == pytest.approx(closed_forms.normal_reflectance(SODA_LIME), rel=RELATIVE)
    assert first.reflectance == pytest.approx(0.043020, abs=5e-7)


def test_lossless_slab_adds_up_all_orders_of_reflection(tracer, slab):
    reflected, transmitted = slab_light(tracer, slab(3.0), 0.0)
    expected = closed_forms.slab_reflectance(closed_forms.normal_reflectance(SODA_LIME))
    assert expected == pytest.approx(0.082491, abs=5e-7)
    assert reflected == pytest.approx(expected, rel=RELATIVE)
    assert transmitted == pytest.approx(1.0 - expected, rel=RELATIVE)


def test_oblique_slab_reflects_as_the_averaged_fresnel_form_says(tracer, slab):
    # Polarisation followed through the slab would give .1573; averaged at each interface it is .1702.
    reflected, transmitted = slab_light(tracer, slab(3.0), np.pi / 3.0)
    average = np.mean(closed_forms.reflectances(1.0, SODA_LIME, np.pi / 3.0))
    expected = closed_forms.slab_reflectance(average)
    assert expected == pytest.approx(0.1702, abs=5e-5)
    assert reflected == pytest.approx(expected, rel=RELATIVE)
    assert transmitted == pytest.approx(1.0 - expected, rel=RELATIVE)


@pytest.mark.parametrize("incidence", [0.0, 0.7])
def test_absorbing_slab_dims_every_order_by_its_path(tracer, slab, incidence):
    thickness, absorption = 4.0, 0.11
    r = (
        np.mean(closed_forms.reflectances(1.0, SODA_LIME, incidence))
        if incidence
        else closed_forms.normal_reflectance(SODA_LIME)
    )
    inside = np.arcsin(np.sin(incidence) / SODA_LIME)
    tau = np.exp(-absorption * thickness / np.cos(inside))
    reflected, transmitted = slab_light(tracer, slab(thickness), incidence, absorption)
    assert transmitted == pytest.approx(closed_forms.slab_transmittance(r, tau), rel=RELATIVE)
    assert reflected == pytest.approx(closed_forms.slab_total_reflectance(r, tau), rel=RELATIVE)


@pytest.mark.parametrize(("outside", "degrees"), [(1.0, 41.029), (WATER, 61.079)])
def test_reflection_is_total_from_the_critical_angle_on(tracer, slab, outside, degrees):
    critical = closed_forms.critical_angle(SODA_LIME, outside)
    assert np.degrees(critical) == pytest.approx(degrees, abs=5e-4)
    sea = Body("sea", Ellipsoid((0.0, 0.0, 0.0), (2000.0, 2000.0, 2000.0)))
    media = (Medium("glass", SODA_LIME), Medium("sea", outside))
    scene = Scene((sea, Body("glass", slab(3.0))), media, (), CAMERA)

    def reflectance(incidence):
        direction = np.array([np.sin(incidence), 0.0, np.cos(incidence)])
        return tracer.follow(scene, np.array([1.0, 2.0, 1.0]), direction, room=1)[0].reflectance

    assert reflectance(critical * (1.0 - RELATIVE)) < 1.0
    assert reflectance(critical * (1.0 + RELATIVE)) == 1.0


def test_light_polarised_in_the_plane_is_not_reflected_at_brewsters_angle(tracer, slab):
    brewster = np.arctan(SODA_LIME)
    assert np.degrees(brewster) == pytest.approx(56.718, abs=5e-4)
    _, reflectance_p, _ = reference.fresnel(np.array([1.0]), np.array([SODA_LIME]), np.cos([brewster]))
    assert reflectance_p[0] < 1e-30
    direction = np.array([np.sin(brewster), 0.0, -np.cos(brewster)])
    first = tracer.follow(one_body(slab(3.0)), np.array([1.0, 2.0, 9.0]), direction)[0]
    only_s = 0.5 * ((SODA_LIME**2 - 1.0) / (SODA_LIME**2 + 1.0)) ** 2
    assert first.reflectance == pytest.approx(only_s, rel=RELATIVE)


def test_fresnel_agrees_with_the_sine_and_tangent_laws():
    incidence = np.linspace(0.01, 1.55, 200)
    for before, after in ((1.0, SODA_LIME), (WATER, SODA_LIME)):
        ours = reference.fresnel(np.full(200, before), np.full(200, after), np.cos(incidence))[:2]
        np.testing.assert_allclose(ours, closed_forms.reflectances(before, after, incidence), rtol=1e-9, atol=1e-15)


def test_prism_deviates_least_when_passed_symmetrically(tracer):
    apex = np.pi / 3.0
    side = 40.0
    scene = one_body(prism_mesh([(-side, 0.0), (side, 0.0), (0.0, side * np.sqrt(3.0))], 100.0))
    least = closed_forms.prism_minimum_deviation(SODA_LIME, apex)
    assert np.degrees(least) == pytest.approx(39.2268, abs=5e-5)

    def deviation(incidence):
        outward = np.array([-np.cos(np.pi / 6.0), np.sin(np.pi / 6.0)])
        turned = np.array([[np.cos(incidence), -np.sin(incidence)], [np.sin(incidence), np.cos(incidence)]]) @ -outward
        direction = np.array([*turned, 0.0])
        entrance = np.array([-0.5 * side, 0.5 * side * np.sqrt(3.0), 0.0])
        _, _, leaving = path_with_exit(tracer, scene, entrance - 30.0 * direction, direction)
        return np.arctan2(np.linalg.norm(np.cross(direction, leaving)), direction @ leaving)

    symmetric = 0.5 * (least + apex)
    assert deviation(symmetric) == pytest.approx(least, rel=RELATIVE)
    assert deviation(symmetric - 0.01) > least
    assert deviation(symmetric + 0.01) > least


def test_plate_shifts_a_ray_sideways(tracer, slab):
    direction = np.array([1.0, 0.0, -1.0]) / np.sqrt(2.0)
    origin = np.array([-20.0, 1.0, 30.0])
    _, point, leaving = path_with_exit(tracer, one_body(slab(3.0)), origin, direction)
    assert np.linalg.norm(leaving - direction) < 1e-12
    shift = np.linalg.norm(np.cross(point - origin, direction))
    assert shift == pytest.approx(closed_forms.plate_shift(SODA_LIME, 3.0, np.pi / 4.0), rel=RELATIVE)
    assert shift == pytest.approx(1.00966, abs=5e-6)


def paraxial_focus(tracer, scene, height_mm):
    """Return where rays along x in the plane z = 0 meet the x axis, extrapolated to height 0 (Richardson)."""
    table = []
    for height in height_mm / 2.0 ** np.arange(5):
        _, point, leaving = path_with_exit(tracer, scene, (-200.0, height, 0.0), (1.0, 0.0, 0.0))
        table.append(point[0] - point[1] * leaving[0] / leaving[1])
    for power in 4.0 ** np.arange(1, 5):
        table = [(power * finer - coarser) / (power - 1.0) for coarser, finer in pairwise(table)]
    return table[0]


def test_ball_lens_has_its_focal_length(tracer, ball):
    focus = paraxial_focus(tracer, one_body(ball(10.0)), 1.0)
    assert focus == pytest.approx(closed_forms.ball_lens_focal_length(SODA_LIME, 20.0), rel=RELATIVE)
    assert focus == pytest.approx(14.5533, abs=5e-5)


def test_water_cylinder_focuses_behind_itself(tracer):
    focus = paraxial_focus(tracer, one_body(cylinder(37.5, -100.0, 80.0), index=WATER), 2.0)
    assert focus == pytest.approx(closed_forms.concentric_focal_length([37.5], [1.0, WATER]), rel=RELATIVE)
    assert focus == pytest.approx(74.989, abs=5e-4)


@pytest.mark.parametrize(("inside", "expected_mm"), [(1.0, -627.611), (WATER, 77.510)])
def test_bottle_is_a_weak_diverging_lens_empty_and_a_strong_one_filled(tracer, inside, expected_mm):
    bodies = (
        Body("outer", cylinder(37.5, -100.0, 100.0)),
        Body("cavity", cylinder(34.5, -95.0, 120.0)),
        Body("fill", cylinder(36.0, -97.0, 60.0)),
    )
    media = (Medium("outer and not cavity", SODA_LIME), Medium("cavity and fill", inside))
    focus = paraxial_focus(tracer, Scene(bodies, media, (), CAMERA), 2.0)
    expected = closed_forms.concentric_focal_length([37.5, 34.5], [1.0, SODA_LIME, inside])
    assert focus == pytest.approx(expected, rel=RELATIVE)
    assert focus == pytest.approx(expected_mm, abs=5e-4)


@pytest.mark.parametrize(
    ("index", "order", "degrees"),
    [(SODA_LIME, 1, 159.206), (SODA_LIME, 2, 270.917), (WATER, 1, 137.980), (WATER, 2, 230.996)],
)
def test_rainbow_stands_at_the_angle_of_least_deviation(ball, index, order, degrees):
    scene = one_body(ball(10.0), index=index)

    def deviation(incidence):
        height = 10.0 * np.sin(incidence)
        reflections = tuple(range(1, order + 1))
        _, _, leaving = path_with_exit(reference, scene, (-50.0, height, 0.0), (1.0, 0.0, 0.0), reflect_at=reflections)
        return -np.arctan2(leaving[1], leaving[0]) % (2.0 * np.pi)

    incidence = closed_forms.rainbow_incidence(index, order)
    least = closed_forms.ball_deviation(index, incidence, order)
    assert np.degrees(least) == pytest.approx(degrees, abs=6e-4)
    assert deviation(incidence) == pytest.approx(least, rel=RELATIVE)
    assert deviation(incidence - 0.01) > least
    assert deviation(incidence + 0.01) > least


def test_light_of_a_ball_is_the_series_of_its_internal_reflections(tracer, ball):
    # In the plane of the ray every incidence is the same, so order k leaves with weight (1 - R)^2 R^(k - 1).
    compass = np.random.default_rng(3).uniform(0.5, 1.5, (1, 4, 3))
    scene = one_body(ball(10.0), lights=(Environment(compass),))
    heights = np.array([-9.0, -4.0, 0.5, 6.0, 8.5])
    origins = np.column_stack([np.full(5, -60.0), heights, np.zeros(5)])
    seen = tracer.radiance(scene, origins, np.tile([1.0, 0.0, 0.0], (5, 1)), cutoff=1e-15)

    incidence = np.arcsin(heights / 10.0)
    r = np.mean(closed_forms.reflectances(1.0, SODA_LIME, incidence), axis=0)

    def sky(azimuth):
        centres = -135.0 + 90.0 * np.arange(4)
        return np.stack([np.interp(np.degrees(azimuth), centres, compass[0, :, c], period=360.0) for c in range(3)], 1)

    expected = r[:, None] * sky(np.pi - 2.0 * incidence)
    for order in range(20):
        turned = closed_forms.ball_deviation(SODA_LIME, incidence, order)
        # A ray below the axis turns the other way round; its internal reflections turn back by the same half turn.
        expected += ((1.0 - r) ** 2 * r**order)[:, None] * sky(-turned)
    np.testing.assert_allclose(seen.radiance, expected, rtol=RELATIVE)


@pytest.mark.parametrize("name", tracer_scenes.SCENES)
def test_furnace_lossless_glass_in_uniform_light_is_invisible(tracer, name):
    scene = tracer_scenes.SCENES[name]()
    media = [replace(medium, absorption_per_mm=(0.0, 0.0, 0.0)) for medium in scene.media]
    furnace = replace(scene, media=media, lights=(Environment(2.5),))
    count = 2000 if tracer is not reference else 60
    seen = tracer.radiance(furnace, *tracer_scenes.rays_through(furnace, count, seed=11))
    assert np.all(seen.leaks == 0)
    missing = 2.5 - seen.radiance
    assert np.all(missing >= -1e-12)
    np.testing.assert_allclose(missing, np.repeat(seen.bound[:, None], 3, axis=1), atol=1e-11)


@pytest.mark.parametrize("name", ["filled_bottle", "leaning_bottle", "goblet", "seeds"])
def test_a_path_can_be_walked_backwards(tracer, name):
    scene = replace(tracer_scenes.SCENES[name](), lights=())
    walked = 0
    for target, direction in zip(*tracer_scenes.rays_through(scene, 24, seed=12), strict=True):
        if walked == 6:
            break
        origin = target - 1000.0 * direction / np.linalg.norm(direction)
        path = tracer.follow(scene, origin, direction)
        if not 2 <= len(path) <= 8:
            continue
        forward, _, leaving = path_with_exit(tracer, scene, origin, direction)
        back, _, home = path_with_exit(tracer, scene, forward[-1].point_mm + 10.0 * leaving, -leaving)
        assert len(back) == len(forward)
        for there, again in zip(forward, reversed(back), strict=True):
            np.testing.assert_allclose(again.point_mm, there.point_mm, atol=1e-9)
            assert again.medium_before == (there.medium_before if there.reflectance == 1.0 else there.medium_after)
            assert again.reflectance == pytest.approx(there.reflectance, rel=1e-6)
        np.testing.assert_allclose(home, -direction / np.linalg.norm(direction), atol=1e-9)
        walked += 1
    assert walked == 6
