"""Renderings that stop and go on: the same bytes, and nothing that belongs to another rendering."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_parts import same_bytes, scene

from glassworkbench.errors import Cancelled, InputError
from glassworkbench.tracer import Cancel, checkpoint, native, render, rendering

pytestmark = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")

ROOT = Path(__file__).resolve().parent.parent
SIZE = 90, 70


@pytest.fixture(autouse=True)
def written_always(monkeypatch):
    """A checkpoint after each batch, a batch as small as can be."""
    monkeypatch.setattr(checkpoint, "INTERVAL_SECONDS", 0.0)
    monkeypatch.setattr(checkpoint, "LARGEST_SHARE", np.inf)
    monkeypatch.setattr(rendering, "BATCH_SECONDS", 1e-9)
    monkeypatch.setattr(rendering, "WORTH_SECONDS", 0.0)


class Crash(Exception):
    """What no rendering expects."""


def crash_after(share):
    def tell(done):
        if done > share:
            raise Crash

    return tell


def large():
    return replace(scene(False), size=SIZE)


@pytest.fixture(scope="module")
def whole():
    return render(large(), tolerance=0.1)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.55])
def test_what_crashed_goes_on_to_the_same_bytes(tmp_path, whole, share):
    kept = tmp_path / "picture.checkpoint"
    with pytest.raises(Crash):
        render(large(), tolerance=0.1, checkpoint=kept, progress=crash_after(share))
    assert kept.exists() is (share > 0.0)
    shares = []
    image = render(large(), tolerance=0.1, checkpoint=kept, resume=share > 0.0, progress=shares.append)
    assert same_bytes(image, whole)
    assert shares[0] > share
    assert image.report["camera_rays"] <= 1.05 * whole.report["camera_rays"]
    assert list(tmp_path.iterdir()) == []


def test_a_region_goes_on_to_the_same_bytes(tmp_path):
    options = {"tolerance": 0.1, "region": (30, 10, 40, 50), "crop": (20, 0, 60, 60)}
    kept = tmp_path / "picture.checkpoint"
    with pytest.raises(Crash):
        render(large(), **options, checkpoint=kept, progress=crash_after(0.6))
    assert same_bytes(render(large(), **options, checkpoint=kept, resume=True), render(large(), **options))


def test_what_was_cancelled_goes_on_to_the_same_bytes_and_counts_no_ray_twice(tmp_path, whole):
    kept, cancel = tmp_path / "picture.checkpoint", Cancel()
    with pytest.raises(Cancelled, match=f"resume=True goes on from {kept}"):
        render(large(), tolerance=0.1, checkpoint=kept, cancel=cancel, progress=lambda share: cancel.set())
    image = render(large(), tolerance=0.1, checkpoint=kept, resume=True)
    assert same_bytes(image, whole)
    assert image.report["camera_rays"] == whole.report["camera_rays"]


def test_a_killed_process_leaves_a_checkpoint_that_goes_on_to_the_same_bytes(tmp_path, whole):
    kept = tmp_path / "picture.checkpoint"
    program = f"""
import os, signal, sys
sys.path[:0] = [{str(ROOT)!r}, {str(ROOT / "tests")!r}]
from glassworkbench.tracer import checkpoint, render, rendering
from test_checkpoint import large
checkpoint.INTERVAL_SECONDS, rendering.BATCH_SECONDS = 0.0, 1e-9
kill = lambda share: share > 0.2 and os.kill(os.getpid(), signal.SIGKILL)
render(large(), tolerance=0.1, checkpoint={str(kept)!r}, progress=kill)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert done.returncode == -9, done.stderr
    assert same_bytes(render(large(), tolerance=0.1, checkpoint=kept, resume=True), whole)


@pytest.fixture
def left(tmp_path):
    kept = tmp_path / "picture.checkpoint"
    with pytest.raises(Crash):
        render(scene(), tolerance=0.1, checkpoint=kept, progress=crash_after(0.0))
    with pytest.raises(Crash):
        render(large(), tolerance=0.1, checkpoint=kept, progress=crash_after(0.3))
    return kept


@pytest.mark.parametrize(
    ("other", "options", "why"),
    [
        (scene(), {}, "another scene"),
        (large(), {"tolerance": 0.2}, "another tolerance"),
        (large(), {"effects": {"absorption": False}}, "another choice of effects"),
        (large(), {"crop": (0, 0, 50, 50)}, "another crop"),
        (large(), {"region": (0, 0, 50, 50)}, "another region"),
        (large(), {"on_pass": print}, "another sequence of passes"),
    ],
)
def test_a_checkpoint_of_another_rendering_is_refused(left, other, options, why):
    with pytest.raises(InputError, match=f"{left}: it belongs to {why}"):
        render(other, **{"tolerance": 0.1} | options, checkpoint=left, resume=True)
    assert left.exists()


def test_a_checkpoint_of_another_version_is_refused(left, monkeypatch):
    monkeypatch.setattr(sys.modules["glassworkbench.tracer.render"], "__version__", "0.0.9")
    with pytest.raises(InputError, match="another version of GlassWorkbench"):
        render(large(), tolerance=0.1, checkpoint=left, resume=True)


def test_a_scene_that_differs_in_its_last_bit_is_another(left):
    seen = large()
    media = [replace(medium, refractive_index=np.nextafter(medium.refractive_index, 2.0)) for medium in seen.media]
    with pytest.raises(InputError, match="another scene"):
        render(replace(seen, media=media), tolerance=0.1, checkpoint=left, resume=True)


def test_what_the_image_carries_along_may_change(left, whole):
    seen = replace(large(), metadata={"customer": "new"})
    image = render(seen, tolerance=0.1, checkpoint=left, resume=True, threads=2)
    assert image.metadata["customer"] == "new"
    assert same_bytes(image, whole)


def test_a_missing_or_damaged_checkpoint_is_refused(left):
    with pytest.raises(InputError, match="no such checkpoint"):
        render(large(), tolerance=0.1, checkpoint=left.with_name("none"), resume=True)
    content = left.read_bytes()
    for damaged in (content[: len(content) // 2], b"", b"no zip"):
        left.write_bytes(damaged)
        with pytest.raises(InputError, match="not a checkpoint, or damaged"):
            render(large(), tolerance=0.1, checkpoint=left, resume=True)
    with pytest.raises(InputError, match="resume"):
        render(large(), tolerance=0.1, resume=True)


def test_a_checkpoint_that_cannot_be_written_is_told_before_the_work(tmp_path):
    with pytest.raises(InputError, match="no folder"):
        render(large(), checkpoint=tmp_path / "none" / "x", progress=crash_after(-1.0))
