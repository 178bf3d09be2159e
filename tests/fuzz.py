"""Random scenes, many of them degenerate, traced until time is up: nothing crashes, and no light appears or is lost.

``make fuzz`` runs it under the sanitizers. A finding is printed with its number; ``fuzz.py 0 NUMBER`` repeats it.
"""

import sys
import time
from itertools import pairwise
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

import tracer_scenes  # noqa: E402
from patch_bodies import ball_patches, pebble_patches  # noqa: E402

from glassworkbench.errors import InputError  # noqa: E402
from glassworkbench.scene import Body, Ellipsoid, Environment, Medium, Mesh, Panel, Revolved, Scene  # noqa: E402
from glassworkbench.tracer import native  # noqa: E402

RAYS = 64
LENGTHS = (0.0, 1e-300, 1e-12, 1e-6, 0.02, 1.0, 1.0, 3.0, 3.0, 10.0)
"""mm. Few, so that they repeat: joints and bodies coincide, control points do, walls run along the axis."""


def unit(rng):
    """A direction, often along an axis or nearly so."""
    direction = rng.normal(size=3) * 10.0 ** rng.choice([0.0, -8.0, -16.0, -300.0], 3, p=[0.7, 0.1, 0.1, 0.1])
    direction[rng.random(3) < 0.2] = 0.0
    length = np.linalg.norm(direction)
    return direction / length if length > 0.0 else np.array([0.0, 0.0, 1.0])


def revolved(rng):
    corners = rng.choice(LENGTHS, (rng.integers(2, 8), 2))
    corners[:, 1] *= rng.choice([-1.0, 1.0], len(corners))
    corners[[0, -1], 0] = 0.0
    segments = []
    for start, end in pairwise(corners):
        if rng.random() < 0.5:
            segments.append(tracer_scenes.line(start, end))
            continue
        handles = rng.choice(LENGTHS, (2, 2))
        points = np.array([start, *handles, end])
        weights = 10.0 ** rng.choice([0.0, -3.0, 3.0, 0.3], 4, p=[0.6, 0.1, 0.1, 0.2])
        segments.append(np.column_stack([points, weights]))
    meridian = np.array(segments)
    meridian[:, :, :2] *= 10.0 ** rng.choice([0.0, -3.0, 3.0], p=[0.8, 0.1, 0.1])
    return Revolved(meridian, rng.choice(LENGTHS, 3), unit(rng))


def ellipsoid(rng):
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return Ellipsoid(rng.choice(LENGTHS, 3), rng.choice(LENGTHS[3:], 3), rotation)


def mesh(rng):
    ball = tracer_scenes.ball_mesh(rng.choice(LENGTHS[4:]), rng.integers(2, 6), rng.integers(3, 8))
    flattened = ball.vertices_mm * rng.choice([0.0, 1e-9, 1.0, 1.0, 3.0], 3)
    return Mesh(flattened, ball.triangles, ball.normals)


def patches(rng):
    body = ball_patches(rng.choice(LENGTHS[4:]), int(rng.integers(2, 5))) if rng.random() < 0.8 else pebble_patches()
    return body.placed(np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.choice(LENGTHS, 3))


def scene(rng):
    """A scene in which every medium is clear and all light comes from around, evenly: every ray has to see 1."""
    makers = rng.choice([revolved, revolved, ellipsoid, mesh, patches], rng.integers(1, 5))
    bodies = tuple(Body(f"body_{k}", make(rng)) for k, make in enumerate(makers))
    media = tuple(Medium(body.name, rng.choice([1.0, 1.0, 1.3, 1.5, 1.5, 4.0])) for body in bodies)
    panel = Panel(rng.choice(LENGTHS, 3), unit(rng) * 5.0, unit(rng) * 3.0, 1.0)
    lights = (Environment(1.0), panel) if rng.random() < 0.3 else (Environment(1.0),)
    return Scene(bodies, media, lights, tracer_scenes.CAMERA)


def rays(rng):
    """Rays at, from and along points whose coordinates are those of the scene."""
    signs = rng.choice([-1.0, 1.0], (RAYS, 3))
    at = signs * rng.choice(LENGTHS, (RAYS, 3))
    directions = np.array([unit(rng) for _ in range(RAYS)])
    away = rng.choice([0.0, 1e-9, 1.0, 40.0, 1e6], (RAYS, 1))
    return at - away * directions, directions


def finding(number):
    """What is wrong with the scene of a number, None if nothing is; `InputError` if it is no scene."""
    rng = np.random.default_rng(number)
    traced = native.NativeScene(scene(rng))
    origins, directions = rays(rng)
    seen = traced.radiance(origins, directions, cutoff=1e-2, threads=1)
    traced.follow(origins[0], directions[0])
    if not np.all(np.isfinite(seen.radiance)):
        return "radiance is not finite"
    lost = np.abs(1.0 - seen.radiance - seen.bound[:, None])
    if not lost.max() <= 1e-9:
        return f"light is lost or gained: {lost.max():.3g}"
    return None


def main(seconds, first):
    started, number, traced, findings = time.monotonic(), first, 0, 0
    while number == first or time.monotonic() - started < seconds:
        try:
            problem = finding(number)
            traced += 1
        except InputError:
            problem = None
        if problem:
            findings += 1
            print(f"scene {number}: {problem}", flush=True)
        number += 1
    print(
        f"{number - first} scenes, {traced} of them traced, {findings} findings in {time.monotonic() - started:.0f} s"
    )
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0))
