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

pytestmark = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")


@pytest.fixture
def scene():
    panel = Panel((-80.0, 120.0, -20.0), (160.0, 0.0, 0.0), (0.0, 0.0, 340.0))
    return replace(
        tracer_scenes.bottle(lights=(panel,)),
        camera=Pinhole((0.0, -1000.0, 150.0), (0.0, 0.0, 150.0), 0.32),
        size=(48, 64),
    )


def fine_truth(scene, samples=512):
    """Means of many samples with a tiny cut-off: what the image converges to."""
    film = Film(*scene.size)
    pixels = np.arange(film.samples.size)
    native.NativeScene(scene).sample(film, pixels, samples, cutoff=1e-4, absorption=True, threads=2, cancel=Cancel())
    return film.mean().reshape(scene.size[1], scene.size[0], 3)


@pytest.mark.parametrize("tolerance", [0.1, 0.02])
def test_the_true_error_lies_under_the_certificate(scene, tolerance):
    image = render(scene, tolerance=tolerance)
    error = np.abs(image.pixels - fine_truth(scene)).max(axis=2)
    assert np.mean(error <= image.certificate) >= 0.99


def test_a_smaller_tolerance_gives_a_smaller_error(scene):
    truth = fine_truth(scene)
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
    assert passes == sorted(passes)
    assert passes[0] == 48 * 64
    assert image.report["camera_rays"] > passes[-1]


def test_time_ends_the_refinement_after_the_first_pass(scene):
    image = render(scene, seconds=1e-6)
    assert image.report["camera_rays"] == 48 * 64


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
    pixels = np.arange(108)
    films = []
    for engine in (native.NativeScene(small), ReferenceScene(small)):
        film = Film(9, 12)
        engine.sample(film, pixels, 2, cutoff=1e-2, absorption=absorption, threads=1, cancel=Cancel())
        films.append(film)
    mine, truth = films
    # Single paths of many bounces amplify rounding; test_native compares them ray by ray.
    assert np.mean(np.abs(mine.mean() - truth.mean()) <= 1e-10) >= 0.97
    assert np.mean(np.abs(mine.pruned() - truth.pruned()) <= 1e-10) >= 0.97
    assert (mine.rays, mine.leaks) == (truth.rays, truth.leaks)


def test_without_the_native_core_the_reference_runs_and_says_so_once(scene, monkeypatch):
    monkeypatch.setattr(native, "available", lambda: False)
    small = replace(scene, size=(3, 4))
    with pytest.warns(RuntimeWarning, match="make build"):
        slow = render(small, tolerance=0.5)
    monkeypatch.undo()
    np.testing.assert_allclose(slow.pixels, render(small, tolerance=0.5).pixels, atol=1e-8)
