"""Light through every example: nothing leaks, and lossless glass in uniform light cannot be seen."""

from pathlib import Path

import numpy as np
import pytest

import glassworkbench as gw
from glassworkbench.scene import Body, Environment, Medium, Pinhole, Scene
from glassworkbench.tracer import native

EXAMPLES = sorted((Path(__file__).resolve().parent.parent / "examples" / "molds").glob("*.step"))
WALL = {"wine_glass": "1.2"}
RAYS = 20_000

pytestmark = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_furnace_a_lossless_container_in_uniform_light_reads_that_light(path):
    geometry = gw.hollow(gw.read_mold(path), WALL.get(path.stem, "3")).geometry()
    scene = Scene(
        bodies=(Body("outer", geometry.outer), Body("cavity", geometry.cavity)),
        media=(Medium("outer and not cavity", 1.52338),),
        lights=(Environment(1.0),),
        camera=Pinhole((0.0, -1000.0, 150.0), (0.0, 0.0, 150.0), 0.3),
    )
    rng = np.random.default_rng(20)
    middle, size = 0.5 * (geometry.low_mm + geometry.high_mm), geometry.high_mm - geometry.low_mm
    away = rng.normal(size=(RAYS, 3))
    origins = middle + 1000.0 * away / np.linalg.norm(away, axis=1, keepdims=True)
    targets = geometry.low_mm + size * rng.uniform(size=(RAYS, 3))
    seen = native.radiance(scene, origins, targets - origins, cutoff=1e-4)
    assert seen.crossings.sum() > 10 * RAYS
    assert seen.leaks.sum() == 0
    missing = 1.0 - seen.radiance
    assert np.all(missing >= -1e-9)
    assert np.all(missing <= seen.bound[:, None] + 1e-9)
