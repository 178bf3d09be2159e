"""Does the true error lie under the certificate? Nine scenes at three tolerances, in radiance.

    certificate.py [SCENE ...]

The truth of a pixel is the mean of four independent jittered grids of rays at a tiny cut-off, seven times as many where
they disagree. How far those four still differ (twice their standard error), and what even that cut-off leaves out, is
the truth's own doubt, by which an error may pass the certificate. Truths are kept in out/bench. Only pixels that see
glass count. The ratio is certificate to error (or to the doubt, where the error is smaller than that can tell): its
median says how much too careful the certificate is.
"""

import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from certificate_scenes import SCENES  # noqa: E402

from glassworkbench.tracer import render  # noqa: E402
from glassworkbench.tracer.native import NativeScene  # noqa: E402

TOLERANCES = (0.1, 0.05, 0.02)
TRUE_CUTOFF = 1e-5
GRIDS = 4
SIDE, FINE_SIDE = 6, 16
"""Rays along a pixel in each grid, at first and where the grids disagree."""

DISAGREE = 5e-4
"""Standard error of the mean of the four grids above which a pixel gets the finer ones."""

ROUNDING = 1e-6
"""Of an image's numbers, which are float32."""

GOAL = 0.99
FOLDER = ROOT / "out" / "bench"


def grid(world, engine, pixels, side, rng):
    """Return mean radiance and bound of a jittered grid of rays in each pixel, and which pixels saw glass."""
    width, height = world.size
    row, column = np.divmod(pixels, width)
    total, bound, glass = np.zeros((len(pixels), 3)), np.zeros(len(pixels)), np.zeros(len(pixels), dtype=bool)
    for step in range(side * side):
        x = column + (step % side + rng.random(len(pixels))) / side
        y = row + (step // side + rng.random(len(pixels))) / side
        rays = world.camera.rays((2.0 * x - width) / height, 1.0 - 2.0 * y / height)
        seen = engine.radiance(*rays, cutoff=TRUE_CUTOFF)
        total += seen.radiance
        bound += seen.bound
        glass |= seen.crossings > 0
    return total / side**2, bound / side**2, glass


def truth(name, world):
    """Return the true radiance (n, 3), its doubt (n,), and which pixels see glass (n,)."""
    path = FOLDER / f"certificate_{name.replace(' ', '_')}.npz"
    if path.exists():
        kept = np.load(path)
        return kept["radiance"], kept["doubt"], kept["glass"]
    started = time.process_time()
    engine, rng = NativeScene(world), np.random.default_rng(12)
    count = world.size[0] * world.size[1]
    radiance, doubt, glass = np.empty((count, 3)), np.empty(count), np.zeros(count, dtype=bool)
    pixels = np.arange(count)
    for side in (SIDE, FINE_SIDE):
        grids = [grid(world, engine, pixels, side, rng) for _ in range(GRIDS)]
        means = np.array([mean for mean, _, _ in grids])
        missing = np.mean([bound for _, bound, _ in grids], axis=0)
        error = means.std(axis=0, ddof=1).max(axis=1) / np.sqrt(GRIDS)
        # What the cut-off leaves out is dark or bright: half of it, give or take the other half.
        radiance[pixels] = means.mean(axis=0) + 0.5 * missing[:, None]
        doubt[pixels] = 2.0 * error + 0.5 * missing
        glass[pixels] |= np.any([saw for _, _, saw in grids], axis=0)
        pixels = pixels[error > DISAGREE]
    FOLDER.mkdir(parents=True, exist_ok=True)
    np.savez(path, radiance=radiance, doubt=doubt, glass=glass)
    print(f"{name}: truth in {time.process_time() - started:.0f} CPU s", file=sys.stderr)
    return radiance, doubt, glass


def main(names):
    print(
        f"{'scene':<26}{'tolerance':>9}{'CPU s':>8}{'error 99 %':>11}{'under certificate':>18}"
        f"{'ratio median':>14}{'99 %':>8}   worst pixel: error, certificate"
    )
    failed = False
    for name in names:
        world = SCENES[name]()
        radiance, doubt, glass = truth(name, world)
        for tolerance in TOLERANCES:
            started = time.process_time()
            image = render(world, tolerance=tolerance)
            seconds = time.process_time() - started
            error = np.abs(image.pixels.reshape(-1, 3) - radiance).max(axis=1)
            certificate = image.certificate.ravel()
            excess = np.where(glass, error - doubt - certificate, -np.inf)
            under = np.mean(excess[glass] <= ROUNDING)
            ratio = certificate[glass] / np.maximum(np.maximum(error, doubt), ROUNDING)[glass]
            worst = int(np.argmax(excess))
            row, column = divmod(worst, world.size[0])
            told = "none"
            if excess[worst] > ROUNDING:
                told = f"({column}, {row}): {error[worst]:.3g}, {certificate[worst]:.3g}"
            failed |= under < GOAL
            print(
                f"{name:<26}{tolerance:>9g}{seconds:>8.2f}{np.percentile(error[glass], 99):>11.4f}{under:>18.2%}"
                f"{np.median(ratio):>14.1f}{np.percentile(ratio, 99):>8.0f}   {told}",
                flush=True,
            )
    return failed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:] or SCENES))
