"""Parts of an image: a crop of it, a region refined in it, and a crop put into it."""

from dataclasses import replace

import numpy as np
import pytest
import tracer_scenes

from glassworkbench.errors import InputError
from glassworkbench.images import Image, read_image
from glassworkbench.scene import Environment, Panel, Pinhole
from glassworkbench.tracer import native, render

pytestmark = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")

SIZE = 23, 36


def scene(is_mirrored=True):
    panel = Panel((-80.0, 120.0, -20.0), (160.0, 0.0, 0.0), (0.0, 0.0, 340.0))
    lamp = Panel((500.0, 50.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1e-9)
    return replace(
        tracer_scenes.bottle(lights=(panel,) if is_mirrored else (panel, lamp, Environment(0.2))),
        camera=Pinhole((0.0, -1000.0, 150.0), (0.0, 0.0, 150.0), 0.32),
        size=SIZE,
    )


def same_bytes(image, other):
    return all(
        getattr(image, name).tobytes() == np.ascontiguousarray(getattr(other, name)).tobytes()
        for name in ("pixels", "certificate", "depth_mm")
    )


def cut(image, left, top, width, height):
    rows, columns = slice(top, top + height), slice(left, left + width)
    return Image(image.pixels[rows, columns], image.certificate[rows, columns], image.depth_mm[rows, columns])


@pytest.mark.parametrize("is_mirrored", [True, False])
@pytest.mark.parametrize("crop", [(0, 0, 1, 1), (13, 5, 9, 20), (5, 30, 13, 6)])
def test_a_crop_is_to_the_byte_what_the_whole_image_has_there(is_mirrored, crop):
    seen = scene(is_mirrored)
    part, whole = render(seen, tolerance=0.1, crop=crop), render(seen, tolerance=0.1)
    assert part.report["mirrored"] is is_mirrored
    assert same_bytes(part, cut(whole, *crop))
    assert part.report["camera_rays"] < whole.report["camera_rays"]
    assert part.report["size"] == list(crop[2:])
    assert (part.corner, part.whole) == (crop[:2], SIZE)


@pytest.mark.parametrize("is_mirrored", [True, False])
def test_a_region_is_as_good_as_in_the_whole_image_and_the_rest_is_cheap(is_mirrored):
    seen, region = scene(is_mirrored), (13, 8, 6, 9)
    image, whole = render(seen, tolerance=0.01, region=region), render(seen, tolerance=0.01)
    assert image.pixels.shape == whole.pixels.shape
    assert np.all(np.isfinite(image.certificate))
    assert same_bytes(cut(image, *region), cut(whole, *region))
    assert image.report["region"] == list(region)
    assert image.report["certificate"]["total_max"] == cut(whole, *region).certificate.max()
    assert image.report["camera_rays"] < 0.7 * whole.report["camera_rays"]


def test_against_the_clock_only_the_region_gets_better():
    seen, region = scene(False), (14, 8, 2, 3)
    first, refined = render(seen, seconds=1e-6), render(seen, seconds=60.0, region=region)
    outside = np.ones(first.certificate.shape, dtype=bool)
    outside[8:11, 14:16] = False
    assert np.array_equal(first.pixels[outside], refined.pixels[outside])
    assert refined.certificate[~outside].mean() < first.certificate[~outside].mean()


@pytest.mark.parametrize(
    ("box", "why"),
    [
        ((0, 0, 0, 5), "0x5 pixels"),
        ((20, 0, 4, 5), "do not lie in the image of 23x36"),
        ((-1, 0, 4, 5), "do not lie"),
        ((0.5, 0, 4, 5), "whole numbers"),
        ((0, 0, 4), "x, y, width, height"),
        ("abcd", "x, y, width, height"),
        (7, "x, y, width, height"),
        ((0, 0, float("inf"), 5), "x, y, width, height"),
    ],
)
@pytest.mark.parametrize("name", ["crop", "region"])
def test_an_impossible_part_is_refused(name, box, why):
    with pytest.raises(InputError, match=f"^{name}: .*{why}"):
        render(scene(), **{name: box})


def test_a_region_outside_the_crop_is_refused():
    with pytest.raises(InputError, match=r"region: nothing of .* lies in the crop"):
        render(scene(), crop=(0, 0, 5, 5), region=(6, 6, 5, 5))


def test_a_finer_crop_is_put_into_the_whole_image():
    seen = scene()
    coarse, fine = render(seen, tolerance=0.2), render(seen, tolerance=0.05, crop=(3, 4, 10, 12))
    both = coarse.with_part(fine)
    assert same_bytes(cut(both, 3, 4, 10, 12), fine)
    assert np.array_equal(both.pixels[20:], coarse.pixels[20:])
    assert [part["crop"] for part in both.report["parts"]] == [[3, 4, 10, 12]]
    other = render(replace(seen, size=(24, 36)), tolerance=0.2, crop=(3, 4, 10, 12))
    with pytest.raises(InputError, match="part"):
        coarse.with_part(other)


def test_an_exr_file_tells_where_in_the_whole_a_crop_lies(tmp_path):
    part = render(scene(), tolerance=0.2, crop=(3, 4, 10, 12))
    part.save(tmp_path / "part.exr")
    read = read_image(tmp_path / "part.exr")
    assert (read.corner, read.whole) == ((3, 4), SIZE)
    assert np.array_equal(read.pixels, part.pixels.astype(np.float32))
    part.save(tmp_path / "part.png")
    assert read_image(tmp_path / "part.png").pixels.shape == (12, 10, 3)
