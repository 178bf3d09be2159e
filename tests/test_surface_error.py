"""What approximate surfaces add to a pixel's error, against the image of the surfaces they stand for."""

from dataclasses import replace

import numpy as np
import pytest
import tracer_scenes
from patch_bodies import ball_patches, pebble_patches

from glassworkbench.errors import InputError
from glassworkbench.scene import Body, Environment, Medium, Mesh, Panel, Pinhole, Scene, Telecentric
from glassworkbench.tracer import native, render
from glassworkbench.tracer.part import Part
from glassworkbench.tracer.surface_error import surface_error

pytestmark = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")

SIZE = 48, 48


def ball(surface, light=None):
    return Scene(
        (Body("ball", surface),),
        (Medium("ball", 1.5, (0.01, 0.02, 0.005)),),
        (light or tracer_scenes.sky(64, 128, seed=3),),
        Pinhole((0.0, -300.0, 0.0), (0.0, 0.0, 0.0), 0.16),
        size=SIZE,
    )


def probe(scene, origins, directions):
    return native.NativeScene(scene).radiance(origins, directions, cutoff=1e-3).radiance


def estimated(scene, part=None):
    return surface_error(scene, part or Part(0, 0, *scene.size), probe)


@pytest.mark.parametrize("rings", [12, 24, 48])
def test_the_error_of_a_mesh_is_estimated_within_an_order_of_magnitude_and_above_it(rings):
    exact, meshed = ball(tracer_scenes.revolved_ball(20.0)), ball(tracer_scenes.ball_mesh(20.0, rings, 2 * rings))
    truth, image = (render(scene, tolerance=0.01) for scene in (exact, meshed))
    error = np.abs(image.pixels - truth.pixels).max(axis=2)
    assert np.mean(error <= image.certificate + truth.certificate) >= 0.99
    seen = np.isfinite(truth.depth_mm)
    told = image.report["certificate"]["surface"] * seen.size / seen.sum()
    assert error[seen].mean() < told < 15.0 * error[seen].mean()


def test_a_finer_mesh_has_a_smaller_error():
    coarse, fine = (estimated(ball(tracer_scenes.ball_mesh(20.0, rings, 2 * rings))) for rings in (12, 48))
    assert fine.mean() < 0.4 * coarse.mean()


def test_averaged_normals_are_less_trusted_than_those_of_the_surface():
    given = tracer_scenes.ball_mesh(20.0, 24, 48)
    averaged = Mesh(given.vertices_mm, given.triangles)
    assert averaged.has_averaged_normals
    assert averaged.placed(np.eye(3), np.ones(3)).has_averaged_normals
    assert not given.has_averaged_normals
    assert estimated(ball(averaged)).mean() > 1.5 * estimated(ball(given)).mean()


def test_exact_surfaces_and_flat_meshes_have_none():
    for surface in (tracer_scenes.revolved_ball(20.0), ball_patches(20.0), tracer_scenes.box_mesh((-9,) * 3, (9,) * 3)):
        assert not estimated(ball(surface)).any()
        assert render(ball(surface), tolerance=0.2).report["certificate"]["surface"] == 0.0


def test_in_uniform_light_a_lossless_mesh_has_none():
    scene = ball(tracer_scenes.ball_mesh(20.0), Environment(1.0))
    clear = replace(scene, media=(Medium("ball", 1.5),))

    def all_light(seen, origins, directions):
        answer = native.NativeScene(seen).radiance(origins, directions, cutoff=1e-3)
        return answer.radiance + answer.left_out

    assert surface_error(clear, Part(0, 0, *SIZE), all_light).max() < 1e-9


def test_an_edge_in_the_image_counts_as_its_height_times_how_far_it_moves():
    # An opaque ball before a white panel: all that can change is its outline, by the mesh's distance from the ball.
    mesh = tracer_scenes.ball_mesh(20.0, 24, 48)
    panel = Panel((-100.0, 60.0, -100.0), (200.0, 0.0, 0.0), (0.0, 0.0, 200.0))
    scene = replace(ball(mesh, panel), media=(Medium("ball", 1.0, (50.0,) * 3),))
    scene = replace(scene, camera=Telecentric((0.0, -300.0, 0.0), (0.0, 0.0, 0.0), 48.0))
    # A side of the outline spans 7.5 degrees; it moves by half its sagitta on average. Pixels are 1 mm wide.
    moved_mm2 = 2.0 * np.pi * 20.0 * 20.0 * (1.0 - np.cos(np.pi / 48.0))
    total = estimated(scene).sum()
    assert 0.5 * moved_mm2 < total < 8.0 * moved_mm2


def test_patches_tell_their_own_error():
    exact = pebble_patches()
    scene = ball(exact)
    small, large = (estimated(ball(replace(exact, surface_error_mm=error))) for error in (1e-4, 1e-2))
    assert not estimated(scene).any()
    assert 0.0 < small.mean() < 0.1 * large.mean()
    assert exact.placed(np.eye(3), np.zeros(3)).surface_error_mm == 0.0
    assert replace(exact, surface_error_mm=0.1).placed(np.eye(3), np.ones(3)).surface_error_mm == 0.1
    for error in (-1.0, float("nan")):
        with pytest.raises(InputError, match="surface_error_mm"):
            replace(exact, surface_error_mm=error)


def test_a_crop_has_the_errors_of_the_whole():
    scene = ball(tracer_scenes.ball_mesh(20.0))
    whole = estimated(scene)
    for left, top, width, height in ((0, 0, 1, 1), (13, 7, 20, 11), (20, 30, 28, 18)):
        part = estimated(scene, Part(left, top, width, height))
        assert np.array_equal(part, whole[top : top + height, left : left + width])
