"""Scene in, image out: passes of samples, each where the estimate says that it is needed."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from glassworkbench import __version__
from glassworkbench.errors import InputError
from glassworkbench.images import Image
from glassworkbench.scene import Mesh, Scene
from glassworkbench.scene.validate import positive
from glassworkbench.tracer import native
from glassworkbench.tracer.control import Cancel
from glassworkbench.tracer.film import Film
from glassworkbench.tracer.plan import LARGEST_CUTOFF, Plan, plan
from glassworkbench.tracer.reference_film import ReferenceScene

DEFAULT_TOLERANCE = 0.02
TIMED_TOLERANCE = 0.001
"""What is aimed at where the user gives a time instead of a tolerance."""

COARSEST_TARGET = 0.25
"""The error that a timed rendering brings every pixel below before it goes on to a quarter of it."""

CUTOFF_STEP = 0.25
"""How much smaller the cut-off becomes where too much was left out."""

BATCH_SECONDS = 0.1
"""Length of one call into the core: how often progress is told."""


def render(
    scene: Scene,
    *,
    tolerance: float | None = None,
    seconds: float | None = None,
    threads: int | None = None,
    effects: Mapping[str, bool] | None = None,
    cancel: Cancel | None = None,
    progress: Callable[[float], None] | None = None,
    on_pass: Callable[[Image], None] | None = None,
) -> Image:
    """Render a scene.

    Parameters
    ----------
    scene : Scene
    tolerance : float, optional
        Accepted error of a pixel's radiance (a plain panel of radiance 1 is white). Sampling goes on where the
        estimate lies above it. 0.02 where not given, 0.001 where `seconds` is given instead.
    seconds : float, optional
        Stop refining once this time is over; the first pass is always finished.
    threads : int, optional
        All processors where not given. The image does not depend on it.
    effects : mapping of str to bool, optional
        Effects to switch on or off against the plan.
    cancel : Cancel, optional
        Set from any thread.
    progress : callable, optional
        Called with the done share of the work, 0 to 1, never falling.
    on_pass : callable, optional
        Called with the image after each pass but the last.

    Returns
    -------
    Image
        With certificate, depth and report.

    Raises
    ------
    InputError
        If the tolerance, the seconds or an effect's name cannot be used.
    Cancelled
        If `cancel` was set.
    """
    started = time.perf_counter()
    if tolerance is None:
        tolerance = DEFAULT_TOLERANCE if seconds is None else TIMED_TOLERANCE
    if not isinstance(scene, Scene):
        raise InputError(f"scene: {scene!r} is no scene; give what station or read_scene returns")
    chosen = plan(scene, tolerance, effects)
    if seconds is not None:
        positive(seconds, "seconds")
    if threads is not None and threads < 1:
        raise InputError(f"threads: must be at least 1, got {threads}")
    cancel = cancel or Cancel()
    engine = _engine(scene)
    film = Film(*scene.size)
    threads = threads or native.default_threads()
    deadline = started + seconds if seconds is not None else np.inf
    set_up_seconds = time.perf_counter() - started

    def image() -> Image:
        return _image(scene, film, chosen, threads, set_up_seconds, time.perf_counter() - started)

    meter = _Meter(progress)
    # Against the clock, coarse errors go first everywhere; else nothing is done twice.
    target = tolerance if seconds is None else max(tolerance, COARSEST_TARGET)
    cutoff = min(chosen.cutoff * target / tolerance, LARGEST_CUTOFF)
    while True:
        work = film.work(target)
        while not work and target > tolerance:
            target = max(tolerance, 0.25 * target)
            work = film.work(target)
        if len(work) == 0 or (film.rays > 0 and time.perf_counter() > deadline):
            break
        if film.rays > 0 and on_pass is not None:
            on_pass(image())
        first_pass = film.rays == 0
        meter.expect(sum(len(part.pixels) for part in work))
        for part in work:
            film.prepare(part)
            for batch in _batches(part.pixels):
                if not first_pass and time.perf_counter() > deadline:
                    break
                cancel.check()
                engine.sample(
                    film,
                    batch,
                    part.samples,
                    cutoff=cutoff * CUTOFF_STEP**part.depth,
                    absorption=chosen.is_on("absorption"),
                    threads=threads,
                    cancel=cancel,
                )
                meter.advance(len(batch))
    meter.finish()
    return image()


def _engine(scene: Scene) -> native.NativeScene | ReferenceScene:
    if native.available():
        return native.NativeScene(scene)
    # Python's default filter shows a warning once per place, which is what the user should see.
    warnings.warn(
        "the native tracer is not built, the slow numpy reference runs instead; 'make build' builds it",
        RuntimeWarning,
        stacklevel=3,
    )
    return ReferenceScene(scene)


def _batches(pixels: np.ndarray) -> Iterator[np.ndarray]:
    """Yield runs of pixels that take about BATCH_SECONDS each, whatever a pixel costs here."""
    start, size = 0, 1024
    while start < len(pixels):
        began = time.perf_counter()
        batch = pixels[start : start + size]
        yield batch
        start += len(batch)
        spent = max(time.perf_counter() - began, 1e-6)
        size = max(64, int(size * min(4.0, max(0.25, BATCH_SECONDS / spent))))


class _Meter:
    """Turns finished work into a share that never falls, though later passes are not known beforehand."""

    def __init__(self, tell: Callable[[float], None] | None) -> None:
        self._tell = tell
        self._shown = 0.0
        self._base = 0.0
        self._pass_share = 0.0
        self._pixels = self._done = 0

    def expect(self, pixels: int) -> None:
        self._base = self._shown
        self._pass_share = 0.5 * (1.0 - self._base)
        self._pixels, self._done = pixels, 0

    def advance(self, pixels: int) -> None:
        self._done += pixels
        self._shown = max(self._shown, self._base + self._pass_share * min(1.0, self._done / max(self._pixels, 1)))
        if self._tell is not None:
            self._tell(self._shown)

    def finish(self) -> None:
        if self._tell is not None:
            self._tell(1.0)


def _image(scene: Scene, film: Film, chosen: Plan, threads: int, set_up_seconds: float, seconds: float) -> Image:
    shape = (film.height, film.width)
    pruned, sampling = film.pruned(), film.sampling()
    total = pruned + sampling
    report = {
        "seconds": round(seconds, 3),
        "set_up_seconds": round(set_up_seconds, 3),
        "size": [film.width, film.height],
        "threads": threads,
        "tolerance": chosen.tolerance,
        "certificate": {
            "pruned": float(pruned.mean()),
            "sampling": float(sampling.mean()),
            "surface": _surface_error(scene),
            "total_p50": float(np.percentile(total, 50)),
            "total_p99": float(np.percentile(total, 99)),
            "total_max": float(total.max()),
        },
        "effects": [
            {"name": effect.name, "on": effect.on, "why": effect.why, "share": None} for effect in chosen.effects
        ],
        "camera_rays": film.rays,
        "intersections": film.crossings,
        "leaks": film.leaks,
        "version": __version__,
    }
    return Image(
        film.mean().reshape(*shape, 3),
        total.reshape(shape),
        film.depth_mm.reshape(shape),
        dict(scene.metadata),
        report,
    )


def _surface_error(scene: Scene) -> float | None:
    """Return the error that approximate surfaces add: none where all are exact, unknown where there is a mesh."""
    return None if any(isinstance(body.surface, Mesh) for body in scene.bodies) else 0.0
