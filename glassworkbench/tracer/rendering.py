"""A film on its way to an image: passes over its tiles, each where the estimate says that it is needed."""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from glassworkbench.errors import Cancelled
from glassworkbench.scene import Scene, Telecentric, is_mirror_symmetric
from glassworkbench.tracer import native
from glassworkbench.tracer.checkpoint import Checkpoint, Place, Stopped
from glassworkbench.tracer.control import Cancel
from glassworkbench.tracer.extent import longest_chord_mm
from glassworkbench.tracer.film import Film
from glassworkbench.tracer.part import Part
from glassworkbench.tracer.plan import LARGEST_CUTOFF, Plan
from glassworkbench.tracer.progress import Meter
from glassworkbench.tracer.reference_film import ReferenceScene
from glassworkbench.tracer.surface_error import surface_error
from glassworkbench.tracer.tiles import tiles_of

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

WORTH_SECONDS = 5.0
"""What is cancelled sooner is begun anew as fast as it is read."""


class Rendering:
    """A film, how far it is, and the error (h, w) of the crop's pixels that its approximate surfaces add.

    Parameters
    ----------
    scene : Scene
    chosen : Plan
    crop : Part
        What of the image is wanted at all.
    region : Part
        Where the passes after the first go on.
    threads : int
    cancel : Cancel
    meter : Meter
    checkpoint : Checkpoint, optional
        Where it is left from time to time, and when it is cancelled.
    """

    def __init__(
        self,
        scene: Scene,
        chosen: Plan,
        *,
        crop: Part,
        region: Part,
        threads: int,
        cancel: Cancel,
        meter: Meter,
        checkpoint: Checkpoint | None,
    ) -> None:
        self.scene, self.chosen = scene, chosen
        self.threads, self.cancel, self.meter, self.checkpoint = threads, cancel, meter, checkpoint
        self.film = Film(*scene.size)
        self.place = Place()
        self.is_mirrored = is_mirror_symmetric(scene)
        self._crop, self._region = crop.mask(scene.size), region.mask(scene.size)
        if self.is_mirrored:
            for mask in (self._crop, self._region):
                mask |= mask[:, ::-1].copy()
        self._began = time.perf_counter()
        self._seconds_before = 0.0
        self._engine = _engine(scene)
        self._halvings = _halvings(scene)
        self._ambient = self._measured_ambient()
        self.surface_error = surface_error(scene, crop, self._probe)

    def resume(self) -> None:
        """Go on from the checkpoint.

        Raises
        ------
        InputError
            If it is missing, damaged, or of another rendering.
        """
        stopped = self.checkpoint.read(self.film)
        self.place, self.meter.share, self._seconds_before = stopped.place, stopped.share, stopped.seconds

    def seconds(self) -> float:
        """Return how long it took so far, the time before a checkpoint included."""
        return self._seconds_before + time.perf_counter() - self._began

    def trace_anew(self) -> None:
        """Let the next pass trace the region as if there had been none."""
        self.film.sampling[self._region.ravel()] = np.inf

    def trace(self, target: float, seconds: float) -> bool:
        """Make the pass at hand: every pixel's error below a target; return whether there is time for another.

        Parameters
        ----------
        target : float
        seconds : float
            The time for all passes; the first is finished in any case.
        """
        number = self.place.number
        first = number == 0
        cutoff = min(self.chosen.cutoff * target / self.chosen.tolerance, LARGEST_CUTOFF)
        for step in range(self.place.step, DEEPEST + 1):
            if first and step > 0 and seconds < np.inf:
                break
            if self.place.wanted is None:
                self.place = Place(number, step, self._wanted(target, step))
            tiles = tiles_of(self.place.wanted)
            if len(tiles) == 0:
                break
            tiles = tiles[self.place.tiles :]
            self.meter.expect(len(tiles))
            for batch in _batches(tiles):
                if not (first and step == 0) and self.seconds() > seconds:
                    return False
                self._trace_batch(batch, target, cutoff * CUTOFF_STEP**step)
            if self.is_mirrored:
                self.film.mirror()
            self.place = Place(number, step + 1)
        self.place = Place(number + 1)
        return self.seconds() <= seconds

    def _trace_batch(self, batch: np.ndarray, target: float, cutoff: float) -> None:
        totals = self.film.totals.copy()
        try:
            self.cancel.check()
            self._engine.image(
                self.film,
                batch,
                self.place.wanted,
                tolerance=target,
                halvings=self._halvings,
                cutoff=cutoff,
                ambient=self._ambient,
                absorption=self.chosen.is_on("absorption"),
                threads=self.threads,
                cancel=self.cancel,
            )
        except Cancelled as stop:
            # The batch is traced again, and shall not be counted twice.
            self.film.totals[:] = totals
            if self.checkpoint is not None and self.seconds() > WORTH_SECONDS:
                self._leave()
                raise Cancelled(f"cancelled; resume=True goes on from {self.checkpoint.path}") from stop
            raise
        self.place = replace(self.place, tiles=self.place.tiles + len(batch))
        self.meter.advance(len(batch))
        if self.checkpoint is not None and self.checkpoint.is_due():
            self._leave()

    def _leave(self) -> None:
        self.checkpoint.write(self.film, Stopped(self.place, self.meter.share, self.seconds()))

    def _wanted(self, target: float, step: int) -> np.ndarray:
        """Return the pixels (h, w) that are not good enough: later only those of which too much was left out."""
        film = self.film
        wanted = (film.error > target) if step == 0 else (film.pruned > 0.5 * target)
        asked = self._crop if self.place.number == 0 else self._crop & self._region
        wanted = (wanted.reshape(asked.shape) & asked).astype(np.uint8)
        if self.is_mirrored:
            wanted[:, -(-film.width // 2) :] = 0
        return wanted

    def _probe(self, scene: Scene, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Return what rays see of a scene that differs from the rendering's own in its surfaces alone."""
        engine = self._engine if scene is self.scene else type(self._engine)(scene)
        seen = engine.radiance(
            origins,
            directions,
            cutoff=self.chosen.cutoff,
            absorption=self.chosen.is_on("absorption"),
            threads=self.threads,
            cancel=self.cancel,
        )
        return seen.radiance + seen.left_out * self._ambient

    def _measured_ambient(self) -> np.ndarray:
        """Return the mean light (3,) at the end of paths that a smaller cut-off adds, on a few rays."""
        width, height = self.scene.size
        column, row = np.meshgrid(
            (np.arange(PILOT_SIDE) + 0.5) / PILOT_SIDE, (np.arange(PILOT_SIDE) + 0.5) / PILOT_SIDE
        )
        rays = self.scene.camera.rays((2.0 * column.ravel() - 1.0) * width / height, 1.0 - 2.0 * row.ravel())
        absorption = self.chosen.is_on("absorption")
        coarse, fine = (
            self._engine.radiance(
                *rays,
                cutoff=self.chosen.cutoff * share,
                absorption=absorption,
                threads=self.threads,
                cancel=self.cancel,
            )
            for share in (1.0, CUTOFF_STEP)
        )
        more = np.sum(coarse.left_out - fine.left_out, axis=0)
        light = np.sum(fine.radiance - coarse.radiance, axis=0)
        return np.clip(light / np.maximum(more, 1e-300), 0.0, self.scene.brightest())


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
