"""Time to an error on the peers' bottle: GlassWorkbench and Mitsuba 3, one run, CPU seconds of both.

The truth is a plain grid of 16 x 16 rays in each pixel of the bottle at a cut-off of 1e-5 (traced once, kept in
out/bench). Mitsuba is installed into build/mitsuba; it needs LLVM 16 or newer (Debian: libllvm19).
"""

import glob
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import peers_scene as peers  # noqa: E402

from glassworkbench.scene import Body, Environment, Medium, Panel, Pinhole, Revolved, Scene  # noqa: E402
from glassworkbench.tracer import render  # noqa: E402
from glassworkbench.tracer.native import NativeScene  # noqa: E402

GRID, TRUE_CUTOFF = 16, 1e-5
TOLERANCES = {"panel": (0.2, 0.1, 0.05, 0.025), "environment": (0.5, 0.25, 0.12)}
MITSUBA_SAMPLES = (16, 64, 256)
ERRORS = (0.01, 0.005)
FOLDER = ROOT / "out" / "bench"
MITSUBA = ROOT / "build" / "mitsuba"
LLVM = "/usr/lib/*/libLLVM*19.1*"


def scene(kind):
    numbers = peers.meridian()
    origin, target = peers.CAMERAS[kind]
    if kind == "panel":
        light = Panel(*peers.PANEL, 1.0)
    else:
        height, width = peers.MAP_SIZE
        elevation = np.pi / 2.0 - (np.arange(height)[:, None] + 0.5) / height * np.pi
        azimuth = (np.arange(width) + 0.5) / width * 2.0 * np.pi - np.pi
        flat, up = np.cos(elevation), np.sin(elevation)
        light = Environment(
            peers.sky(np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), up + 0.0 * azimuth], axis=2))
        )
    return Scene(
        bodies=(Body("glass", Revolved(np.concatenate([numbers, np.ones((len(numbers), 4, 1))], axis=2))),),
        media=(Medium("glass", peers.REFRACTIVE_INDEX, peers.ABSORPTION_PER_MM),),
        lights=(light,),
        camera=Pinhole(origin, target, peers.FIELD_OF_VIEW_RAD),
        size=(peers.WIDTH, peers.HEIGHT),
    )


def truth(kind):
    """Return the bottle's pixels and their true radiance."""
    path = FOLDER / f"truth_{kind}.npz"
    if path.exists():
        kept = np.load(path)
        return kept["pixels"], kept["radiance"]
    world = scene(kind)
    engine = NativeScene(world)

    def rays(pixels, x, y):
        row, column = np.divmod(pixels, peers.WIDTH)
        return world.camera.rays(
            (2.0 * (column + x) - peers.WIDTH) / peers.HEIGHT, 1.0 - 2.0 * (row + y) / peers.HEIGHT
        )

    everywhere = np.arange(peers.WIDTH * peers.HEIGHT)
    pixels = np.flatnonzero(np.isfinite(engine.radiance(*rays(everywhere, 0.5, 0.5), cutoff=0.5).depth_mm))
    total = np.zeros((len(pixels), 3))
    for step in range(GRID * GRID):
        x, y = (step % GRID + 0.5) / GRID, (step // GRID + 0.5) / GRID
        total += engine.radiance(*rays(pixels, x, y), cutoff=TRUE_CUTOFF).radiance
        print(f"\r{kind}: truth {step + 1}/{GRID * GRID}", end="", file=sys.stderr)
    print(file=sys.stderr)
    FOLDER.mkdir(parents=True, exist_ok=True)
    np.savez(path, pixels=pixels, radiance=total / GRID**2)
    return pixels, total / GRID**2


def relative_error(image, pixels, true):
    difference = image.reshape(-1, 3)[pixels] - true
    return float(np.sqrt(np.mean(difference**2)) / true.mean()), float(difference.mean() / true.mean())


def ours(kind, pixels, true):
    world = scene(kind)
    for tolerance in TOLERANCES[kind]:
        started = time.process_time()
        image = render(world, tolerance=tolerance)
        seconds = time.process_time() - started
        error = np.abs(image.pixels.reshape(-1, 3)[pixels] - true).max(axis=1)
        under = np.mean(error <= image.certificate.ravel()[pixels] + 1e-6)
        yield (
            f"tolerance {tolerance:g}",
            seconds,
            *relative_error(image.pixels, pixels, true),
            f"{under:.2%} under the certificate",
        )


def mitsubas(kind, pixels, true):
    if not MITSUBA.exists():
        subprocess.run([sys.executable, "-m", "venv", MITSUBA], check=True)
        subprocess.run([MITSUBA / "bin" / "pip", "install", "--quiet", "mitsuba", "numpy"], check=True)
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "benchmarks")}
    if "DRJIT_LIBLLVM_PATH" not in environment:
        found = sorted(glob.glob(LLVM))
        if not found:
            sys.exit("peers: no LLVM 19 for Mitsuba; install libllvm19, or name a libLLVM in DRJIT_LIBLLVM_PATH")
        environment["DRJIT_LIBLLVM_PATH"] = found[0]
    command = [MITSUBA / "bin" / "python", ROOT / "benchmarks" / "mitsuba_bottle.py", kind, FOLDER]
    command += [str(count) for count in MITSUBA_SAMPLES]
    done = subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE, text=True)
    for line in done.stdout.splitlines():
        row = json.loads(line)
        image = np.load(FOLDER / f"mitsuba_{kind}_{row['samples']}.npy")
        yield f"{row['samples']} samples", row["cpu_seconds"], *relative_error(image, pixels, true), ""


def seconds_to(error, rows):
    """Interpolate or extrapolate log seconds over log error, by the two rows nearest to it."""
    logs = np.log([(found, seconds) for _, seconds, found, *_ in rows])
    logs = logs[np.argsort(np.abs(logs[:, 0] - np.log(error)))[:2]]
    slope = (logs[1, 1] - logs[0, 1]) / (logs[1, 0] - logs[0, 0])
    return float(np.exp(logs[0, 1] + slope * (np.log(error) - logs[0, 0])))


def main(kinds):
    for kind in kinds:
        pixels, true = truth(kind)
        tables = {}
        for name, source in (("GlassWorkbench", ours), ("Mitsuba", mitsubas)):
            tables[name] = []
            for row in source(kind, pixels, true):
                tables[name].append(row)
                label, seconds, error, bias, remark = row
                print(
                    f"{kind:<12}{name:<16}{label:<16}{seconds:>8.2f} CPU s{error:>9.3%}  bias {bias:+.3%}  {remark}",
                    flush=True,
                )
        for error in ERRORS:
            us, them = (seconds_to(error, tables[name]) for name in ("GlassWorkbench", "Mitsuba"))
            print(f"{kind}: {error:.1%} takes {us:.2f} CPU s against {them:.1f} of Mitsuba: 1/{them / us:.1f}")


if __name__ == "__main__":
    main(sys.argv[1:] or ("panel", "environment"))
