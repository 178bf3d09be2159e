"""Exact intersections per CPU second on the peers' bottle, beside Embree's single rays at a million triangles of it.

Full tracing counts the crossings that light is split at; the rays that leave without one cost as much and are not
counted. Straight lines through the bottle count every ray, those that meet nothing any more among them: Embree gets
the very same, each from its place on the line.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from patch_bodies import turned_patches  # noqa: E402

from glassworkbench.scene import Body, Environment, Medium, Panel, Pinhole, Revolved, Scene  # noqa: E402
from glassworkbench.tracer.native import NativeScene  # noqa: E402

WIDTH, HEIGHT = 480, 640
CUTOFF = 1e-3
PASSES = 3
LINES = 100_000
EMBREE = ROOT / "build" / "embree"
EMBREE_ROWS, EMBREE_SECTORS = 12, 514
"""Per meridian segment and around: 81 segments make a million triangles."""

EMBREE_RUN = """
import sys, time
import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
data = np.load(sys.argv[1])
scene = EmbreeScene()
TriangleMesh(scene, data["triangles"].astype(np.float32))
origins, directions = data["origins"].astype(np.float32), data["directions"].astype(np.float32)
scene.run(origins[:1000], directions[:1000])
started = time.process_time()
met = scene.run(origins, directions)
print(len(origins) / (time.process_time() - started) / 1e6, len(data["triangles"]))
"""


def bottle():
    numbers = np.loadtxt(ROOT / "benchmarks" / "data" / "bottle_meridian.csv", delimiter=",").reshape(-1, 4, 2)
    return Revolved(np.concatenate([numbers, np.ones((len(numbers), 4, 1))], axis=2))


def camera_rays(camera):
    column, row = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
    return camera.rays((2.0 * column.ravel() - WIDTH) / HEIGHT, 1.0 - 2.0 * row.ravel() / HEIGHT)


def soft_boxes():
    """A dim sky with a few bright soft boxes."""
    sky = np.full((64, 128, 3), 0.05)
    for row, column in ((12, 20), (24, 64), (18, 100)):
        sky[row : row + 10, column : column + 8] = 8.0
    return Environment(sky)


def lines_through(count):
    """Lines at points in the bottle's box, from outside of it, in all directions."""
    rng = np.random.default_rng(1)
    towards = rng.uniform((-38.0, -38.0, 0.0), (38.0, 38.0, 300.0), (count, 3))
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return towards - 500.0 * directions, directions


def rate(scene, rays, cutoff):
    """Millions of crossings per CPU second, and the crossings of each ray: the best of a few passes."""
    best, seen = 0.0, None
    for _ in range(PASSES):
        started = time.process_time()
        seen = scene.radiance(*rays, cutoff=cutoff, threads=1)
        best = max(best, float(seen.crossings.sum()) / (time.process_time() - started) / 1e6)
    return best, seen.crossings


def mesh_of(meridian):
    """Corners of the bottle's triangles, (m, 3, 3)."""
    u = np.arange(EMBREE_ROWS)[:, None] / EMBREE_ROWS
    basis = np.hstack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
    r, z = np.vstack([np.einsum("uk,skc->suc", basis, meridian[:, :, :2]).reshape(-1, 2), meridian[-1, 3, :2]]).T
    angle = 2.0 * np.pi * np.arange(EMBREE_SECTORS) / EMBREE_SECTORS
    points = np.stack([np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle)), np.outer(z, np.ones_like(angle))], -1)
    turned = np.roll(points, -1, axis=1)
    a, b, c, d = points[:-1], turned[:-1], turned[1:], points[1:]
    return np.concatenate([np.stack([a, b, c], -2).reshape(-1, 3, 3), np.stack([a, c, d], -2).reshape(-1, 3, 3)])


def embree_rate(meridian, origins, directions):
    """Embree's rays per CPU second in millions and the number of triangles, from PyPI's embreex in its own folder."""
    python = EMBREE / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", EMBREE], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "embreex", "numpy"], check=True)
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "rays.npz"
        np.savez(data, triangles=mesh_of(meridian), origins=origins, directions=directions)
        run = subprocess.run([python, "-c", EMBREE_RUN, data], check=True, capture_output=True, text=True)
    return [float(number) for number in run.stdout.split()]


def main():
    revolved = bottle()
    surfaces = {"revolved": revolved, "patches": turned_patches(revolved.meridian, 16, 4)}
    camera = Pinhole((0.0, -1000.0, 150.0), (0.0, 0.0, 150.0), 2.0 * np.arctan(0.16))
    panel = Panel((-100.0, 100.0, -50.0), (200.0, 0.0, 0.0), (0.0, 0.0, 400.0), 1.0)
    glass, air = Medium("glass", 1.52, (0.02, 0.004, 0.015)), Medium("glass", 1.0)
    lines = lines_through(LINES)
    print(f"{'million per CPU second':<24} {'panel':>8} {'environment':>12} {'straight lines':>15}")
    for name, surface in surfaces.items():
        body = (Body("glass", surface),)
        rates = [
            rate(NativeScene(Scene(body, (glass,), (light,), camera)), camera_rays(camera), CUTOFF)[0]
            for light in (panel, soft_boxes())
        ]
        straight, crossings = rate(NativeScene(Scene(body, (air,), (panel,), camera)), lines, CUTOFF)
        straight *= 1.0 + len(crossings) / crossings.sum()
        print(f"{name:<24} {rates[0]:>8.2f} {rates[1]:>12.2f} {straight:>15.2f}", flush=True)

    idle = NativeScene(Scene((Body("glass", revolved),), (air,), (Environment(1.0),), camera))
    origins, directions = [], []
    for origin, direction in zip(*(a[:20_000] for a in lines), strict=True):
        places = [origin, *(crossing.point_mm + 1e-3 * direction for crossing in idle.follow(origin, direction))]
        origins += places
        directions += [direction] * len(places)
    embree, triangles = embree_rate(revolved.meridian, np.array(origins), np.array(directions))
    print(f"{f'Embree, {triangles:.0f} triangles':<24} {'':>8} {'':>12} {embree:>15.2f}")


if __name__ == "__main__":
    main()
