"""What holds for any scene, ray and setting: light runs both ways, none is lost, and the image moves with its scene.

Crossings that come in pairs and bounds that shrink with the cut-off are in tests/test_hard_cases.py, textbook optics
and a path walked backwards through fixed scenes in tests/test_physics.py.
"""

from dataclasses import replace

import numpy as np
import pytest
import tracer_scenes
from closed_forms import reflectances
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st
from patch_bodies import ball_patches, pebble_patches
from tracer_scenes import CAMERA, SODA_LIME, WATER, box_mesh, revolved_ball

from glassworkbench.scene import Body, Ellipsoid, Environment, Medium, Panel, Pinhole, Revolved, Scene, Telecentric
from glassworkbench.tracer import Cancel, native, reference, render
from glassworkbench.tracer.film import Film
from glassworkbench.tracer.tiles import tile_count

TRACERS = {"reference": reference} | ({"native": native} if native.available() else {})
needs_native = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")
FAR = Body("far", Ellipsoid((0.0, 0.0, 0.0), (5000.0, 5000.0, 5000.0)))
"""Marks where a ray leaves for good: a medium like air, whose surface `follow` reports."""

seeds = st.integers(0, 2**32 - 1)


def examples(count):
    return settings(
        max_examples=count,
        deadline=None,
        derandomize=True,
        phases=(Phase.generate,),  # to shrink a seed means nothing
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture, HealthCheck.filter_too_much],
    )


@pytest.fixture(params=TRACERS)
def tracer(request):
    return TRACERS[request.param]


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


@examples(20)
@given(seed=seeds, name=st.sampled_from(["bottle", "leaning_bottle", "goblet", "ring", "seeds", "patches"]))
def test_a_refracted_path_traced_back_arrives_where_it_began(tracer, seed, name):
    assume(tracer is native or name != "patches")
    scene = tracer_scenes.SCENES[name]()
    marked = replace(scene, bodies=(*scene.bodies, FAR), media=(*scene.media, Medium("far", 1.0)), lights=())
    target, direction = (values[0] for values in tracer_scenes.rays_through(scene, 1, seed))
    direction = unit(direction)
    origin = target - 1000.0 * direction
    *path, end = tracer.follow(marked, origin, direction)
    # A path of many interfaces spreads rounding errors, one at grazing incidence too.
    assume(2 <= len(path) <= 8 and min(crossing.cos_incidence for crossing in path) > 0.01)
    leaving = unit(end.point_mm - path[-1].point_mm)
    *back, home = tracer.follow(marked, path[-1].point_mm + 10.0 * leaving, -leaving)
    assert [crossing.body for crossing in back] == [crossing.body for crossing in reversed(path)]
    np.testing.assert_allclose(
        [crossing.point_mm for crossing in back], [crossing.point_mm for crossing in reversed(path)], atol=1e-6
    )
    np.testing.assert_allclose(np.cross(home.point_mm - origin, direction), 0.0, atol=1e-4)


BALLS = {
    "revolved": revolved_ball(10.0),
    "ellipsoid": Ellipsoid((0.0, 0.0, 0.0), (10.0, 10.0, 10.0)),
    "patches": ball_patches(10.0, 4),
}


@examples(30)
@given(
    kind=st.sampled_from(sorted(BALLS)),
    index=st.floats(1.01, 2.5),
    absorption=st.floats(0.0, 0.5),
    height=st.floats(0.0, 0.999),
    turn=st.sampled_from([-2.6, -1.3, 0.0, 0.2, 1.1, 2.9]),
)
def test_what_is_reflected_transmitted_and_absorbed_adds_up(tracer, kind, index, absorption, height, turn):
    # Inside a ball all chords of a path are alike, and so are its reflections: what it absorbs is a geometric series.
    incidence = np.arcsin(height)
    reflectance = (
        np.mean(reflectances(1.0, index, incidence)) if height > 1e-6 else ((index - 1.0) / (index + 1.0)) ** 2
    )
    passed = np.exp(-absorption * 20.0 * np.sqrt(1.0 - (height / index) ** 2))
    absorbed = (1.0 - reflectance) * (1.0 - passed) / (1.0 - reflectance * passed)
    medium = Medium("ball", index, (absorption,) * 3)
    scene = Scene((Body("ball", BALLS[kind]),), (medium,), (Environment(1.0),), CAMERA)
    aside = np.array([np.cos(turn), np.sin(turn) * np.cos(1.0), np.sin(turn) * np.sin(1.0)])
    direction = unit(np.cross(aside, [0.3, -0.7, 0.6]))
    origin = 10.0 * height * aside - 50.0 * direction
    seen = tracer.radiance(scene, origin[None], direction[None], cutoff=1e-14)
    assert seen.leaks[0] == 0
    np.testing.assert_allclose(seen.radiance[0] + absorbed, 1.0, atol=1e-9)


@examples(5)
@given(seed=seeds, name=st.sampled_from(["ring", "seeds", "goblet", "meshes"]))
def test_a_ray_that_starts_on_a_surface_loses_no_light(tracer, seed, name):
    scene = tracer_scenes.SCENES[name]()
    clear = [replace(medium, absorption_per_mm=np.zeros(3)) for medium in scene.media]
    scene = replace(scene, media=clear, lights=(Environment(1.0),))
    rng, rays = np.random.default_rng(seed), 8 if tracer is native else 3
    starts = [
        path[rng.integers(len(path))].point_mm
        for path in (
            tracer.follow(scene, *ray) for ray in zip(*tracer_scenes.rays_through(scene, rays, seed), strict=True)
        )
        if path
    ]
    assume(starts)
    seen = tracer.radiance(scene, np.array(starts), unit(rng.normal(size=(len(starts), 3))))
    np.testing.assert_allclose(1.0 - seen.radiance, np.repeat(seen.bound[:, None], 3, axis=1), atol=1e-9)


def composed(turn, shift, scale):
    """A scene of every kind of surface, turned, moved and scaled, before a panel that goes with it."""

    def placed(point):
        return scale * (turn @ np.asarray(point, dtype=float)) + shift

    drop = Ellipsoid(placed((4.0, -3.0, 8.0)), scale * np.array([5.0, 3.0, 4.0]), turn)
    outline = tracer_scenes.bottle_meridian()[:, :, :] * np.array([0.2, 0.2, 1.0])
    outline[:, :, :2] *= scale
    bottle = Revolved(outline, placed((-9.0, 2.0, -20.0)), turn @ np.array([0.1, 0.2, 1.0]))
    box = box_mesh((-5.0, -12.0, -20.0), (16.0, 9.0, 20.0))
    box = replace(box, vertices_mm=box.vertices_mm * scale).placed(turn, np.asarray(shift))
    scaled = [replace(s, control_points=s.control_points * [scale, scale, scale, 1.0]) for s in PEBBLE.sheets]
    mesh = replace(PEBBLE.mesh, vertices_mm=PEBBLE.mesh.vertices_mm * scale)
    pebble = replace(PEBBLE, sheets=scaled, mesh=mesh, deviation_mm=1e-4 * scale)
    pebble = pebble.placed(turn, placed((0.0, 6.0, 2.0)))
    media = (
        Medium("drop", WATER, np.array([0.01, 0.0, 0.02]) / scale),
        Medium("bottle", 1.7, np.array([0.02, 0.03, 0.0]) / scale),
        Medium("box and not pebble", SODA_LIME, np.array([0.0, 0.01, 0.01]) / scale),
    )
    panel = Panel(placed((-40.0, 40.0, -40.0)), scale * turn[:, 0] * 80.0, scale * turn[:, 2] * 45.0, (1.0, 0.9, 0.8))
    bodies = tuple(
        Body(n, s) for n, s in zip(("drop", "bottle", "box", "pebble"), (drop, bottle, box, pebble), strict=True)
    )
    camera = Pinhole(placed((20.0, -200.0, 30.0)), placed((0.0, 0.0, 0.0)), 0.3, turn[:, 2])
    return Scene(bodies, media, (panel, Environment((0.1, 0.2, 0.3))), camera, (24, 32))


PEBBLE = pebble_patches(12, 6)
HERE = (np.eye(3), np.zeros(3), 1.0)


@st.composite
def motions(draw):
    rng = np.random.default_rng(draw(seeds))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    scale = 10.0 ** draw(st.floats(-3.0, 3.0))
    return turn, scale * rng.uniform(-100.0, 100.0, 3), scale


@examples(2)
@given(motion=motions(), seed=seeds)
def test_rays_see_the_same_in_a_scene_turned_moved_and_scaled(tracer, motion, seed):
    turn, shift, scale = motion
    origins, directions = tracer_scenes.rays_at((-20.0,) * 3, (20.0,) * 3, 2000 if tracer is native else 4, seed)
    here = tracer.radiance(composed(*HERE), origins, directions)
    there = tracer.radiance(composed(*motion), scale * origins @ turn.T + shift, directions @ turn.T)
    assert here.leaks.sum() == there.leaks.sum() == 0
    difference = np.abs(here.radiance - there.radiance).max(axis=1)
    # Long paths carry rounding errors to where one branch more or less is followed, or over an edge of the panel.
    assert np.median(difference) <= 1e-9
    assert np.mean(difference <= here.bound + there.bound + 1e-7) >= 0.99
    hit = np.isfinite(here.depth_mm)
    np.testing.assert_array_equal(hit, np.isfinite(there.depth_mm))
    np.testing.assert_allclose(there.depth_mm[hit] / scale, here.depth_mm[hit], rtol=0.0, atol=1e-7)


@needs_native
@examples(2)
@given(motion=motions())
def test_the_image_follows_its_scene_wherever_it_goes(motion):
    here, there = (render(composed(*place), tolerance=0.2) for place in (HERE, motion))
    np.testing.assert_allclose(there.depth_mm / motion[2], here.depth_mm, rtol=1e-5)
    difference = np.abs(here.pixels - there.pixels).max(axis=2)
    assert np.mean(difference <= 1e-4) >= 0.9
    assert np.mean(difference <= here.certificate + there.certificate) >= 0.99


@needs_native
@examples(3)
@given(tolerance=st.floats(0.05, 0.2), factor=st.floats(2.0, 10.0), name=st.sampled_from(["goblet", "seeds", "bottle"]))
def test_a_looser_tolerance_never_costs_more(tolerance, factor, name):
    scene = replace(seen_whole(tracer_scenes.SCENES[name]()), size=(18, 24))
    tight, loose = (render(scene, tolerance=value).report for value in (tolerance, factor * tolerance))
    assert loose["camera_rays"] <= tight["camera_rays"]
    assert loose["intersections"] <= tight["intersections"]
    assert loose["certificate"]["total_p50"] >= tight["certificate"]["total_p50"]


@needs_native
@examples(6)
@given(
    cutoff=st.floats(1e-4, 0.1), share=st.floats(0.01, 1.0), name=st.sampled_from(["goblet", "seeds", "filled_bottle"])
)
def test_a_smaller_cut_off_never_widens_what_is_left_out_of_a_pixel(cutoff, share, name):
    # No pixel is refined: both images are traced at the same points.
    scene = replace(seen_whole(tracer_scenes.SCENES[name]()), size=(18, 24))
    coarse, fine = (filmed(scene, tolerance=1e9, cutoff=value) for value in (cutoff, share * cutoff))
    assert np.all(fine.pruned <= coarse.pruned * (1.0 + 1e-6))
    assert fine.totals[1] >= coarse.totals[1]


@needs_native
@examples(3)
@given(seed=seeds, name=st.sampled_from(["filled_bottle", "meshes", "patches"]))
def test_threads_and_the_order_of_tiles_change_no_byte(seed, name):
    scene = replace(seen_whole(tracer_scenes.SCENES[name]()), size=(70, 40))
    whole, rng = filmed(scene), np.random.default_rng(seed)
    for threads in (1, 2, 4):
        order = rng.permutation(tile_count(*scene.size))
        calls = np.split(order, np.sort(rng.integers(0, len(order) + 1, 2)))
        parts = filmed(scene, calls=calls, threads=threads)
        for field in ("radiance", "sampling", "pruned", "depth_mm", "totals"):
            assert getattr(whole, field).tobytes() == getattr(parts, field).tobytes()


def seen_whole(scene):
    """The scene before a camera that holds all its bodies."""
    low, high = tracer_scenes.bounds(scene)
    middle = 0.5 * (low + high)
    camera = Telecentric(middle + np.array([50.0, -900.0, 60.0]), middle, 1.2 * float(np.linalg.norm(high - low)))
    return replace(scene, camera=camera)


def filmed(scene, *, calls=None, threads=1, tolerance=0.3, cutoff=1e-2):
    """A film of all the scene's tiles, as many of them at a time as each of the `calls` says."""
    width, height = scene.size
    film = Film(width, height)
    engine = native.NativeScene(scene)
    for tiles in calls or [np.arange(tile_count(width, height))]:
        engine.image(
            film,
            tiles,
            np.ones((height, width), dtype=np.uint8),
            tolerance=tolerance,
            halvings=0,
            cutoff=cutoff,
            ambient=np.array([0.2, 0.3, 0.2]),
            absorption=True,
            threads=threads,
            cancel=Cancel(),
        )
    return film
