import numpy as np
import OpenImageIO
import pytest

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.images import Image, check_writable, from_display, read_image, to_display
from glassworkbench.output import written_aside

METADATA = {"mold": "flasche ä.step", "wall": "3", "glass": "emerald", "station": "studio"}
REPORT = {
    "tolerance": 0.01,
    "seconds": 1.5,
    "version": "0.1.0",
    "effects": [{"name": "absorption", "on": True}, {"name": "fill", "on": False}],
}
TOLD = METADATA | {"tolerance": "0.01", "seconds": "1.5", "version": "0.1.0", "effects": "absorption"}


@pytest.fixture
def image():
    random = np.random.default_rng(3)
    depth = np.where(random.random((6, 9)) < 0.5, np.inf, 950.0)
    return Image(random.random((6, 9, 3)), random.random((6, 9)), depth, METADATA, REPORT)


@pytest.mark.parametrize("ending", [".exr", ".tif", ".tiff"])
def test_linear_files_keep_every_channel_to_float32(tmp_path, image, ending):
    path = tmp_path / f"bild ü{ending}"
    image.save(path)
    again = read_image(path)
    assert np.array_equal(again.pixels, image.pixels.astype(np.float32))
    assert np.array_equal(again.certificate, image.certificate.astype(np.float32))
    assert np.array_equal(again.depth_mm, image.depth_mm)


@pytest.mark.parametrize("ending", [".exr", ".tif", ".png", ".jpg"])
def test_every_format_carries_the_metadata(tmp_path, image, ending):
    image.save(tmp_path / f"x{ending}")
    assert TOLD.items() <= read_image(tmp_path / f"x{ending}").metadata.items()


@pytest.mark.parametrize("ending", [".exr", ".png"])
def test_metadata_are_attributes_of_their_own_where_the_format_has_them(tmp_path, image, ending):
    image.save(tmp_path / f"x{ending}")
    source = OpenImageIO.ImageInput.open(str(tmp_path / f"x{ending}"))
    for name in ("mold", "wall", "glass", "station", "tolerance", "seconds", "effects"):
        assert source.spec().getattribute(name) == TOLD[name]
    source.close()


def test_linear_files_name_their_channels(tmp_path, image):
    image.save(tmp_path / "x.exr")
    source = OpenImageIO.ImageInput.open(str(tmp_path / "x.exr"))
    assert set(source.spec().channelnames) == {"R", "G", "B", "certificate", "depth"}
    source.close()


def test_a_png_holds_srgb_of_the_exposed_radiance(tmp_path):
    # IEC 61966-2-1: 0.5 linear is 187.5 of 255 in sRGB; 0.214 is half grey.
    pixels = np.full((2, 2, 3), 0.25)
    image = Image(pixels, pixels[..., 0], pixels[..., 0])
    image.save(tmp_path / "x.png", exposure=1.0)
    source = OpenImageIO.ImageInput.open(str(tmp_path / "x.png"))
    assert np.all(np.asarray(source.read_image(OpenImageIO.UINT8)) == 188)
    source.close()
    assert np.allclose(read_image(tmp_path / "x.png").pixels, 0.25, atol=0.002)


def test_the_tone_curve_meets_its_inverse():
    levels = np.arange(256)
    assert np.array_equal(to_display(from_display(levels / 255.0)), levels)
    assert to_display(np.array([-1.0, 0.0, 1.0, 9.0])).tolist() == [0, 0, 255, 255]


def test_an_image_whose_arrays_do_not_belong_together_is_refused():
    with pytest.raises(InputError, match="depth_mm"):
        Image(np.zeros((4, 5, 3)), np.zeros((4, 5)), np.zeros((5, 4)))
    with pytest.raises(InputError, match="pixels"):
        Image(np.zeros((4, 5)), np.zeros((4, 5)), np.zeros((4, 5)))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("x.bmp", "'.bmp' is not known; use .exr, .tif"),
        ("x", "it has no ending"),
        ("missing/x.png", "there is no folder"),
        ("x.png/y.png", "there is no folder"),
        ("folder.png", "it is a folder"),
    ],
)
def test_a_place_that_cannot_be_written_is_refused_before_the_work(tmp_path, image, name, message):
    (tmp_path / "x.png").touch()
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(InputError, match=message):
        image.save(tmp_path / name)


def test_a_folder_without_room_for_files_is_refused():
    with pytest.raises(InputError, match="nothing can be written"):
        check_writable("/proc/x.png")


def test_a_file_appears_whole_or_not_at_all(tmp_path):
    path = tmp_path / "x.txt"
    path.write_text("before")

    def write_half(stopped_by):
        with written_aside(path) as aside:
            aside.write_text("half")
            raise stopped_by

    with pytest.raises(KeyboardInterrupt):
        write_half(KeyboardInterrupt())
    with pytest.raises(GlassWorkbenchError, match="No space"):
        write_half(OSError(28, "No space left on device"))
    assert path.read_text() == "before"
    with written_aside(path) as aside:
        aside.write_text("after")
    assert path.read_text() == "after"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("data", [b"", b"no image at all"])
def test_what_is_no_image_is_refused_by_name(tmp_path, data):
    (tmp_path / "x.exr").write_bytes(data)
    with pytest.raises(InputError, match=r"x\.exr"):
        read_image(tmp_path / "x.exr")
    with pytest.raises(InputError, match="no such file"):
        read_image(tmp_path / "y.exr")
