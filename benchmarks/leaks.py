"""Crossings and leaks on every revolved example, seen by both stations' cameras: ten million crossings each."""

import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import glassworkbench as gw  # noqa: E402
from glassworkbench.tracer.control import Cancel  # noqa: E402
from glassworkbench.tracer.film import Film  # noqa: E402
from glassworkbench.tracer.native import NativeScene, default_threads  # noqa: E402

CROSSINGS = 10_000_000
CUTOFF = 1e-4
WALL = {"wine_glass": "1.2"}

print(f"{'example':<14} {'station':<10} {'crossings':>11} {'leaks':>6} {'million crossings per CPU second':>34}")
leaks = 0
for path in sorted((ROOT / "examples" / "molds").glob("*.step")):
    container = gw.hollow(gw.read_mold(path), WALL.get(path.stem, "3"))
    geometry = container.geometry()
    if container.method != "revolved":
        continue
    for name in gw.stations():
        scene = gw.station(name, geometry, gw.find_glass("flint"))
        native, film, samples = NativeScene(scene), Film(*scene.size), 0
        started = time.process_time()
        while film.crossings < CROSSINGS:
            samples += 1
            native.sample(
                film,
                np.arange(film.samples.size),
                samples,
                cutoff=CUTOFF,
                absorption=True,
                threads=default_threads(),
                cancel=Cancel(),
            )
        rate = film.crossings / (time.process_time() - started) / 1e6
        print(f"{path.stem:<14} {name:<10} {film.crossings:>11} {film.leaks:>6} {rate:>34.2f}", flush=True)
        leaks += film.leaks
sys.exit(1 if leaks else 0)
