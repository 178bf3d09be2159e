"""Scene in, image out: what is asked is checked, traced in passes, and delivered with its report."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple

import numpy as np

from glassworkbench import __version__
from glassworkbench.errors import InputError
from glassworkbench.images import Image
from glassworkbench.scene import Scene
from glassworkbench.scene.digest import digest
from glassworkbench.scene.validate import positive
from glassworkbench.tracer import native
from glassworkbench.tracer.checkpoint import Checkpoint
from glassworkbench.tracer.control import Cancel
from glassworkbench.tracer.part import Part
from glassworkbench.tracer.plan import Plan, plan
from glassworkbench.tracer.progress import Meter
from glassworkbench.tracer.rendering import Rendering

DEFAULT_TOLERANCE = 0.02
TIMED_TOLERANCE = 0.001
"""What is aimed at where the user gives a time instead of a tolerance."""

COARSEST_TARGET = 0.25
"""The error that the first pass aims at, where there are several."""

TARGET_STEP = 0.25
"""Against the clock, each pass aims at this share of the error of the one before."""


def render(
    scene: Scene,
    *,
    tolerance: float | None = None,
    seconds: float | None = None,
    threads: int | None = None,
    crop: Sequence[int] | None = None,
    region: Sequence[int] | None = None,
    effects: Mapping[str, bool] | None = None,
    cancel: Cancel | None = None,
    progress: Callable[[float], None] | None = None,
    on_pass: Callable[[Image], None] | None = None,
    checkpoint: str | os.PathLike | None = None,
    resume: bool = False,
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
    crop : (int, int, int, int), optional
        Left, top, width, height in pixels of the part that is delivered; it is, to the last byte, what the whole
        image has there.
    region : (int, int, int, int), optional
        The part where the tolerance counts; elsewhere the first pass has to do, at an error of 0.25.
    effects : mapping of str to bool, optional
        Effects to switch on or off against the plan.
    cancel : Cancel, optional
        Set from any thread.
    progress : callable, optional
        Called with the done share of the work, 0 to 1, never falling.
    on_pass : callable, optional
        Called with the image after each pass but the last.
    checkpoint : path, optional
        A file that keeps the state every half minute and when the rendering is cancelled, and vanishes when the
        image is done.
    resume : bool
        Go on from that file: the image is the same as if the rendering had never stopped, and `seconds` count on.

    Returns
    -------
    Image
        With certificate, depth and report.

    Raises
    ------
    InputError
        If the tolerance, the seconds, a part of the image or an effect's name cannot be used, or the checkpoint is
        missing, damaged, or of another rendering.
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
    delivered, refined = Part.of(crop, scene.size, "crop"), Part.of(region, scene.size, "region")
    if not np.any(delivered.mask(scene.size) & refined.mask(scene.size)):
        raise InputError(f"region: nothing of {region} lies in the crop {crop}; move one of them")
    targets = _targets(tolerance, seconds is not None, region is not None, on_pass is not None)
    kept = None
    if checkpoint is not None:
        kept = Checkpoint(checkpoint, _asked(scene, chosen, targets, delivered, refined))
    elif resume:
        raise InputError("resume: there is no checkpoint to go on from; name its file")
    rendering = Rendering(
        scene,
        chosen,
        crop=delivered,
        region=refined,
        threads=threads or native.default_threads(),
        cancel=cancel or Cancel(),
        meter=Meter(progress),
        checkpoint=kept,
    )
    if resume:
        rendering.resume()
    set_up_seconds = time.perf_counter() - started

    def image() -> Image:
        return _image(rendering, delivered, refined if region is not None else None, set_up_seconds)

    for number in range(rendering.place.number, len(targets)):
        place = rendering.place
        if number > 0 and place.step == 0 and place.wanted is None:
            if on_pass is not None:
                on_pass(image())
            if seconds is None:
                # What the glance found must not decide what the image is.
                rendering.trace_anew()
        if not rendering.trace(targets[number], np.inf if seconds is None else seconds):
            break
    rendering.meter.finish()
    done = image()
    if kept is not None:
        kept.remove()
    return done


def _targets(tolerance: float, is_timed: bool, has_region: bool, is_watched: bool) -> list[float]:
    """Return the error that each pass aims at.

    Against the clock ever finer ones; else nothing is done twice, but for a glance first where somebody looks on, or
    where most of the image needs no more.
    """
    targets = [tolerance]
    if is_timed:
        while targets[0] < COARSEST_TARGET:
            targets.insert(0, targets[0] / TARGET_STEP)
    elif has_region or is_watched:
        targets.insert(0, max(COARSEST_TARGET, tolerance))
    return targets


def _asked(scene: Scene, chosen: Plan, targets: list[float], crop: Part, region: Part) -> dict[str, str]:
    """Return what the image depends on, by the words in which a checkpoint is refused."""
    return {
        "version of GlassWorkbench": __version__,
        "scene": digest(scene),
        "tolerance": repr(chosen.tolerance),
        "choice of effects": repr([effect.name for effect in chosen.effects if effect.on]),
        "crop": repr(crop),
        "region": repr(region),
        "sequence of passes": repr(targets),
    }


def _image(rendering: Rendering, crop: Part, region: Part | None, set_up_seconds: float) -> Image:
    scene, film, chosen = rendering.scene, rendering.film, rendering.chosen
    counts = ... if region is None else crop.cut(region.mask(scene.size))

    def cut(values: np.ndarray) -> np.ndarray:
        return crop.cut(values.reshape(film.height, film.width, *values.shape[1:]))

    pruned, sampling, surface = cut(film.pruned), cut(film.sampling), rendering.surface_error
    total = pruned + sampling + surface
    report = {
        "seconds": round(rendering.seconds(), 3),
        "set_up_seconds": round(set_up_seconds, 3),
        "size": [crop.width, crop.height],
        "crop": list(astuple(crop)),
        "region": None if region is None else list(astuple(region)),
        "threads": rendering.threads,
        "tolerance": chosen.tolerance,
        "certificate": {
            "pruned": float(pruned[counts].mean()),
            "sampling": float(sampling[counts].mean()),
            "surface": float(surface[counts].mean()),
            "total_p50": float(np.percentile(total[counts], 50)),
            "total_p99": float(np.percentile(total[counts], 99)),
            "total_max": float(total[counts].max()),
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
        cut(film.radiance).copy(),
        total,
        cut(film.depth_mm).copy(),
        dict(scene.metadata),
        report,
        corner=(crop.left, crop.top),
        whole=scene.size,
    )
