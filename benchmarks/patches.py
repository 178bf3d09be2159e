"""Exact patches beside the turned meridian and the plain mesh: crossings per second, and the peers' bottle as both."""

import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from patch_bodies import turned_patches  # noqa: E402

from glassworkbench.scene import Body, Medium, Panel, Pinhole, Revolved, Scene  # noqa: E402
from glassworkbench.tracer.native import NativeScene  # noqa: E402

WIDTH, HEIGHT = 480, 640
AROUND, ALONG = 16, 4
CUTOFF = 1e-4
CROSSINGS = 2_000_000

numbers = np.loadtxt(ROOT / "benchmarks" / "data" / "bottle_meridian.csv", delimiter=",").reshape(-1, 4, 2)
meridian = np.concatenate([numbers, np.ones((len(numbers), 4, 1))], axis=2)
camera = Pinhole((0.0, -1000.0, 150.0), (0.0, 0.0, 150.0), 2.0 * np.arctan(0.16))
panel = Panel((-100.0, 100.0, -50.0), (200.0, 0.0, 0.0), (0.0, 0.0, 400.0), 1.0)
glass = Medium("glass", 1.52, (0.02, 0.004, 0.015))

revolved = Revolved(meridian)
patches = turned_patches(revolved.meridian, AROUND, ALONG)
surfaces = {"revolved": revolved, "patches": patches, "mesh": patches.mesh}
scenes = {name: NativeScene(Scene((Body("glass", s),), (glass,), (panel,), camera)) for name, s in surfaces.items()}

column, row = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
rays = camera.rays((2.0 * column.ravel() - WIDTH) / HEIGHT, 1.0 - 2.0 * row.ravel() / HEIGHT)

print(f"the peers' bottle: {len(meridian)} meridian segments, {len(patches.mesh.triangles)} triangles")
print(f"{'surface':<10} {'crossings':>10} {'leaks':>6} {'million crossings per CPU second':>34}")
seen, rates = {}, {}
for name, scene in scenes.items():
    crossings = leaks = 0
    started = time.process_time()
    while crossings < CROSSINGS:
        seen[name] = scene.radiance(*rays, cutoff=CUTOFF, threads=1)
        crossings += int(seen[name].crossings.sum())
        leaks += int(seen[name].leaks.sum())
    rates[name] = crossings / (time.process_time() - started) / 1e6
    print(f"{name:<10} {crossings:>10} {leaks:>6} {rates[name]:>34.2f}", flush=True)
print(f"patches / revolved: {rates['patches'] / rates['revolved']:.2f}")

on_bottle = seen["revolved"].crossings > 0
for name in ("patches", "mesh"):
    difference = np.abs(seen[name].radiance - seen["revolved"].radiance).max(axis=1)[on_bottle]
    shares = ", ".join(f"{np.mean(difference <= limit):.2%} within {limit:g}" for limit in (1e-6, 1e-3))
    print(f"{name} against revolved, {len(difference)} pixels: median {np.median(difference):.1e}, {shares}")
