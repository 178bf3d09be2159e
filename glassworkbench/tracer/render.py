"""Scene in, image out: passes of samples, each where the estimate says that it is needed."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from glassworkbench import __version__
from glassworkbench.errors import InputError
from glassworkbench.images import Image
from glassworkbench.scene import Mesh, Scene, Telecentric, is_mirror_symmetric
from glassworkbench.scene.validate import positive
from glassworkbench.tracer import native
from glassworkbench.tracer.control import Cancel
from glassworkbench.tracer.film import Film
from glassworkbench.tracer.plan import LARGEST_CUTOFF, Plan, longest_chord_mm, plan
from glassworkbench.tracer.reference_film import ReferenceScene
from glassworkbench.tracer.tiles import tiles_of

DEFAULT_TOLERANCE = 0.02
TIMED_TOLERANCE = 0.001
"""What is aimed at where the user gives a time instead of a tolerance."""

COARSEST_TARGET = 0.25
"""The error that the first pass aims at, where there are several: each of the next aims at a quarter of it."""

CUTOFF_STEP = 0.25
"""How much smaller the cut-off becomes where too much was left out."""

DEEPEST = 1
"""How often a pixel's cut-off may be made smaller."""

PILOT_SIDE = 16
"""Rays along the image's sides that tell what light waits at the end of paths that are left out."""

FIRST_RAYS = 512
"""So many rays along the bodies see what there is to see, before the estimate decides where more are needed."""

MOST_HALVINGS = 3
"""How often a pixel may be halved unasked; the native core's ``Cells::most_halvings``."""

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
    rendering = _Rendering(scene, chosen, threads or native.default_threads(), cancel or Cancel(), _Meter(progress))
    deadline = started + seconds if seconds is not None else np.inf
    set_up_seconds = time.perf_counter() - started

    def image() -> Image:
        return _image(rendering, set_up_seconds, time.perf_counter() - started)

    # A glance first where somebody looks on, and against the clock ever finer passes; else nothing is done twice.
    targets = [tolerance]
    while (seconds is not None and targets[0] < COARSEST_TARGET) or (on_pass is not None and len(targets) == 1):
        targets.insert(0, max(COARSEST_TARGET, tolerance) if seconds is None else targets[0] / CUTOFF_STEP)
    for target in targets:
        if rendering.has_image:
            if on_pass is not None:
                on_pass(image())
            if seconds is None:
                # What the glance found must not decide what the image is.
                rendering.film.sampling[:] = np.inf
        if not rendering.trace(target, deadline):
            break
    rendering.meter.finish()
    return image()


def _engine(scene: Scene) -> native.NativeScene | ReferenceScene:
    if native.available():
        return native.NativeScene(scene)
    # Python's default filter shows a warning once per place, which is what the user should see.
    warnings.warn(
        "the native tracer is not built, the slow numpy reference runs instead; 'make build' builds it",
        RuntimeWarning,
        stacklevel=4,
    )
    return ReferenceScene(scene)


class _Rendering:
    """A film on its way to an image."""

    def __init__(self, scene: Scene, chosen: Plan, threads: int, cancel: Cancel, meter: _Meter) -> None:
        self.scene, self.chosen = scene, chosen
        self.threads, self.cancel, self.meter = threads, cancel, meter
        self.engine = _engine(scene)
        self.film = Film(*scene.size)
        self.halvings = _halvings(scene)
        self.is_mirrored = is_mirror_symmetric(scene)
        self.has_image = False
        self.ambient = self._ambient()

    def trace(self, target: float, deadline: float) -> bool:
        """Bring every pixel's error below a target, or tell that the time is over; the first pass is finished."""
        first = not self.has_image
        cutoff = min(self.chosen.cutoff * target / self.chosen.tolerance, LARGEST_CUTOFF)
        for step in range(DEEPEST + 1):
            wanted = self._wanted(target, step)
            tiles = tiles_of(wanted)
            if len(tiles) == 0:
                break
            self.meter.expect(len(tiles))
            for batch in _batches(tiles):
                if not first and time.perf_counter() > deadline:
                    return False
                self.cancel.check()
                self.engine.image(
                    self.film,
                    batch,
                    wanted,
                    tolerance=target,
                    halvings=self.halvings,
                    cutoff=cutoff * CUTOFF_STEP**step,
                    ambient=self.ambient,
                    absorption=self.chosen.is_on("absorption"),
                    threads=self.threads,
                    cancel=self.cancel,
                )
                self.meter.advance(len(batch))
            if self.is_mirrored:
                self.film.mirror()
            self.has_image = True
            if first and deadline < np.inf:
                break
        return time.perf_counter() <= deadline

    def _wanted(self, target: float, step: int) -> np.ndarray:
        """Return the pixels (h, w) that are not good enough: later only those of which too much was left out."""
        film = self.film
        wanted = (film.error > target) if step == 0 else (film.pruned > 0.5 * target)
        wanted = wanted.reshape(film.height, film.width).astype(np.uint8)
        if self.is_mirrored:
            wanted[:, -(-film.width // 2) :] = 0
        return wanted

    def _ambient(self) -> np.ndarray:
        """Return the mean light (3,) at the end of paths that a smaller cut-off adds, on a few rays."""
        width, height = self.scene.size
        column, row = np.meshgrid(
            (np.arange(PILOT_SIDE) + 0.5) / PILOT_SIDE, (np.arange(PILOT_SIDE) + 0.5) / PILOT_SIDE
        )
        rays = self.scene.camera.rays((2.0 * column.ravel() - 1.0) * width / height, 1.0 - 2.0 * row.ravel())
        absorption = self.chosen.is_on("absorption")
        coarse, fine = (
            self.engine.radiance(*rays, cutoff=self.chosen.cutoff * share, absorption=absorption)
            for share in (1.0, CUTOFF_STEP)
        )
        more = np.sum(coarse.left_out - fine.left_out, axis=0)
        light = np.sum(fine.radiance - coarse.radiance, axis=0)
        return np.clip(light / np.maximum(more, 1e-300), 0.0, self.scene.brightest())


def _halvings(scene: Scene) -> int:
    """Return how often pixels must be halved so that the first rays lie `FIRST_RAYS` to the bodies' extent."""
    camera = scene.camera
    if isinstance(camera, Telecentric):
        image_mm = camera.height_mm
    else:
        distance = np.linalg.norm(camera.target_mm - camera.origin_mm)
        image_mm = 2.0 * distance * np.tan(0.5 * camera.vertical_field_of_view_rad)
    across = longest_chord_mm(scene) / (image_mm / scene.size[1])
    return int(np.clip(np.ceil(np.log2(FIRST_RAYS / max(across, 1.0))), 0, MOST_HALVINGS))


def _batches(tiles: np.ndarray) -> Iterator[np.ndarray]:
    """Yield runs of tiles that take about BATCH_SECONDS each, whatever a tile costs here."""
    start, size = 0, 2
    while start < len(tiles):
        began = time.perf_counter()
        batch = tiles[start : start + size]
        yield batch
        start += len(batch)
        spent = max(time.perf_counter() - began, 1e-6)
        size = max(2, int(size * min(4.0, max(0.25, BATCH_SECONDS / spent))))


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


def _image(rendering: _Rendering, set_up_seconds: float, seconds: float) -> Image:
    scene, film, chosen = rendering.scene, rendering.film, rendering.chosen
    shape = (film.height, film.width)
    total = film.error
    report = {
        "seconds": round(seconds, 3),
        "set_up_seconds": round(set_up_seconds, 3),
        "size": [film.width, film.height],
        "threads": rendering.threads,
        "tolerance": chosen.tolerance,
        "certificate": {
            "pruned": float(film.pruned.mean()),
            "sampling": float(film.sampling.mean()),
            "surface": _surface_error(scene),
            "total_p50": float(np.percentile(total, 50)),
            "total_p99": float(np.percentile(total, 99)),
            "total_max": float(total.max()),
        },
        "effects": [
            {"name": effect.name, "on": effect.on, "why": effect.why, "share": None} for effect in chosen.effects
        ],
        "mirrored": rendering.is_mirrored,
        "camera_rays": int(film.totals[0]),
        "intersections": int(film.totals[1]),
        "leaks": int(film.totals[2]),
        "version": __version__,
    }
    return Image(
        film.radiance.reshape(*shape, 3).copy(),
        total.reshape(shape),
        film.depth_mm.reshape(shape).copy(),
        dict(scene.metadata),
        report,
    )


def _surface_error(scene: Scene) -> float | None:
    """Return the error that approximate surfaces add: none where all are exact, unknown where there is a mesh."""
    return None if any(isinstance(body.surface, Mesh) for body in scene.bodies) else 0.0
