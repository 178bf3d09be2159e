"""Crossings and leaks on every example, seen by both stations' cameras through random points of their images.

    leaks.py [MILLIONS_REVOLVED [MILLIONS_PATCHES]]

So many million crossings (10 of each, if not given) are spread evenly over the examples' containers whose surfaces are
all of revolution, and over those that have exact patches.
"""

import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import glassworkbench as gw  # noqa: E402
from glassworkbench.scene import Revolved  # noqa: E402
from glassworkbench.tracer.native import NativeScene  # noqa: E402

CUTOFF = 1e-4
RAYS = 20_000
WALL = {"wine_glass": "1.2"}
MOST_LEAKS = {"revolved": 1e-9, "patches": 1e-7}
"""Of all crossings."""


def scenes():
    """Yield kind of surface, example, station and scene."""
    for path in sorted((ROOT / "examples" / "molds").glob("*.step")):
        geometry = gw.hollow(gw.read_mold(path), WALL.get(path.stem, "3")).geometry()
        kind = "revolved" if isinstance(geometry.outer, Revolved) else "patches"
        for station in gw.stations():
            yield kind, path.stem, station, gw.station(station, geometry, gw.find_glass("flint"))


def traced(scene, wanted, seed):
    """Return crossings, leaks and CPU seconds of camera rays until so many crossings are done; tell every leak."""
    engine, rng = NativeScene(scene), np.random.default_rng(seed)
    aspect = scene.size[0] / scene.size[1]
    crossings = leaks = 0
    started = time.process_time()
    while crossings < wanted:
        x, y = rng.uniform(-1.0, 1.0, (2, RAYS))
        origins, directions = scene.camera.rays(aspect * x, y)
        seen = engine.radiance(origins, directions, cutoff=CUTOFF, threads=1)
        crossings += int(seen.crossings.sum())
        leaks += int(seen.leaks.sum())
        for ray in np.flatnonzero(seen.leaks):
            print(f"leak: origin {origins[ray].tolist()}, direction {directions[ray].tolist()}", flush=True)
    return crossings, leaks, time.process_time() - started


def main(millions):
    every = list(scenes())
    print(f"{'surfaces':<10}{'example':<16}{'station':<10}{'crossings':>12}{'leaks':>7}{'million a CPU second':>22}")
    totals = {kind: [0, 0] for kind in MOST_LEAKS}
    for seed, (kind, example, station, scene) in enumerate(every):
        share = 1e6 * millions[kind] / sum(other[0] == kind for other in every)
        crossings, leaks, seconds = traced(scene, share, seed)
        totals[kind][0] += crossings
        totals[kind][1] += leaks
        rate = crossings / seconds / 1e6
        print(f"{kind:<10}{example:<16}{station:<10}{crossings:>12}{leaks:>7}{rate:>22.2f}", flush=True)
    for kind, (crossings, leaks) in totals.items():
        print(f"{kind}: {leaks} leaks in {crossings} crossings, {leaks / crossings:.1e} (at most {MOST_LEAKS[kind]:g})")
    return any(leaks > MOST_LEAKS[kind] * crossings for kind, (crossings, leaks) in totals.items())


if __name__ == "__main__":
    given = [float(word) for word in sys.argv[1:]]
    sys.exit(main(dict(zip(MOST_LEAKS, [*given, *[10.0, 10.0][len(given) :]], strict=True))))
