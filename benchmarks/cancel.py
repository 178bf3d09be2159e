"""How long a rendering goes on after it was told to stop: python benchmarks/cancel.py [SECONDS_PER_SCENE]."""

import sys
import threading
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

import tracer_scenes  # noqa: E402

from glassworkbench.errors import Cancelled  # noqa: E402
from glassworkbench.scene import Environment  # noqa: E402
from glassworkbench.scene.file import read_scene  # noqa: E402
from glassworkbench.tracer import Cancel, render  # noqa: E402

TRIES = 8


def scenes():
    """Yield name, scene and tolerance: usual ones, and such as cost most for each ray."""
    tumbler = read_scene(ROOT / "examples" / "scenes" / "tumbler.toml")
    for tolerance in (0.02, 1e-3, 1e-6):
        yield "tumbler", tumbler, tolerance
    yield "bottle", tracer_scenes.bottle(lights=(Environment(1.0),)), 1e-3
    yield "bodies of patches", tracer_scenes.patches(), 1e-3


def delay(scene, tolerance, after):
    """Return the seconds from Cancel.set() to the end of the rendering; None if it was done before."""
    cancel, at = Cancel(), []

    def stop():
        at.append(time.perf_counter())
        cancel.set()

    timer = threading.Timer(after, stop)
    timer.start()
    try:
        render(scene, tolerance=tolerance, cancel=cancel)
    except Cancelled:
        return time.perf_counter() - at[0]
    finally:
        timer.cancel()
    return None


def main():
    longest = float(sys.argv[1]) if len(sys.argv) > 1 else 3.0
    random = np.random.default_rng(1)
    print(f"{'scene':20} {'tolerance':>9} {'median ms':>10} {'largest ms':>10}")
    for name, scene, tolerance in scenes():
        delays = [delay(scene, tolerance, after) for after in random.uniform(0.01, longest, TRIES)]
        delays = 1e3 * np.array([one for one in delays if one is not None])
        print(f"{name:20} {tolerance:9g} {np.median(delays):10.1f} {delays.max():10.1f}", flush=True)


if __name__ == "__main__":
    main()
