"""Stations as a user describes them in files."""

import dataclasses

import numpy as np
import pytest

from glassworkbench.errors import InputError
from glassworkbench.scene import Panel, Pinhole, Telecentric
from glassworkbench.scene.cameras import camera_frame
from glassworkbench.scene.image_scale import ImageScale, image_scale
from glassworkbench.staging import Pose, sample_container, station, stations
from glassworkbench.staging.optics import lens

PANEL = '[[light]]\nkind = "panel"\ngap_mm = 40\nmargin_mm = 30\n'
LENS = """kind = "pinhole"
sensor_mm = [9.0, 12.0]
pixels = [900, 1200]
focal_length_mm = 25
working_distance_mm = 400
"""


@pytest.fixture
def placed(tmp_path):
    """A function that returns the scene of the tumbler at a station of these lines."""

    def place(camera, light=PANEL, rest="", **options):
        path = tmp_path / "mine.toml"
        path.write_text(f'description = "mine"\n[camera]\n{camera}\n{light}\n{rest}')
        return station(str(path), sample_container(), "flint", **options)

    return place


def pixel_of(scene, point_mm):
    """Where a point appears, by looking for the image point whose ray passes nearest to it."""
    width, height = scene.size
    low, high = np.array([0.0, 0.0]), np.array([width, height], dtype=float)
    for _ in range(12):
        column, row = np.meshgrid(np.linspace(low[0], high[0], 33), np.linspace(low[1], high[1], 33))
        origins, directions = scene.camera.rays((2 * column.ravel() - width) / height, 1 - 2 * row.ravel() / height)
        off = np.linalg.norm(np.cross(point_mm - origins, directions), axis=1)
        best = np.array([column.ravel()[off.argmin()], row.ravel()[off.argmin()]])
        low, high = best - (high - low) / 8, best + (high - low) / 8
    return best


def test_a_lens_gives_the_field_that_its_maker_tells(placed):
    scene = placed(LENS)
    # The maker's formula: the field is (a - f) / f times the sensor.
    assert isinstance(scene.camera, Pinhole)
    assert scene.size == (900, 1200)
    assert np.linalg.norm(scene.camera.origin_mm - scene.camera.target_mm) == pytest.approx(400)
    field = 2 * 400 * np.tan(0.5 * scene.camera.vertical_field_of_view_rad)
    assert field == pytest.approx(12.0 * (400 - 25) / 25)


def test_two_of_focal_length_magnification_and_working_distance_tell_the_third():
    sensor, pixels = (9.0, 12.0), (900, 1200)
    whole = lens(sensor, pixels, focal_length_mm=25, working_distance_mm=400)
    for given in (
        {"focal_length_mm": 25, "magnification": whole.magnification},
        {"working_distance_mm": 400, "magnification": whole.magnification},
    ):
        other = lens(sensor, pixels, **given)
        assert other.focal_length_mm == pytest.approx(25)
        assert other.working_distance_mm == pytest.approx(400)
    image_mm = whole.magnification * 400
    assert 1 / 400 + 1 / image_mm == pytest.approx(1 / 25)


def test_blur_is_what_rays_from_the_edge_of_the_aperture_leave():
    optics = lens((9.0, 12.0), (900, 1200), focal_length_mm=25, working_distance_mm=400, f_number=5)
    edges = np.array([-2.5, 2.5])
    # A point 30 mm before the focus: rays through it from the aperture's edges, followed to the plane of focus.
    at_focus = edges + (0.0 - edges) * 400 / 370
    assert optics.blur_px(30) == pytest.approx(np.ptp(at_focus) / optics.pixel_mm)


def test_a_blur_that_is_not_traced_is_told(placed):
    assert "blurred by" in placed(LENS + "f_number = 2.8").metadata["notes"]
    assert "notes" not in placed(LENS + "f_number = 32").metadata


def test_a_telecentric_lens_sees_the_sensor_over_the_magnification(placed):
    scene = placed(
        'kind = "telecentric"\nsensor_mm = [9, 12]\npixels = [90, 120]\nmagnification = 0.1\nworking_distance_mm = 200'
    )
    assert isinstance(scene.camera, Telecentric)
    assert scene.camera.height_mm == pytest.approx(120)


@pytest.mark.parametrize("name", ["sidewall", "studio", "stripes"])
def test_the_scale_says_where_axis_and_base_are(name):
    scene = station(name, sample_container(), "flint", size=(300, 400))
    scale = image_scale(scene.camera, scene.size)
    assert ImageScale.from_metadata(scene.metadata).px_per_mm == pytest.approx(scale.px_per_mm, rel=1e-6)
    middle = scene.camera.target_mm[2]
    axis = pixel_of(scene, np.array([0.0, 0.0, middle]))
    aside = pixel_of(scene, np.array([0.0, 0.0, middle]) + camera_frame(scene.camera)[0])
    assert axis[0] == pytest.approx(scale.axis_column, abs=1e-3)
    assert aside[0] - axis[0] == pytest.approx(scale.px_per_mm, rel=1e-3)
    assert scale.place(*axis, 40.0)[0] == pytest.approx(middle, abs=0.01)


@pytest.mark.parametrize("angle", [-90.0, -60.0, -120.0])
def test_a_place_seen_from_the_side_has_its_height_and_angle(angle):
    scene = station("stripes", sample_container(), "flint", size=(300, 400))
    point = np.array([38 * np.cos(np.radians(angle)), 38 * np.sin(np.radians(angle)), 20.0])
    height, seen = ImageScale.from_metadata(scene.metadata).place(*pixel_of(scene, point), 38.0)
    assert height == pytest.approx(20.0, abs=0.01)
    assert seen == pytest.approx(angle % 360, abs=0.05)


@pytest.mark.parametrize("elevation", [90, -90])
@pytest.mark.parametrize("angle", [10.0, 130.0, 250.0])
def test_a_place_seen_from_above_or_below_has_its_angle(placed, elevation, angle):
    scene = placed(f'kind = "telecentric"\nelevation_deg = {elevation}\nazimuth_deg = -70\nview = "base"')
    point = np.array([30 * np.cos(np.radians(angle)), 30 * np.sin(np.radians(angle)), 0.0])
    height, seen = ImageScale.from_metadata(scene.metadata).place(*pixel_of(scene, point), 38.0)
    assert height is None
    assert seen == pytest.approx(angle, abs=0.05)


def test_stripes_have_the_period_asked_and_are_their_own_mirror_image(placed):
    pattern = 'pattern = { kind = "stripes", direction = "vertical", period_mm = 12 }'
    lights = placed('kind = "telecentric"', PANEL + pattern).lights
    middles = np.array([light.origin_mm[2] + 0.5 * light.v_mm[2] for light in lights])
    assert np.allclose(np.diff(middles)[1:-1], 12.0)
    assert np.allclose(middles - 45.0, -(middles - 45.0)[::-1])
    # As much bright as dark, but for the ends.
    assert np.allclose([np.linalg.norm(light.v_mm) for light in lights[1:-1]], 6.0)


def test_a_gradient_grows_from_left_to_right_as_the_camera_sees_it(placed):
    pattern = 'pattern = { kind = "gradient", from = 0.2, to = 0.8, steps = 4 }'
    scene = placed('kind = "telecentric"', PANEL + pattern)
    right = camera_frame(scene.camera)[0]
    places = [(light.origin_mm + 0.5 * light.u_mm) @ right for light in scene.lights]
    assert np.all(np.diff(places) > 0)
    assert np.allclose([light.radiance[0] for light in scene.lights], [0.2, 0.4, 0.6, 0.8])


@pytest.mark.parametrize("size", [(480, 640), (640, 200)])
def test_no_straight_ray_of_the_dark_field_meets_its_light(size):
    scene = station("dark_field", sample_container(), "flint", size=size)
    width, height = scene.size
    x, y = np.meshgrid(np.linspace(-1, 1, 21) * width / height, np.linspace(-1, 1, 21))
    origins, directions = scene.camera.rays(x.ravel(), y.ravel())
    for panel in scene.lights:
        assert isinstance(panel, Panel)
        normal = np.cross(panel.u_mm, panel.v_mm)
        there = origins + ((panel.origin_mm - origins) @ normal / (directions @ normal))[:, None] * directions
        along = [(there - panel.origin_mm) @ edge / (edge @ edge) for edge in (panel.u_mm, panel.v_mm)]
        assert not np.any((along[0] > 0) & (along[0] < 1) & (along[1] > 0) & (along[1] < 1))


def test_a_pose_turns_tilts_and_moves_the_container_and_leaves_the_camera(placed):
    upright = placed('kind = "telecentric"')
    posed = placed(
        'kind = "telecentric"', rest="[container]\ntilt_deg = 10\ntilt_azimuth_deg = 0\noffset_mm = [1, 2, 3]"
    )
    outer = posed.bodies[0].surface
    assert np.allclose(outer.base_mm, [1, 2, 3])
    assert np.allclose(outer.axis, [np.sin(np.radians(10)), 0, np.cos(np.radians(10))])
    assert np.array_equal(posed.camera.origin_mm, upright.camera.origin_mm)
    given = placed('kind = "telecentric"', pose=Pose(tilt_deg=10, offset_mm=(1, 2, 3)))
    assert np.allclose(given.bodies[0].surface.axis, outer.axis)


def test_the_liquid_in_a_tilted_container_stays_level(placed):
    scene = placed('kind = "telecentric"', pose=Pose(tilt_deg=15, offset_mm=(0, 0, 5)), fill="water:40")
    (fill,) = [body.surface for body in scene.bodies if body.name == "fill"]
    assert np.allclose(fill.axis, [0, 0, 1])
    assert fill.base_mm[2] + fill.meridian[..., 1].max() == pytest.approx(45.0)


def test_a_file_in_the_users_folder_joins_the_catalogue(tmp_path, monkeypatch):
    monkeypatch.setenv("GLASSWORKBENCH_STATIONS", str(tmp_path))
    (tmp_path / "line_3.toml").write_text(f'description = "mine"\n[camera]\n{LENS}\n{PANEL}')
    assert stations()["line_3"] == "mine"
    assert station("line_3", sample_container(), "flint").metadata["station"] == "line_3"
    (tmp_path / "line_4.toml").write_text("[camera]\nkind = 3")
    assert stations()["line_4"].startswith("cannot be used: station line_4: the key 'description' is missing")


@pytest.mark.parametrize(
    ("camera", "light", "message"),
    [
        (LENS.replace("400", "20"), PANEL, "20 mm lies inside the focal length of 25 mm"),
        (LENS + "magnification = 0.5", PANEL, "contradicts focal length and working distance"),
        (LENS.replace("[9.0, 12.0]", "[12.0, 12.0]"), PANEL, "only square ones"),
        (LENS.replace("focal_length_mm = 25", ""), PANEL, "give two of"),
        (LENS + "aim_mm = [300, 0, 45]", PANEL, "does not see the container"),
        (LENS + "azimuth_deg = 90", PANEL.replace("gap_mm = 40", "gap_mm = 60"), "a light stands between"),
        (LENS + "margin = 0.1", PANEL, "margin is for a camera fitted to the container"),
        (LENS + "focal_lenght_mm = 3", PANEL, "did you mean 'focal_length_mm'"),
        ('kind = "fisheye"', PANEL, "'fisheye' is not known"),
        ('kind = "pinhole"', PANEL, "give either field_of_view_deg or a distance"),
        ('kind = "telecentric"\nview = "bottom"', PANEL, "there is all, finish, base"),
        ('kind = "telecentric"', PANEL + "gap_sizes = 1", "gap_mm and gap_sizes say the same"),
        ('kind = "telecentric"', PANEL.replace("gap_mm = 40", "gap_mm = -4"), "stand away"),
        ('kind = "telecentric"', '[[light]]\nkind = "lamp"', "'lamp' is not known"),
        ('kind = "telecentric"', PANEL + 'pattern = { kind = "stripes", period_mm = 0.1 }', "stripes are too many"),
        ('kind = "telecentric"', PANEL + 'pattern = { kind = "checks" }', "there is gradient, stripes"),
        ('kind = "telecentric"', PANEL + "radiance = -1", "must not be negative"),
        ('kind = "telecentric"', '[[light]]\nkind = "ring"\ndiameter_mm = 50', "give its diameter, its band"),
    ],
)
def test_an_impossible_station_is_refused_before_rendering(placed, camera, light, message):
    with pytest.raises(InputError, match=message) as told:
        placed(camera, light)
    assert "\n" not in str(told.value)


def test_a_station_can_be_refused_for_a_pose(placed):
    with pytest.raises(InputError, match="does not see the container"):
        placed(LENS, pose=Pose(offset_mm=(500, 0, 0)))
    assert dataclasses.replace(Pose(), tilt_deg=0.0).is_none
