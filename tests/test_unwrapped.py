"""What a line camera sees of a container that turns."""

import dataclasses

import numpy as np
import pytest

from glassworkbench.errors import InputError
from glassworkbench.scanning import unwrapped
from glassworkbench.scene import ContainerGeometry, Mesh, Telecentric
from glassworkbench.staging import sample_container, station
from glassworkbench.tracer import native, render

pytestmark = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")

TOLERANCE = 0.05


def bar():
    """A solid bar, without a cavity; three of its flats are 10 mm from the axis, the one towards +x 14 mm."""
    x, far, z = 10.0, 14.0, 40.0
    corners = np.array([(i, j, k) for k in (0.0, z) for i, j in ((-x, -x), (far, -x), (far, x), (-x, x))])
    sides = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    triangles = [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]
    mesh = Mesh(corners[np.array(triangles)].reshape(-1, 3), np.arange(36).reshape(12, 3))
    return ContainerGeometry(mesh, None, low_mm=(-x, -x, 0), high_mm=(far, x, z), finish_height_mm=z)


def test_a_round_container_costs_one_column_and_shows_it_all_around():
    image = unwrapped(sample_container(), "flint", lines=50, rows=60, tolerance=TOLERANCE)
    assert image.pixels.shape == (60, 50, 3)
    assert np.array_equal(image.pixels, np.repeat(image.pixels[:, :1], 50, axis=1))
    scene = station("unwrapped", sample_container(), "flint", size=(1, 60))
    one = render(scene, tolerance=TOLERANCE)
    assert np.array_equal(one.pixels[:, 0], image.pixels[:, 0])
    assert image.report["size"] == [50, 60]
    # The middle of an area camera's image of the same field is the same column.
    camera = scene.camera
    area = dataclasses.replace(
        scene, camera=Telecentric(camera.origin_mm, camera.target_mm, camera.height_mm, camera.up), size=(21, 60)
    )
    middle = render(area, tolerance=TOLERANCE)
    off = np.abs(middle.pixels[:, 10] - one.pixels[:, 0]).max(axis=1)
    assert np.all(off <= middle.certificate[:, 10] + one.certificate[:, 0] + 0.02)


def test_columns_show_the_angles_from_the_camera_on():
    image = unwrapped(bar(), "flint", lines=8, rows=12, tolerance=TOLERANCE)
    scene = station("unwrapped", bar(), "flint", size=(1, 12))
    assert scene.camera.origin_mm[1] < -14.0
    near = scene.camera.target_mm[1] - scene.camera.origin_mm[1] - image.depth_mm[6]
    # From -90 degrees on, every 45: all are 22.5 degrees from the middle of a flat; the second and third see +x.
    flats = np.array([10.0, 14.0, 14.0, 10.0, 10.0, 10.0, 10.0, 10.0])
    assert np.allclose(near, flats / np.cos(np.radians(22.5)), atol=1e-3)


def test_a_camera_that_is_none_of_lines_is_refused():
    with pytest.raises(InputError, match="its camera sees an area"):
        unwrapped(sample_container(), "flint", name="stripes", lines=10)
    with pytest.raises(InputError, match="lines: expected a whole number"):
        unwrapped(sample_container(), "flint", lines=0)
