"""The native core against the numpy reference, and what it promises on top: same bytes, no leaks, cancel."""

import threading

import numpy as np
import pytest
import tracer_scenes

from glassworkbench.errors import Cancelled
from glassworkbench.scene import Body, Environment, Medium, Mesh, Pinhole, Revolved, Scene, Telecentric
from glassworkbench.tracer import native, reference
from glassworkbench.tracer.control import Cancel
from glassworkbench.tracer.film import Film

pytestmark = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")

RAYS = {"patches": 300}
"""Random rays a scene, 10 000 where the reference is quick."""


def seen(answer):
    """Radiance and bound side by side, (n, 4)."""
    return np.column_stack([answer.radiance, answer.bound])


def sensitivity(scene, origins, directions):
    """How far moving each ray by one rounding error moves what it sees: paths of many bounces amplify it."""
    rng = np.random.default_rng(3)
    size = np.abs(origins).max()
    here = seen(native.radiance(scene, origins, directions))
    spread = np.zeros(len(origins))
    for _ in range(16):
        moved = origins + 1e-15 * size * rng.normal(size=origins.shape)
        turned = directions + 1e-16 * rng.normal(size=directions.shape)
        there = seen(native.radiance(scene, moved, turned))
        spread = np.maximum(spread, np.abs(there - here).max(axis=1))
    return spread


@pytest.mark.parametrize("name", tracer_scenes.SCENES)
def test_both_tracers_agree_on_random_rays_to_the_last_digits_that_mean_anything(name):
    scene = tracer_scenes.SCENES[name]()
    origins, directions = tracer_scenes.rays_through(scene, RAYS.get(name, 10_000), seed=11)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    mine = native.radiance(scene, origins, directions)
    truth = reference.radiance(scene, origins, directions)
    spread = sensitivity(scene, origins, directions)
    error = np.abs(seen(mine) - seen(truth)).max(axis=1)
    assert np.all(error <= 1e-10 + 20.0 * spread)
    assert np.mean(error <= 1e-10) >= 0.97
    stable = spread < 1e-11
    np.testing.assert_array_equal(mine.crossings[stable], truth.crossings[stable])
    np.testing.assert_allclose(mine.depth_mm, truth.depth_mm, rtol=1e-12, atol=1e-9)
    assert mine.leaks.sum() == 0


@pytest.mark.parametrize("name", tracer_scenes.SCENES)
def test_both_tracers_follow_the_same_path(name):
    scene = tracer_scenes.SCENES[name]()
    origins, directions = tracer_scenes.rays_through(scene, 6 if name in RAYS else 50, seed=12)
    for origin, direction in zip(origins, directions, strict=True):
        mine, truth = (tracer.follow(scene, origin, direction) for tracer in (native, reference))
        assert [(c.body, c.entering, c.medium_before, c.medium_after) for c in mine] == [
            (c.body, c.entering, c.medium_before, c.medium_after) for c in truth
        ]
        for a, b in zip(mine, truth, strict=True):
            np.testing.assert_allclose(a.point_mm, b.point_mm, atol=1e-7)
            assert a.reflectance == pytest.approx(b.reflectance, abs=1e-7)


@pytest.mark.parametrize("name", ["bottle", "meshes", "patches"])
def test_any_number_of_threads_gives_the_same_bytes(name):
    scene = tracer_scenes.SCENES[name]()
    origins, directions = tracer_scenes.rays_through(scene, 3000, seed=13)
    one, two, five = (native.radiance(scene, origins, directions, threads=threads) for threads in (1, 2, 5))
    for field in ("radiance", "bound", "depth_mm", "crossings"):
        assert getattr(one, field).tobytes() == getattr(two, field).tobytes() == getattr(five, field).tobytes()


@pytest.mark.parametrize("build", ["baseline", "v3", "v4"])
@pytest.mark.parametrize("name", ["filled_bottle", "meshes", "patches"])
def test_every_build_gives_the_same_bytes(name, build, monkeypatch):
    widest = native._library()
    if build not in native.BUILDS_BY_VECTOR_WIDTH[widest.glass_vector_width()]:
        pytest.skip("this processor lacks the instructions")
    scene = tracer_scenes.SCENES[name]()
    rays = tracer_scenes.rays_through(scene, 2000, seed=21)
    expected = native.radiance(scene, *rays)
    library = native._load(build)
    monkeypatch.setattr(native, "_library", lambda: library)
    got = native.radiance(scene, *rays)
    assert got.radiance.tobytes() == expected.radiance.tobytes()
    assert got.bound.tobytes() == expected.bound.tobytes()


def test_a_smaller_cutoff_stays_within_the_bound_of_a_larger_one():
    scene = tracer_scenes.bottle()
    rays = tracer_scenes.rays_through(scene, 3000, seed=14)
    coarse, fine = native.radiance(scene, *rays, cutoff=0.05), native.radiance(scene, *rays, cutoff=1e-6)
    missing = fine.radiance - coarse.radiance
    assert np.all(missing >= -1e-12)
    assert np.all(missing <= coarse.bound[:, None] + 1e-12)


def test_grazing_rays_in_a_push_up_find_both_crossings():
    # A ray that skims along the push-up: piece and hyperbola bend opposite ways, and both crossings lie where the
    # slopes at the piece's ends have the same sign. They were once missed, and the ray leaked.
    corners = [
        (0, 22),
        (7, 21),
        (14, 17.8),
        (20, 12.8),
        (25, 6.8),
        (28.2, 2.6),
        (31, 0.45),
        (38, 16),
        (38, 40),
        (0, 40),
    ]
    meridian = tracer_scenes.polyline(*corners)
    meridian[4] = tracer_scenes.cubic((25, 6.8), (26.034, 5.385), (27.012, 3.945), (28.2, 2.6))
    scene = Scene((Body("glass", Revolved(meridian)),), (Medium("glass", 1.52),), (Environment(1.0),), pinhole())
    start = np.array([2.5638465239288832, -25.675703728191465, 5.6885541662826773])
    direction = np.array([0.74217761489817635, -0.34014228131843982, -0.57747347679658989])
    offsets = np.linspace(-1e-3, 1e-3, 2001)[:, None] * np.array([0.0, 0.6, 0.8])
    answer = native.radiance(scene, start + offsets - 100.0 * direction, np.tile(direction, (2001, 1)))
    assert answer.leaks.sum() == 0


def test_an_apex_a_rounding_error_off_still_looks_along_the_axis():
    # The control point beside the apex lies one rounding error too high: the arc seems to turn just before its end, and
    # the piece cut off there had a tangent of noise.
    meridian = np.array(tracer_scenes.revolved_ball(10.0).meridian)
    meridian[-1, 2, 1] = np.nextafter(10.0, 11.0)
    scene = Scene((Body("ball", Revolved(meridian)),), (Medium("ball", 1.5),), (Environment(1.0),), pinhole())
    path = native.follow(scene, np.array([0.0, 0.0, 50.0]), np.array([0.0, 0.0, -1.0]))
    assert [crossing.cos_incidence for crossing in path] == pytest.approx([1.0, 1.0], abs=1e-9)
    np.testing.assert_allclose(path[1].point_mm, [0.0, 0.0, -10.0], atol=1e-9)


@pytest.mark.parametrize("fill_radius", [10.0, 12.0])
def test_bodies_that_coincide_do_not_leak(fill_radius):
    ball = tracer_scenes.revolved_ball(10.0)
    bodies = (Body("outer", ball), Body("coat", ball), Body("fill", tracer_scenes.cylinder(fill_radius, -5.0, 0.0)))
    media = (Medium("fill and coat", 1.33), Medium("coat and not fill", 1.7), Medium("outer", 1.5))
    scene = Scene(bodies, media, (Environment(1.0),), pinhole())
    answer = native.radiance(scene, *tracer_scenes.rays_through(scene, 20_000, seed=15), cutoff=1e-4)
    assert answer.leaks.sum() == 0
    assert np.all(np.abs(answer.radiance - 1.0) <= answer.bound[:, None] + 1e-12)


def test_rays_through_joints_edges_and_vertices_cross_once():
    cube = tracer_scenes.box_mesh((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    drum = tracer_scenes.cylinder(1.0, -1.0, 1.0)
    for surface in (cube, drum):
        scene = Scene((Body("glass", surface),), (Medium("glass", 1.0),), (Environment(1.0),), pinhole())
        grid = np.linspace(-0.75, 0.75, 7)
        x, y = (g.ravel() for g in np.meshgrid(grid, grid))
        for down in ((0.0, 0.0, -1.0), (0.0, 0.5, -1.0), (0.25, 0.5, -1.0), (1.0, 1.0, -1.0)):
            origins = np.stack([x, y, np.full_like(x, 1.0)], axis=1) - 4.0 * np.array(down)
            answer = native.radiance(scene, origins, np.tile(down, (len(x), 1)))
            assert answer.leaks.sum() == 0
            assert np.all(answer.crossings % 2 == 0)


def test_a_set_cancel_flag_stops_the_trace():
    scene = tracer_scenes.bottle()
    cancel = Cancel()
    cancel.set()
    with pytest.raises(Cancelled):
        native.radiance(scene, *tracer_scenes.rays_through(scene, 100, seed=16), cancel=cancel)


def test_cancel_from_another_thread_stops_a_running_trace():
    scene = tracer_scenes.bottle()
    rays = tracer_scenes.rays_through(scene, 400_000, seed=17)
    cancel = Cancel()

    def stop_when_running() -> None:
        while cancel.control.done == 0:
            pass
        cancel.set()

    other = threading.Thread(target=stop_when_running)
    other.start()
    with pytest.raises(Cancelled):
        native.radiance(scene, *rays, cancel=cancel, threads=1)
    other.join()
    assert cancel.control.done < 400_000


@pytest.mark.parametrize("camera", ["pinhole", "telecentric"])
def test_the_film_holds_what_the_cameras_rays_see(camera):
    view = pinhole() if camera == "pinhole" else Telecentric((0.0, -500.0, 150.0), (0.0, 0.0, 150.0), height_mm=330.0)
    scene = Scene((), (), (ramp(),), view, size=(40, 20))
    film = Film(40, 20)
    native.NativeScene(scene).image(
        film,
        np.arange(2),
        np.ones((20, 40), dtype=np.uint8),
        tolerance=1e-4,
        halvings=0,
        cutoff=1e-3,
        ambient=np.zeros(3),
        absorption=True,
        threads=2,
        cancel=Cancel(),
    )
    row, column = np.divmod(np.arange(800), 40)
    rays = view.rays((2.0 * column + 1.0 - 40) / 20, 1.0 - (2.0 * row + 1.0) / 20)
    np.testing.assert_allclose(film.radiance, native.radiance(scene, *rays).radiance, atol=2e-3)
    assert film.totals[0] >= 41 * 21


def ramp():
    """An environment that grows linearly from below to above."""
    return Environment(np.broadcast_to(np.linspace(1.0, 0.0, 64)[:, None, None], (64, 128, 3)))


def test_switching_absorption_off_is_a_scene_without_it():
    rays = tracer_scenes.rays_through(tracer_scenes.bottle(), 2000, seed=18)
    off = native.radiance(tracer_scenes.bottle(), *rays, absorption=False)
    clear = native.radiance(tracer_scenes.bottle(absorption=(0.0, 0.0, 0.0)), *rays)
    assert off.radiance.tobytes() == clear.radiance.tobytes()


def test_a_mesh_of_a_ball_approaches_the_ball():
    fine = tracer_scenes.ball_mesh(10.0, rings=200, sectors=400)
    assert isinstance(fine, Mesh)
    rng = np.random.default_rng(19)
    origins = np.column_stack([rng.uniform(-7, 7, (2000, 2)), np.full(2000, 50.0)])
    directions = np.tile([0.0, 0.0, -1.0], (2000, 1))
    media, lights = (Medium("ball", 1.5, (0.02, 0.03, 0.04)),), (tracer_scenes.sky(),)
    exact = Scene((Body("ball", tracer_scenes.revolved_ball(10.0)),), media, lights, pinhole())
    facets = Scene((Body("ball", fine),), media, lights, pinhole())
    difference = (
        native.radiance(exact, origins, directions).radiance - native.radiance(facets, origins, directions).radiance
    )
    assert np.median(np.abs(difference)) < 1e-4


def pinhole():
    return Pinhole((0.0, -500.0, 150.0), (0.0, 0.0, 150.0), 0.6)
