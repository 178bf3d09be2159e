"""The polyline of a ray, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
import tracer_scenes

from glassworkbench.errors import InputError
from glassworkbench.scene import Body, Environment, Medium, Panel, Pinhole, Scene
from glassworkbench.tracer import native, reference
from glassworkbench.tracer.path import ray_path

INDEX = 1.5
CAMERA = Pinhole((0.0, -200.0, 0.0), (0.0, 0.0, 0.0), 0.3)


def block(*lights):
    body = Body("block", tracer_scenes.box_mesh((-50.0, -10.0, -50.0), (50.0, 10.0, 50.0)))
    return Scene((body,), (Medium("block", INDEX),), lights, CAMERA)


def test_a_slab_shifts_a_ray_and_leaves_its_direction():
    path = ray_path(block(Environment(1.0)), (-40.0, -100.0, 0.0), (1.0, 2.0, 0.0))
    assert len(path.points_mm) == 4
    inside = np.arcsin(np.sin(np.arctan(0.5)) / INDEX)
    np.testing.assert_allclose(path.points_mm[1], (5.0, -10.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(path.points_mm[2], (5.0 + 20.0 * np.tan(inside), 10.0, 0.0), atol=1e-12)
    last = path.points_mm[3] - path.points_mm[2]
    np.testing.assert_allclose(last / np.linalg.norm(last), np.array([1.0, 2.0, 0.0]) / np.sqrt(5.0), atol=1e-12)
    assert path.panel is None
    assert [(c.medium_before, c.medium_after) for c in path.crossings] == [(0, 1), (1, 0)]
    assert not path.is_reflected().any()


def test_a_ray_that_enters_a_block_by_its_side_is_totally_reflected_within():
    path = ray_path(block(), (-60.0, 0.0, 0.0), (2.0, 1.0, 0.0))
    inside = np.arcsin(np.sin(np.arctan(0.5)) / INDEX)
    reflected = path.is_reflected()
    assert reflected.tolist() == [False, False, *[True] * (len(reflected) - 3), False]
    # It rises 5 mm before the block, and is folded at the two faces, 20 mm apart.
    unfolded = np.arange(len(path.crossings) - 2) * 20.0 + 5.0
    np.testing.assert_allclose(path.points_mm[2:-2, 0], -50.0 + unfolded / np.tan(inside), atol=1e-9)
    np.testing.assert_allclose(np.abs(path.points_mm[2:-2, 1]), 10.0, atol=1e-9)


def test_a_path_ends_at_the_first_panel():
    far = Panel((-500.0, 90.0, -500.0), (1000.0, 0.0, 0.0), (0.0, 0.0, 1000.0))
    near = Panel((-50.0, 60.0, -50.0), (100.0, 0.0, 0.0), (0.0, 0.0, 100.0))
    path = ray_path(block(far, Environment(1.0), near), (0.0, -100.0, 0.0), (0.0, 1.0, 0.0))
    assert path.panel == 2
    np.testing.assert_allclose(path.points_mm[-1], (0.0, 60.0, 0.0), atol=1e-12)
    before = ray_path(block(replace(near, origin_mm=(-50.0, -60.0, -50.0))), (0.0, -100.0, 0.0), (0.0, 1.0, 0.0))
    assert before.panel == 0
    assert before.crossings == ()


def test_a_ray_through_nothing_leaves_straight():
    path = ray_path(block(), (0.0, -100.0, 70.0), (0.0, 3.0, 0.0))
    assert path.crossings == ()
    assert path.points_mm[1][1] > 100.0
    np.testing.assert_allclose(path.points_mm[1][[0, 2]], (0.0, 70.0), atol=1e-12)


@pytest.mark.skipif(not native.available(), reason="the native tracer is not built")
def test_the_interfaces_are_those_that_follow_gives():
    scene = tracer_scenes.bottle(fill=True)
    origin, direction = (3.0, -400.0, 90.0), (0.01, 1.0, 0.02)
    path = ray_path(scene, origin, direction)
    for follow in (native.follow, reference.follow):
        crossings = follow(replace(scene, lights=()), origin, direction)
        points = [crossing.point_mm for crossing in crossings]
        np.testing.assert_allclose(path.points_mm[1:-1], points[: len(path.crossings)], atol=1e-9)
        media = [(crossing.medium_before, crossing.medium_after) for crossing in crossings]
        assert [(c.medium_before, c.medium_after) for c in path.crossings] == media[: len(path.crossings)]


@pytest.mark.parametrize("direction", [(0.0, 0.0, 0.0), (0.0, float("nan"), 1.0), (0.0, 1.0)])
def test_an_impossible_direction_is_refused(direction):
    with pytest.raises(InputError, match="direction"):
        ray_path(block(), (0.0, -100.0, 0.0), direction)
