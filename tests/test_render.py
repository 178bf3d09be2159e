"""Rendering: passes, tolerance, time, cancel, and the certificate."""

import json
from dataclasses import replace

import numpy as np
import pytest
import tracer_scenes

from glassworkbench.errors import Cancelled, InputError
from glassworkbench.scene import Panel, Pinhole, Telecentric
from glassworkbench.tracer import Cancel, native, plan, render
from glassworkbench.tracer.film import Film
from glassworkbench.tracer.reference_film import ReferenceScene
from glassworkbench.tracer.tiles import tile_count

pytestmark = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")


def bottle_before_a_panel():
    panel = Panel((-80.0, 120.0, -20.0), (160.0, 0.0, 0.0), (0.0, 0.0, 340.0))
    return replace(
        tracer_scenes.bottle(lights=(panel,)),
        camera=Pinhole((0.0, -1000.0, 150.0), (0.0, 0.0, 150.0), 0.32),
        size=(48, 64),
    )


@pytest.fixture
def scene():
    return bottle_before_a_panel()


@pytest.fixture(scope="module")
def truth_and_doubt():
    return fine_truth(bottle_before_a_panel())


def fine_truth(scene, side=16):
    """What the image converges to, from a jittered grid of rays with a tiny cut-off, and how well that is known.

    An edge of height h through a pixel leaves about h n^(-3/4) / 2 (Mitchell 1996); twice that covers most.
    """
    width, height = scene.size
    engine = native.NativeScene(scene)
    row, column = np.divmod(np.arange(width * height), width)
    random = np.random.default_rng(5)
    values = []
    for step in range(side * side):
        x = column + (step % side + random.random(len(row))) / side
        y = row + (step // side + random.random(len(row))) / side
        rays = scene.camera.rays((2.0 * x - width) / height, 1.0 - 2.0 * y / height)
        values.append(engine.radiance(*rays, cutoff=1e-4).radiance)
    doubt = np.ptp(values, axis=0).max(axis=1) * side**-1.5 + 1e-12
    return np.mean(values, axis=0).reshape(height, width, 3), doubt.reshape(height, width)


@pytest.mark.parametrize("tolerance", [0.1, 0.02])
def test_the_true_error_lies_under_the_certificate(scene, truth_and_doubt, tolerance):
    image = render(scene, tolerance=tolerance)
    truth, doubt = truth_and_doubt
    error = np.abs(image.pixels - truth).max(axis=2)
    assert np.mean(error <= image.certificate + doubt) >= 0.99


def test_a_smaller_tolerance_gives_a_smaller_error(scene, truth_and_doubt):
    truth, _ = truth_and_doubt
    coarse, fine = render(scene, tolerance=0.2), render(scene, tolerance=0.01)
    assert np.abs(fine.pixels - truth).mean() < 0.5 * np.abs(coarse.pixels - truth).mean()
    assert fine.report["camera_rays"] > coarse.report["camera_rays"]


def test_threads_and_repetition_do_not_change_a_byte(scene):
    one, two, again = render(scene, threads=1), render(scene, threads=2), render(scene, threads=2)
    assert one.pixels.tobytes() == two.pixels.tobytes() == again.pixels.tobytes()
    assert one.certificate.tobytes() == two.certificate.tobytes()


def test_passes_arrive_finer_and_finer_and_progress_never_falls(scene):
    shares, passes = [], []
    image = render(scene, progress=shares.append, on_pass=lambda picture: passes.append(picture.report["camera_rays"]))
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert len(passes) == 1
    assert image.report["camera_rays"] > 2 * passes[0]


def test_looking_on_does_not_change_the_image(scene):
    watched = render(scene, on_pass=lambda picture: None)
    assert watched.pixels.tobytes() == render(scene).pixels.tobytes()


def test_time_ends_the_refinement_after_the_first_pass(scene):
    image = render(scene, seconds=1e-6)
    assert np.all(np.isfinite(image.certificate))
    assert image.report["camera_rays"] < render(scene, tolerance=0.02).report["camera_rays"]


def test_a_mirror_symmetric_scene_is_traced_by_half_and_says_so(scene):
    whole = replace(scene, lights=[*scene.lights, Panel((500.0, 50.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1e-9)])
    half, full = render(scene), render(whole)
    assert half.report["mirrored"]
    assert not full.report["mirrored"]
    assert half.report["camera_rays"] < 0.6 * full.report["camera_rays"]
    assert half.pixels.tobytes() == half.pixels[:, ::-1].tobytes()
    assert np.mean(np.abs(half.pixels - full.pixels).max(axis=2) <= half.certificate + full.certificate) >= 0.99


def test_a_cancelled_tile_stops_between_two_rays(scene):
    cancel = Cancel()
    film = Film(*scene.size)
    cancel.set()
    with pytest.raises(Cancelled):
        native.NativeScene(scene).image(
            film,
            np.arange(tile_count(*scene.size)),
            np.ones((64, 48), dtype=np.uint8),
            tolerance=1e-6,
            halvings=0,
            cutoff=1e-6,
            ambient=np.zeros(3),
            absorption=True,
            threads=1,
            cancel=cancel,
        )
    assert film.totals[0] == 0


def test_a_cancelled_rendering_raises_and_returns_nothing(scene):
    cancel = Cancel()
    with pytest.raises(Cancelled):
        render(scene, cancel=cancel, on_pass=lambda picture: cancel.set())


def test_report_has_the_agreed_keys_and_is_json(scene):
    report = json.loads(json.dumps(render(scene).report))
    assert {
        "seconds",
        "set_up_seconds",
        "size",
        "threads",
        "tolerance",
        "certificate",
        "effects",
        "camera_rays",
        "intersections",
        "leaks",
        "mirrored",
        "version",
    } <= set(report)
    assert {"pruned", "sampling", "surface", "total_p50", "total_p99", "total_max"} == set(report["certificate"])
    assert report["size"] == [48, 64]
    assert report["leaks"] == 0


def test_absorption_is_traced_only_where_it_can_be_seen(scene):
    clear = replace(scene, media=[replace(medium, absorption_per_mm=(1e-8,) * 3) for medium in scene.media])
    assert plan(scene, 0.01).is_on("absorption")
    assert not plan(clear, 0.01).is_on("absorption")
    assert plan(clear, 1e-6).is_on("absorption")
    assert "mm" in plan(clear, 0.01).effects[0].why


def test_a_user_may_overrule_the_plan(scene):
    assert not plan(scene, 0.01, {"absorption": False}).is_on("absorption")
    with pytest.raises(InputError, match="absorption"):
        plan(scene, 0.01, {"absorbtion": True})


@pytest.mark.parametrize("tolerance", [0.0, -1.0, float("nan"), float("inf")])
def test_an_impossible_tolerance_is_refused(scene, tolerance):
    with pytest.raises(InputError, match="tolerance"):
        render(scene, tolerance=tolerance)


@pytest.mark.parametrize(("name", "value"), [("seconds", 0.0), ("seconds", -1.0), ("threads", 0)])
def test_an_impossible_setting_is_refused(scene, name, value):
    with pytest.raises(InputError, match=name):
        render(scene, **{name: value})


@pytest.mark.parametrize("absorption", [True, False])
def test_the_reference_fills_the_same_film(scene, absorption):
    small = replace(scene, size=(9, 12), camera=Telecentric((0.0, -500.0, 150.0), (0.0, 0.0, 150.0), 330.0))
    films = []
    for engine in (native.NativeScene(small), ReferenceScene(small)):
        film = Film(9, 12)
        engine.image(
            film,
            np.arange(1),
            np.ones((12, 9), dtype=np.uint8),
            tolerance=0.05,
            halvings=3,
            cutoff=1e-2,
            ambient=np.array([0.3, 0.4, 0.3]),
            absorption=absorption,
            threads=1,
            cancel=Cancel(),
        )
        films.append(film)
    mine, truth = films
    np.testing.assert_array_equal(mine.depth_mm, truth.depth_mm)
    difference = np.abs(mine.radiance - truth.radiance).max(axis=1)
    assert np.mean(difference <= mine.error + truth.error) >= 0.97
    assert mine.totals[2] == truth.totals[2] == 0


def test_without_the_native_core_the_reference_runs_and_says_so_once(scene, monkeypatch):
    monkeypatch.setattr(native, "available", lambda: False)
    small = replace(scene, size=(3, 4))
    with pytest.warns(RuntimeWarning, match="make build"):
        slow = render(small, tolerance=0.2)
    monkeypatch.undo()
    fast = render(small, tolerance=0.2)
    difference = np.abs(slow.pixels - fast.pixels).max(axis=2)
    assert np.all(difference <= slow.certificate + fast.certificate)
