"""The reference tracer's book-keeping: bits, media, lights, what is left out and what leaks."""

from dataclasses import replace

import numpy as np
import pytest
import tracer_scenes
from tracer_scenes import CAMERA, SODA_LIME, WATER, box_mesh, cylinder

from glassworkbench.errors import InputError
from glassworkbench.scene import Body, Ellipsoid, Environment, Medium, Mesh, Panel, Scene
from glassworkbench.tracer import native, reference

ALONG_X = np.array([[1.0, 0.0, 0.0]])


def ball(radius, x=0.0):
    return Ellipsoid((x, 0.0, 0.0), (radius, radius, radius))


def wall(x, radiance=1.0):
    """A panel across the x axis."""
    return Panel((x, -50.0, -50.0), (0.0, 100.0, 0.0), (0.0, 0.0, 100.0), radiance)


def look(scene, x=-100.0, direction=ALONG_X, **options):
    return reference.radiance(scene, np.array([[x, 0.0, 0.0]]), direction, **options)


def test_liquid_that_overlaps_the_wall_touches_the_glass_directly():
    scene = replace(tracer_scenes.bottle(fill=True), lights=())
    path = reference.follow(scene, np.array([-200.0, 0.0, 100.0]), np.array([1.0, 0.0, 0.0]))
    assert [(c.body, c.medium_before, c.medium_after) for c in path] == [
        ("outer", 0, 1),
        ("cavity", 1, 2),
        ("cavity", 2, 1),
        ("outer", 1, 0),
    ]
    np.testing.assert_allclose([c.point_mm[0] for c in path], [-38.0, -35.0, 35.0, 38.0], atol=1e-12)
    assert path[1].reflectance == pytest.approx(((SODA_LIME - WATER) / (SODA_LIME + WATER)) ** 2, rel=1e-12)


def test_a_ray_may_start_inside_nested_bodies():
    bodies = (Body("shell", ball(20.0)), Body("yolk", ball(10.0)))
    media = (Medium("yolk", 1.0, (0.3, 0.0, 0.0)), Medium("shell", 1.0, (0.1, 0.0, 0.0)))
    seen = look(Scene(bodies, media, (Environment(1.0),), CAMERA), x=4.0)
    assert seen.radiance[0, 0] == pytest.approx(np.exp(-0.3 * 6.0 - 0.1 * 10.0), rel=1e-12)
    assert seen.depth_mm[0] == pytest.approx(6.0)
    assert (seen.crossings[0], seen.leaks[0]) == (2, 0)


def test_a_body_without_a_medium_changes_nothing():
    scene = Scene((Body("idle", ball(20.0)),), (), (Environment(1.0),), CAMERA)
    seen = look(scene)
    np.testing.assert_array_equal(seen.radiance, 1.0)
    assert seen.crossings[0] == 2
    assert np.isinf(seen.depth_mm[0])


def test_media_of_one_index_meet_without_reflection():
    bodies = (Body("left", ball(20.0)), Body("right", ball(10.0)))
    media = (Medium("right", 1.5), Medium("left", 1.5, (0.02, 0.0, 0.0)))
    path = reference.follow(Scene(bodies, media, (), CAMERA), np.array([-100.0, 3.0, 0.0]), ALONG_X[0])
    assert [c.reflectance == 0.0 for c in path] == [False, True, True, False]


def test_a_panel_ends_the_ray_and_the_medium_dims_it_up_to_there():
    glass = Scene((Body("glass", ball(20.0)),), (Medium("glass", 1.0, 3 * (0.05,)),), (wall(5.0, 2.0),), CAMERA)
    seen = look(glass)
    assert seen.radiance[0, 0] == pytest.approx(2.0 * np.exp(-0.05 * 25.0), rel=1e-12)
    assert seen.leaks[0] == 0


def test_the_nearer_panel_hides_the_farther_from_both_sides():
    scene = Scene((), (), (wall(10.0, 1.0), wall(20.0, 3.0), Environment(7.0)), CAMERA)
    assert look(scene, 0.0).radiance[0, 0] == 1.0
    assert look(scene, 15.0).radiance[0, 0] == 3.0
    assert look(scene, 15.0, -ALONG_X).radiance[0, 0] == 1.0
    assert look(scene, 30.0).radiance[0, 0] == 7.0
    assert look(scene, 0.0, np.array([[1.0, 20.0, 0.0]])).radiance[0, 0] == 7.0


def test_without_lights_it_is_dark():
    assert np.all(look(Scene((), (), (), CAMERA)).radiance == 0.0)


def test_the_environment_is_bilinear_between_pixel_centres():
    image = np.random.default_rng(1).uniform(0.0, 1.0, (4, 6, 3))
    scene = Scene((), (), (Environment(image),), CAMERA)

    def sky(row, column):
        polar, azimuth = (row + 0.5) / 4.0 * np.pi, ((column + 0.5) / 6.0 - 0.5) * 2.0 * np.pi
        direction = [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)]
        return look(scene, direction=np.array([direction])).radiance[0]

    np.testing.assert_allclose(sky(1.0, 2.0), image[1, 2], rtol=1e-12)
    np.testing.assert_allclose(sky(1.25, 2.0), 0.75 * image[1, 2] + 0.25 * image[2, 2], rtol=1e-12)
    np.testing.assert_allclose(sky(2.0, 5.3), 0.7 * image[2, 5] + 0.3 * image[2, 0], rtol=1e-12)
    np.testing.assert_allclose(sky(-0.4, 3.0), image[0, 3], rtol=1e-12)
    np.testing.assert_allclose(sky(3.4, 3.0), image[3, 3], rtol=1e-12)


@pytest.mark.parametrize("thickness", [0.05, 1e-4, 1e-5])
def test_walls_may_be_thin(thickness):
    bodies = (Body("outer", cylinder(40.0, 0.0, 100.0)), Body("cavity", cylinder(40.0 - thickness, 1.0, 110.0)))
    scene = Scene(bodies, (Medium("outer and not cavity", SODA_LIME),), (Environment(1.0),), CAMERA)
    path = reference.follow(scene, np.array([-1000.0, 30.0, 50.0]), np.array([1.0, 0.0, 0.01]))
    assert [(c.body, c.entering) for c in path] == [
        ("outer", True),
        ("cavity", True),
        ("cavity", False),
        ("outer", False),
    ]


def test_what_is_left_out_stays_within_the_bound():
    scene = tracer_scenes.bottle(fill=True)
    origins, directions = tracer_scenes.rays_through(scene, 100, seed=31)
    rough, fine = (reference.radiance(scene, origins, directions, cutoff=c) for c in (0.05, 0.005))
    assert np.all(fine.radiance >= rough.radiance - 1e-12)
    assert np.all(fine.radiance <= rough.radiance + rough.bound[:, None] + 1e-12)
    assert np.all(fine.bound <= rough.bound + 1e-12)


def test_paths_longer_than_the_maximum_depth_enter_the_bound():
    scene = Scene((Body("glass", ball(20.0)),), (Medium("glass", SODA_LIME),), (Environment(2.0),), CAMERA)
    seen = look(scene, maximum_depth=0)
    assert seen.radiance[0, 0] == 0.0
    assert seen.bound[0] == pytest.approx(2.0, rel=1e-12)
    r = ((SODA_LIME - 1.0) / (SODA_LIME + 1.0)) ** 2
    seen = look(scene, maximum_depth=1)
    assert seen.radiance[0, 0] == pytest.approx(2.0 * r, rel=1e-12)
    assert seen.bound[0] == pytest.approx(2.0 * (1.0 - r), rel=1e-12)


def test_an_inside_out_mesh_is_survived_and_counted_as_leaks():
    box = box_mesh((-5.0, -5.0, -5.0), (5.0, 5.0, 5.0))
    inside_out = Mesh(box.vertices_mm, box.triangles[:, ::-1], -box.normals)
    scene = Scene((Body("glass", inside_out),), (Medium("glass", SODA_LIME),), (Environment(1.0),), CAMERA)
    seen = look(scene)
    assert seen.leaks[0] >= 2
    assert np.all(np.isfinite(seen.radiance))


def test_an_answer_does_not_depend_on_the_other_rays():
    scene = tracer_scenes.goblet()
    origins, directions = tracer_scenes.rays_through(scene, 30, seed=32)
    together = reference.radiance(scene, origins, directions)
    alone = [reference.radiance(scene, origins[k : k + 1], 7.0 * directions[k : k + 1]) for k in range(5)]
    np.testing.assert_allclose(together.radiance[:5], np.concatenate([a.radiance for a in alone]), rtol=1e-9)


@pytest.mark.parametrize(
    ("origin", "direction"),
    [((0, 0, 0), (0, 0, 0)), ((np.nan, 0, 0), (0, 0, 1)), ((0, 0, 0), (0, np.inf, 1)), ((0, 0), (0, 1))],
)
def test_rays_that_make_no_sense_are_refused(origin, direction):
    with pytest.raises(InputError, match="rays"):
        reference.radiance(Scene((), (), (), CAMERA), np.array([origin], float), np.array([direction], float))


def test_no_rays_give_no_answers():
    seen = reference.radiance(tracer_scenes.seeds(), np.empty((0, 3)), np.empty((0, 3)))
    assert seen.radiance.shape == (0, 3)


@pytest.mark.skipif(not native.available(), reason="the native tracer is not built")
@pytest.mark.parametrize("name", tracer_scenes.SCENES)
def test_both_tracers_agree(name):
    scene = tracer_scenes.SCENES[name]()
    origins, directions = tracer_scenes.rays_through(scene, 300, seed=33)
    ours, theirs = (tracer.radiance(scene, origins, directions) for tracer in (reference, native))
    np.testing.assert_allclose(theirs.depth_mm, ours.depth_mm, rtol=1e-12)
    assert np.all(ours.leaks == 0)
    assert np.all(theirs.leaks == 0)
    difference = np.abs(theirs.radiance - ours.radiance).max(axis=1)
    apart = difference > 1e-10
    assert np.mean(apart) < 0.05
    # Light that total reflection traps is chaotic, and azimuth means little near the poles of the sky. How far rounding
    # errors of the ray (2e-13 mm, 2e-16 rad) move the reference's own answer is how far two tracers may differ.
    rng = np.random.default_rng(34)
    lengths = np.linalg.norm(directions[apart], axis=1, keepdims=True)
    sensitivity = np.zeros(len(lengths))
    for _ in range(3):
        nearby = origins[apart] + 2e-13 * rng.normal(size=(len(lengths), 3))
        turned = directions[apart] + 2e-16 * lengths * rng.normal(size=(len(lengths), 3))
        moved = reference.radiance(scene, nearby, turned)
        sensitivity = np.maximum(sensitivity, np.abs(moved.radiance - ours.radiance[apart]).max(axis=1))
    assert np.all(difference[apart] <= 100.0 * sensitivity)
