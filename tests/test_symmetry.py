"""Which scenes mirror themselves, left for right as the camera sees them."""

from dataclasses import replace

import numpy as np
import pytest
import tracer_scenes

from glassworkbench.scene import Body, Ellipsoid, Environment, Panel, Pinhole, Scene, is_mirror_symmetric
from glassworkbench.tracer import native, render


def before(*lights, bodies=None):
    base = tracer_scenes.bottle()
    camera = Pinhole((0.0, -1000.0, 150.0), (0.0, 0.0, 150.0), 0.32)
    return Scene(bodies or base.bodies, base.media if bodies is None else (), lights, camera, size=(24, 32))


def sky(width, bright_columns):
    radiance = np.full((8, width, 3), 0.1)
    radiance[3:5, bright_columns] = 4.0
    return Environment(radiance)


def test_a_bottle_before_a_centred_panel_mirrors_itself():
    assert is_mirror_symmetric(before(Panel((-80.0, 120.0, -20.0), (160.0, 0.0, 0.0), (0.0, 0.0, 340.0))))


def test_a_panel_may_be_given_from_any_of_its_corners():
    assert is_mirror_symmetric(before(Panel((80.0, 120.0, 320.0), (0.0, 0.0, -340.0), (-160.0, 0.0, 0.0))))


@pytest.mark.parametrize("origin", [(-79.9, 120.0, -20.0), (-80.0, 120.0, -20.0)])
def test_a_panel_to_one_side_or_askew_does_not(origin):
    askew = Panel(origin, (160.0, 1.0 if origin[0] == -80.0 else 0.0, 0.0), (0.0, 0.0, 340.0))
    assert not is_mirror_symmetric(before(askew))


@pytest.mark.parametrize(
    ("columns", "expected"), [([11], False), ([11, 12], True), ([8, 15], True), ([3, 4], True), ([8, 10], False)]
)
def test_a_map_mirrors_itself_about_the_plane_of_the_camera(columns, expected):
    # The camera looks along azimuth 90 degrees, the middle between columns 11 and 12 of 16.
    assert is_mirror_symmetric(before(sky(16, columns))) is expected


def test_a_turned_ellipsoid_mirrors_itself_only_about_its_own_planes():
    angle = 0.3
    about_x = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    about_z = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    for rotation, expected in ((about_x, True), (about_z, False)):
        bubble = Body("bubble", Ellipsoid((0.0, 5.0, 100.0), (1.0, 2.0, 3.0), rotation))
        assert is_mirror_symmetric(before(bodies=(bubble,))) is expected


@pytest.mark.skipif(not native.available(), reason="the native tracer is not built")
def test_an_environment_that_mirrors_itself_gives_the_image_of_its_whole():
    scene = before(sky(16, [12, 11]))
    assert is_mirror_symmetric(scene)
    uneven = sky(16, [12, 11]).radiance.copy()
    uneven[0, 0] += 1e-9
    half, whole = render(scene, tolerance=0.2), render(replace(scene, lights=(Environment(uneven),)), tolerance=0.2)
    assert (half.report["mirrored"], whole.report["mirrored"]) == (True, False)
    difference = np.abs(half.pixels - whole.pixels).max(axis=2)
    assert np.mean(difference <= half.certificate + whole.certificate) >= 0.99
