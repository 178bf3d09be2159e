"""How time and memory grow: with pixels, faces, interfaces, the cut-off, bubbles and triangles; a large image's memory.

    growth.py [NAME ...]

CPU seconds of one thread, for the rays (or pixels) and, where a scene grows, for setting it up. The exponent is the
slope of log time over log size, fitted over the last three sizes; n log n has 1 + 1 / ln n. Plots go to
docs/pictures/growth.png when all are measured.
"""

import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

import peers  # noqa: E402
import tracer_scenes  # noqa: E402
from patch_bodies import ball_patches, tessellated  # noqa: E402

from glassworkbench.scene import Body, Ellipsoids, Environment, Medium, Pinhole, Scene, Sheet  # noqa: E402
from glassworkbench.tracer import render  # noqa: E402
from glassworkbench.tracer.native import NativeScene  # noqa: E402

RAYS = 20_000
REPEATS = 3
NOISE = 0.15
"""What the exponent may lie above that of n log n: a shared machine's clock."""

PICTURE = ROOT / "docs" / "pictures" / "growth.png"
LARGE = (6000, 4000)
LARGE_GB = 1.5


def glass(surface):
    return Scene(
        (Body("glass", surface),), (Medium("glass", 1.52, (0.002,) * 3),), (Environment(1.0),), tracer_scenes.CAMERA
    )


def seconds(work):
    """Return the least CPU seconds of a few runs, and what the last run returns."""
    spent = []
    for _ in range(REPEATS):
        started = time.process_time()
        answer = work()
        spent.append(time.process_time() - started)
    return min(spent), answer


def tracing(scene, rays, **settings):
    """Return CPU seconds of setting a scene up and of tracing rays through it."""
    started = time.process_time()
    engine = NativeScene(scene)
    set_up = time.process_time() - started
    return set_up, seconds(lambda: engine.radiance(*rays, threads=1, **settings))[0]


def pixels():
    """The peers' bottle before its panel, whole images of growing size."""
    world = peers.scene("panel")
    for height in (80, 160, 320, 640, 1280):
        sized = replace(world, size=(3 * height // 4, height))
        yield sized.size[0] * height, None, seconds(lambda: render(sized, tolerance=0.1, threads=1))[0]  # noqa: B023


def faces():
    """A ball of eight octants, each cut into ever more faces of eight triangles."""
    rays = tracer_scenes.rays_at((-10.0,) * 3, (10.0,) * 3, RAYS, seed=1)
    octants = ball_patches(10.0).sheets
    for pieces in (1, 2, 4, 8, 12, 20):
        body = tessellated([part for octant in octants for part in cut(octant, pieces)], 2, 2)
        yield len(body.sheets), *tracing(glass(body), rays)


def cut(octant, pieces):
    """Cut a biquadratic patch into a square of them: each passes through nine of its homogeneous points."""

    def basis(t):
        return np.stack([(1.0 - t) ** 2, 2.0 * t * (1.0 - t), t**2], axis=1)

    own = np.array([0.0, 0.5, 1.0])
    restrict = [np.linalg.solve(basis(own), basis((k + own) / pieces)) for k in range(pieces)]
    for u in restrict:
        for v in restrict:
            yield Sheet(np.einsum("ia,jb,abc->ijc", u, v, octant.control_points[0, 0])[None, None])


def depth():
    """The peers' bottle with paths of at most so many interfaces, at a cut-off of 1e-5."""
    world = peers.scene("panel")
    rays = tracer_scenes.rays_through(world, RAYS // 4, seed=2)
    engine = NativeScene(world)
    for most in (1, 2, 4, 8, 16, 32, 64, 128):
        trace = lambda: engine.radiance(*rays, threads=1, cutoff=1e-5, maximum_depth=most)  # noqa: B023, E731
        yield most, None, seconds(trace)[0]


def cutoff():
    """The peers' bottle, followed down to ever fainter light: the size is one over the cut-off."""
    world = peers.scene("panel")
    rays = tracer_scenes.rays_through(world, RAYS // 4, seed=3)
    engine = NativeScene(world)
    for weight in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6):
        yield round(1.0 / weight), None, seconds(lambda: engine.radiance(*rays, threads=1, cutoff=weight))[0]  # noqa: B023


def bubbles():
    """A box of 60 mm with ellipsoidal bubbles of up to 0.3 mm, all of them one body; set-up checks that none touch."""
    box = Body("box", tracer_scenes.box_mesh((-31.0,) * 3, (31.0,) * 3))
    rays = tracer_scenes.rays_at((-30.0,) * 3, (30.0,) * 3, RAYS, seed=4)
    for count in (0, 10, 100, 1000, 10_000):
        started = time.process_time()
        bodies = (box, Body("bubbles", ellipsoids(count))) if count else (box,)
        checked = time.process_time() - started
        where = "box and not bubbles" if count else "box"
        scene = Scene(bodies, (Medium(where, 1.52),), (Environment(1.0),), tracer_scenes.CAMERA)
        set_up, traced = tracing(scene, rays)
        yield count, checked + set_up, traced


def ellipsoids(count):
    """Ellipsoids that do not touch, at random places of a lattice."""
    rng = np.random.default_rng(5)
    lattice = np.stack(np.meshgrid(*[np.arange(25) - 12.0] * 3), axis=-1).reshape(-1, 3) * 2.4
    centres = rng.permutation(lattice)[:count] + rng.uniform(-0.8, 0.8, (count, 3))
    turns = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    return Ellipsoids(centres, rng.uniform(0.1, 0.3, (count, 3)), turns)


def triangles():
    """A ball as a mesh of ever more triangles."""
    rays = tracer_scenes.rays_at((-10.0,) * 3, (10.0,) * 3, RAYS, seed=6)
    for pieces in (8, 25, 80, 250):
        mesh = ball_patches(10.0, pieces).mesh
        yield len(mesh.triangles), *tracing(glass(mesh), rays)


MEASURES = {
    "pixels": pixels,
    "faces": faces,
    "depth": depth,
    "cutoff": cutoff,
    "bubbles": bubbles,
    "triangles": triangles,
}


def exponent(sizes, times):
    """Return the slope over the last three sizes, and that of n log n there."""
    last = [(n, t) for n, t in zip(sizes, times, strict=True) if n > 0][-3:]
    sizes, times = np.array(last).T
    slope = np.polyfit(np.log(sizes), np.log(times), 1)[0]
    return slope, 1.0 + 1.0 / np.log(np.sqrt(sizes[0] * sizes[-1]))


def large_image():
    """Return the peak resident memory in GB of a process that renders and saves an image of 24 megapixels."""
    run = subprocess.run([sys.executable, __file__, "--large-image"], check=True, stdout=subprocess.PIPE, text=True)
    print(run.stdout, end="", flush=True)
    return float(run.stdout.split()[-2])


def render_large_image():
    # A small ball: what is traced is cheap, what is kept of it is not.
    camera = Pinhole((0.0, -1000.0, 0.0), (0.0, 0.0, 0.0), 0.3)
    image = render(replace(glass(tracer_scenes.revolved_ball(10.0)), camera=camera, size=LARGE), tolerance=0.1)
    print(f"  rendered in {image.report['seconds']:.0f} s, {peak_gigabytes():.2f} GB")
    for ending in (".png", ".exr"):
        path = ROOT / "out" / f"large_image{ending}"
        path.parent.mkdir(exist_ok=True)
        image.save(path)
        path.unlink()
        print(f"  saved as {ending}, {peak_gigabytes():.2f} GB")


def peak_gigabytes():
    # What getrusage tells a process begins with its parent's.
    status = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in status if line.startswith("VmHWM")) / 1e6


def plot(measured):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(2, 3, figsize=(12.0, 7.0), layout="constrained")
    for axis, (name, rows) in zip(axes.flat, measured.items(), strict=True):
        sizes = np.array([max(size, 1) for size, _, _ in rows], dtype=float)
        for label, column in (("tracing", 2), ("setting up", 1)):
            if rows[0][column] is None:
                continue
            times = np.array([row[column] for row in rows])
            slope, _ = exponent([row[0] for row in rows], times)
            axis.loglog(sizes, times, "o-", label=f"{label}: $n^{{{slope:.2f}}}$")
        limit = sizes * np.log(np.maximum(sizes, np.e))
        axis.loglog(sizes, rows[-1][2] * limit / limit[-1], "--", color="grey", label=r"$n\,\log n$")
        axis.set_xlabel({"cutoff": "1 / cut-off", "depth": "most interfaces on a path"}.get(name, name))
        axis.set_ylabel("CPU seconds")
        axis.legend()
    figure.savefig(PICTURE, dpi=80)


def main(names):
    measured, worse = {}, []
    for name in names:
        measured[name] = []
        print(f"{name}: {MEASURES[name].__doc__}", flush=True)
        for row in MEASURES[name]():
            measured[name].append(row)
            size, set_up, spent = row
            told = "" if set_up is None else f"{set_up:>10.3f} s to set up"
            print(f"{size:>10}{spent:>10.3f} s{told}", flush=True)
        for label, column in (("tracing", 2), ("setting up", 1)):
            if measured[name][0][column] is not None:
                sizes, times = ([row[k] for row in measured[name]] for k in (0, column))
                slope, limit = exponent(sizes, times)
                print(f"  {label} grows as n^{slope:.2f}; n log n would be n^{limit:.2f}", flush=True)
                worse += [f"{name}, {label}"] if slope > limit + NOISE else []
    if list(measured) == list(MEASURES):
        plot(measured)
    print(f"an image of {LARGE[0]} x {LARGE[1]} pixels:", flush=True)
    gigabytes = large_image()
    worse += ["a large image's memory"] if gigabytes > LARGE_GB else []
    print(f"  peak memory {gigabytes:.2f} GB, at most {LARGE_GB:g} are allowed")
    print("worse than allowed: " + ", ".join(worse) if worse else "nothing is worse than allowed")
    return bool(worse)


if __name__ == "__main__":
    if sys.argv[1:] == ["--large-image"]:
        render_large_image()
    else:
        sys.exit(main(sys.argv[1:] or MEASURES))
