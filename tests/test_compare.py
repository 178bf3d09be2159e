"""Camera images, made by a function of the place, against golden ones."""

import json

import numpy as np
import OpenImageIO
import pytest

pytest.importorskip("skimage")

from analytic_images import HEIGHT, SCALE, WIDTH, golden, image, valid

from glassworkbench.cli import main
from glassworkbench.errors import InputError
from glassworkbench.images import Image, read_image
from glassworkbench.judging import GoldenImage, compare, golden_of, read_golden
from glassworkbench.judging.camera_image import CameraImage, read_camera_image
from glassworkbench.judging.limits import Limits, read_limits
from glassworkbench.judging.registration import register

NOISE = 0.01


def noisy(seed=0, gain=1.0, **moved):
    values = image(gain=gain, **moved)
    return values + np.random.default_rng(seed).normal(0.0, NOISE * gain, values.shape)


def camera(**moved):
    values = noisy(**moved)
    return CameraImage(values, np.zeros(values.shape, dtype=bool))


def write(path, values, kind="uint8"):
    """Write a grey image, values from 0 to 1, as a camera does: without a word about it."""
    if kind == "float":
        data = values.astype(np.float32)
    else:
        full = {"uint8": 255, "uint16": 65535, "uint12": 4095}[kind]
        data = np.clip(np.rint(values * full), 0, full).astype(np.uint8 if full == 255 else np.uint16)
    channels = 1 if values.ndim == 2 else values.shape[2]
    spec = OpenImageIO.ImageSpec(
        values.shape[1], values.shape[0], channels, str(data.dtype).replace("float32", "float")
    )
    output = OpenImageIO.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_image(np.ascontiguousarray(data.reshape(*values.shape[:2], channels)))
    output.close()
    return path


@pytest.fixture
def golden_file(tmp_path):
    path = tmp_path / "golden.exr"
    golden().save(path)
    return path


@pytest.mark.parametrize("seed", range(8))
def test_the_transformation_is_found_within_a_twentieth_of_a_pixel_and_a_fiftieth_of_a_degree(seed):
    random = np.random.default_rng(seed)
    shift, turn = random.uniform(-15, 15, 2), random.uniform(-5, 5)
    scale, gain = random.uniform(0.97, 1.03), random.uniform(0.3, 1.8)
    blobs = [(130, 150, 6, 0.2), (100, 250, 4, 0.1)]
    seen = noisy(seed, gain=gain, shift=shift, rotation_deg=turn, scale=scale, blobs=blobs)
    found = register(image(), seen, valid())
    assert np.abs(np.array(found.shift_px) - shift).max() < 0.05
    assert abs(found.rotation_deg - turn) < 0.02
    assert abs(found.scale - scale) < 5e-4
    assert abs(found.gain / gain - 1.0) < 2e-3


def test_a_good_container_is_accepted_however_it_is_moved():
    for seed in range(3):
        random = np.random.default_rng(seed)
        moved = {"shift": random.uniform(-8, 8, 2), "rotation_deg": random.uniform(-3, 3), "gain": 0.6}
        told = compare(golden(), camera(seed=seed, **moved))
        assert told.verdict == "accept"
        assert told.findings == ()
        assert set(told.zones) == {"finish", "body"}


def test_blobs_are_found_with_size_height_angle_and_zone():
    drawn = [(150, 180, 4.0, 0.3), (100, 250, 2.0, 0.4), (125, 80, 1.2, 0.2)]
    told = compare(golden(), camera(shift=(5, -3), rotation_deg=1.5, gain=0.7, blobs=drawn))
    assert len(told.findings) == len(drawn)
    for column, row, radius, _ in drawn:
        height = (SCALE.base_row - row) / SCALE.rows_per_mm
        (found,) = [f for f in told.findings if abs(f.height_mm - height) < 0.1]
        half = 30 + 45 / (1 + np.exp(-(row - 110) / 6))
        # The axis is at column 120, the outline about 122.
        angle = (-90 + np.degrees(np.arcsin((column - 120) / half))) % 360
        assert found.angle_deg == pytest.approx(angle, abs=0.5)
        assert found.size_mm == pytest.approx(2 * radius / SCALE.px_per_mm, abs=0.25)
        assert found.kind == "dark"
        assert found.z < -20
        assert found.zone == ("finish" if row < 110 else "body")
    assert told.verdict == "reject"


def test_a_bright_blob_is_called_bright():
    told = compare(golden(), camera(blobs=[(150, 180, 4.0, 1.3)]))
    assert [finding.kind for finding in told.findings] == ["bright"]


def test_classes_and_verdicts_follow_the_limits():
    sizes = {"minor": 0.5, "major": 5.0, "critical": 9.0}
    seen = camera(blobs=[(150, 180, 4.0, 0.3)])
    lenient = compare(golden(), seen, limits=Limits({"default": sizes}))
    assert [finding.defect_class for finding in lenient.findings] == ["minor"]
    assert lenient.verdict == "accept"
    assert compare(golden(), seen, limits=Limits({"default": sizes}, most_minor=0)).zones["body"] == "reject"
    blind = Limits({"default": {"minor": 5.0, "major": 6.0, "critical": 9.0}})
    assert compare(golden(), seen, limits=blind).findings == ()
    strict = Limits({"default": sizes, "body": {"minor": 0.1, "major": 0.2, "critical": 0.3}})
    told = compare(golden(), seen, limits=strict)
    assert [finding.defect_class for finding in told.findings] == ["critical"]
    assert told.zones == {"finish": "accept", "body": "reject"}


def test_a_golden_image_comes_back_from_its_file_as_it_was(golden_file):
    made, read = golden(), read_golden(golden_file)
    for layer in ("nominal", "mean", "sigma", "lower", "upper", "valid", "zone"):
        assert np.array_equal(getattr(made, layer), getattr(read, layer)), layer
    assert read.zones == made.zones
    assert read.scale == made.scale
    assert read.metadata["glass"] == "flint"


def rendered():
    grey = image()
    depth = np.where(valid(), 300.0, np.inf)
    told = {"station": "sidewall", **SCALE.to_metadata()}
    return Image(np.dstack([grey] * 3), np.full(grey.shape, 0.002), depth, told)


def test_a_rendering_serves_as_a_golden_image(tmp_path):
    rendered().save(tmp_path / "sidewall.exr")
    told = compare(tmp_path / "sidewall.exr", camera(shift=(3, 2), blobs=[(150, 180, 4.0, 0.3)]))
    assert [finding.height_mm for finding in told.findings] == pytest.approx([30.0], abs=0.1)
    assert told.zones == {"container": "reject"}


def test_zones_of_a_rendering_are_given_by_height():
    made = golden_of(rendered(), zones_mm={"heel": (0, 10), "body": (10, 48), "neck": (48, 75)})
    assert made.zones == ("heel", "body", "neck")
    assert set(np.unique(made.zone)) == {0, 1, 2, 3}
    # 10 mm above the base at row 300 are 40 rows.
    assert made.zone[262, 120] == 1
    assert made.zone[258, 120] == 2


@pytest.mark.parametrize(
    ("ending", "kind"), [(".png", "uint8"), (".png", "uint16"), (".tif", "uint12"), (".exr", "float")]
)
def test_images_of_any_depth_are_read_linear(tmp_path, ending, kind):
    path = write(tmp_path / f"camera{ending}", 0.5 * image(), kind)
    found = read_camera_image(path)
    full = 4095 / 65535 if kind == "uint12" else 1.0
    assert np.allclose(found.grey, 0.5 * full * image(), atol=0.51 * full / 255)
    assert not found.saturated.any()


def test_a_picture_of_a_rendering_says_that_it_is_srgb(tmp_path):
    rendered().save(tmp_path / "shot.png")
    assert np.allclose(read_camera_image(tmp_path / "shot.png").grey, image(), atol=0.01)
    linear = read_camera_image(tmp_path / "shot.png", tone="linear")
    assert linear.grey[150, 120] > 1.1 * image()[150, 120]


@pytest.mark.parametrize("kind", ["uint8", "uint16", "uint12"])
def test_a_saturated_image_is_refused(tmp_path, golden_file, kind):
    path = write(tmp_path / "bright.tif", np.minimum(1.6 * image(), 1.0), kind)
    with pytest.raises(InputError, match=r"bright.tif: \d+ % of the judged pixels are saturated"):
        compare(golden_file, path)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.full((HEIGHT, WIDTH), 0.4), "the image is blank"),
        (np.zeros((HEIGHT, WIDTH)), "the image is blank"),
        (0.6 * image()[:, :200], "200x320 pixels, the golden image 240x320; crop it"),
        (0.6 * np.rot90(image()), "320x240 pixels, the golden image 240x320; turn it by 90 degrees"),
        (0.6 * image()[::-1, ::-1], "turned by 180 degrees"),
        (0.6 * np.random.default_rng(0).random((HEIGHT, WIDTH)), "does not show what the golden image shows"),
        (0.6 * image(shift=(70, 0)), "image"),
    ],
)
def test_an_image_that_cannot_be_judged_is_refused_in_one_sentence(tmp_path, golden_file, capsys, values, message):
    path = write(tmp_path / "camera.png", np.ascontiguousarray(values), "uint16")
    assert main(["compare", str(golden_file), str(path)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "camera.png: " in err
    assert message in err


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"sigma": -np.ones((HEIGHT, WIDTH))}, "negative sigma"),
        ({"zone": np.full((HEIGHT, WIDTH), 7)}, "numbers run to 7"),
        ({"valid": np.zeros((HEIGHT, WIDTH), dtype=bool)}, "no pixel is judged"),
        ({"mean": np.full((HEIGHT, WIDTH), np.nan)}, "not finite"),
        ({"upper": np.zeros((2, 2))}, "expected shape"),
    ],
)
def test_an_impossible_golden_image_is_refused(change, message):
    layers = {name: getattr(golden(), name) for name in GoldenImage.__dataclass_fields__}
    with pytest.raises(InputError, match=message):
        GoldenImage(**{**layers, **change})


def test_what_is_no_golden_image_is_refused(tmp_path):
    path = write(tmp_path / "plain.exr", image(), "float")
    with pytest.raises(InputError, match="no golden image; it needs the channels nominal, mean"):
        read_golden(path)


def test_limits_are_read_strictly(tmp_path):
    assert read_limits().class_of("finish", 0.5) == "major"
    assert read_limits().class_of("shoulder", 0.5) == "minor"
    assert read_limits().class_of("shoulder", 0.1) is None
    path = tmp_path / "limits.toml"
    path.write_text("[zone.default]\nminor = 1\nmajor = 0.5\ncritical = 3\n")
    with pytest.raises(InputError, match="must grow from minor"):
        read_limits(path)
    path.write_text("[zone.default]\nminor = 1\nmajr = 2\ncritical = 3\n")
    with pytest.raises(InputError, match="did you mean 'major'"):
        read_limits(path)


def test_the_verb_answers_with_a_report_and_draws_an_overlay(tmp_path, golden_file, capsys):
    path = write(tmp_path / "camera.png", noisy(shift=(4, 1), gain=0.6, blobs=[(150, 180, 5.0, 0.3)]), "uint16")
    report, overlay = tmp_path / "r.json", tmp_path / "o.png"
    words = ["compare", str(golden_file), str(path), "--report", str(report), "--overlay", str(overlay)]
    assert main(words) == 0
    assert capsys.readouterr().out.startswith(f"{path}: reject, body 1 major (shift 4.0")
    told = json.loads(report.read_text())
    assert told["verdict"] == "reject"
    assert {"name": "finish", "verdict": "accept"}.items() <= told["zones"][0].items()
    assert {"kind", "size_mm", "height_mm", "angle_deg", "z", "class", "zone"} <= told["findings"][0].keys()
    assert {"shift_px", "rotation_deg", "scale", "gain"} <= told["registration"].keys()
    assert told["registration"]["shift_px"] == pytest.approx([4.0, 1.0], abs=0.05)
    drawn = read_image(overlay).pixels
    # The frame around the finding, in orange, on both pictures.
    orange = (drawn[..., 0] > 0.8) & (drawn[..., 1] > 0.1) & (drawn[..., 1] < 0.3) & (drawn[..., 2] < 0.05)
    assert orange[:, : orange.shape[1] // 2].sum() > 50
    assert orange[:, orange.shape[1] // 2 :].sum() > 50
    assert main(["compare", str(golden_file), str(path), "--report", str(path)]) == 2
    assert "would be overwritten" in capsys.readouterr().err
