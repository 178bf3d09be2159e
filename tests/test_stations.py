import itertools

import numpy as np
import pytest

from glassworkbench.errors import InputError
from glassworkbench.glass import find_filling, find_glass
from glassworkbench.scene import ContainerGeometry, Environment, Panel, Revolved
from glassworkbench.scene.cameras import camera_frame
from glassworkbench.staging import Fill, parse_fill, station, stations
from glassworkbench.staging.sky import sky_light

PROPORTIONS = {"bottle": (38.0, 300.0), "dish": (120.0, 40.0), "ampoule": (5.0, 200.0)}


def cylinder(radius, low, high):
    corners = np.array([(0.0, low), (radius, low), (radius, high), (0.0, high)])
    steps = np.linspace(0.0, 1.0, 4)[None, :, None]
    lines = corners[:-1, None] * (1.0 - steps) + corners[1:, None] * steps
    return Revolved(np.concatenate([lines, np.ones((3, 4, 1))], axis=2))


def container(radius, height):
    return ContainerGeometry(
        outer=cylinder(radius, 0.0, height),
        cavity=cylinder(0.9 * radius, 0.05 * height, 1.1 * height),
        low_mm=(-radius, -radius, 0.0),
        high_mm=(radius, radius, height),
        finish_height_mm=height,
    )


BOTTLE = container(*PROPORTIONS["bottle"])


def image_positions(scene, points):
    """Where points (n, 3) appear, in half image heights from the centre."""
    camera = scene.camera
    side, above, ahead = camera_frame(camera) @ (points - camera.origin_mm).T
    return np.stack([side, above]) / ahead / np.tan(0.5 * camera.vertical_field_of_view_rad)


@pytest.mark.parametrize("size", [(480, 640), (640, 480), (100, 400)])
@pytest.mark.parametrize("shape", PROPORTIONS)
@pytest.mark.parametrize("name", ["studio", "sidewall"])
def test_the_container_fills_the_image_and_fits(name, shape, size):
    geometry = container(*PROPORTIONS[shape])
    scene = station(name, geometry, "emerald", size=size)
    corners = np.array(list(itertools.product(*zip(geometry.low_mm, geometry.high_mm, strict=True))))
    x, y = image_positions(scene, corners)
    reach = max(np.abs(x).max() / (size[0] / size[1]), np.abs(y).max())
    assert 0.88 < reach < 0.96


@pytest.mark.parametrize("shape", PROPORTIONS)
def test_the_sidewall_panel_stands_behind_the_whole_container(shape):
    geometry = container(*PROPORTIONS[shape])
    (panel,) = station("sidewall", geometry, "flint").lights
    assert isinstance(panel, Panel)
    far = panel.origin_mm + panel.u_mm + panel.v_mm
    assert panel.origin_mm[1] == far[1] > geometry.high_mm[1]
    assert np.all(panel.origin_mm[[0, 2]] < geometry.low_mm[[0, 2]])
    assert np.all(far[[0, 2]] > geometry.high_mm[[0, 2]])


def test_the_sidewall_is_mirror_symmetric_about_the_axis():
    scene = station("sidewall", BOTTLE, "flint")
    assert scene.camera.origin_mm[0] == scene.camera.target_mm[0] == 0.0
    (panel,) = scene.lights
    assert panel.origin_mm[0] == -(panel.origin_mm + panel.u_mm)[0]


def test_the_studio_is_lit_from_all_around_and_brightest_in_its_soft_boxes():
    (light,) = station("studio", BOTTLE, "flint").lights
    assert isinstance(light, Environment)
    assert light.radiance.shape == (512, 1024, 3)
    assert light.radiance.min() > 0.1
    assert light.radiance.max() > 5.0 * np.median(light.radiance)


def test_studio_light_follows_its_formula():
    box = {"azimuth_deg": 170, "elevation_deg": 20, "half_width_deg": 22, "half_height_deg": 35}
    box |= {"softness_deg": 1.5, "radiance": (6, 6, 6)}
    light = sky_light((0.1, 0.1, 0.1), (1.0, 1.0, 1.0), (box,), rows=180)
    # Row 70 is at 19.5 degrees of elevation; column 5 at -174.5 degrees of azimuth, across the seam from 170.
    height = 0.5 + 0.5 * np.sin(np.radians(19.5))
    blend = height**2 * (3 - 2 * height)
    box_light = 6 / (1 + np.exp(-(22 - 15.5) / 1.5)) / (1 + np.exp(-(35 - 0.5) / 1.5))
    assert np.allclose(light[70, 5], 0.1 * (1 - blend) + blend + box_light, rtol=1e-12)


def test_media_come_from_glass_and_filling():
    scene = station("studio", BOTTLE, find_glass("amber"), Fill(find_filling("water"), 200.0))
    assert [body.name for body in scene.bodies] == ["outer", "cavity", "fill"]
    assert [medium.where for medium in scene.media] == ["outer and not cavity", "cavity and fill"]
    assert scene.refractive_indices() == pytest.approx([1.0, 1.52338, 1.33340], abs=5e-6)
    table = scene.medium_table()
    inside = {"outer": 1, "cavity": 2, "fill": 4}
    assert table[inside["outer"]] == table[inside["outer"] | inside["fill"]] == 1
    assert table[inside["outer"] | inside["cavity"] | inside["fill"]] == 2
    assert table[inside["outer"] | inside["cavity"]] == table[inside["fill"]] == 0
    told = {"glass": "amber", "station": "studio", "fill": "water:200"}
    assert told.items() <= scene.metadata.items()


def test_a_filling_reaches_past_the_cavity_up_to_its_level():
    fill = station("studio", BOTTLE, "flint", "water:150").bodies[2].surface
    r, z = fill.meridian[..., 0], fill.meridian[..., 1]
    assert z.max() == 150.0
    assert z.min() < 0.0
    assert r.max() > 38.0


def test_a_fill_is_read_as_it_is_written():
    assert str(parse_fill("water")) == "water"
    assert str(parse_fill("water:120")) == "water:120"
    assert parse_fill("water:120mm").level_mm == 120.0


@pytest.mark.parametrize(
    ("fill", "message"),
    [
        ("wter", "did you mean 'water'"),
        ("wter:3", "did you mean 'water'"),
        ("water:x", "expected a height in mm, as water:180, got 'x'"),
        ("water:", "expected a height in mm"),
        ("water:0", "above 0"),
        ("water:-3", "above 0"),
        ("water:nan", "finite"),
        ("water:300", "below the finish at 300 mm"),
    ],
)
def test_an_impossible_fill_is_refused(fill, message):
    with pytest.raises(InputError, match=message):
        station("studio", BOTTLE, "flint", fill)


def test_stations_are_described_and_an_unknown_one_suggests_the_nearest():
    assert next(iter(stations())) == "studio"
    assert {"sidewall", "dark_field", "gradient", "stripes", "base", "finish"} <= set(stations())
    assert all(stations().values())
    with pytest.raises(InputError, match="0x10 pixels"):
        station("studio", BOTTLE, "flint", size=(0, 10))
    with pytest.raises(InputError, match="did you mean 'sidewall'"):
        station("side_wall", BOTTLE, "flint")
    with pytest.raises(InputError, match="did you mean 'emerald'"):
        station("studio", BOTTLE, "emeral")
