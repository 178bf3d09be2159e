"""The reference tracer behind the same door as the native core, for machines without a compiler."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from glassworkbench.scene import Scene
from glassworkbench.tracer import reference
from glassworkbench.tracer.control import Cancel
from glassworkbench.tracer.film import Film
from glassworkbench.tracer.result import Radiance
from glassworkbench.tracer.tiles import pixels_of

SIDES = (1, 2, 4, 8, 16)
"""The squares of these are traced in a pixel, until the estimate lies below the tolerance."""

GOLDEN_RATIO = 0.6180339887498949
"""Steps of this length cover a line evenly (Weyl's sequence)."""


class ReferenceScene:
    """A scene that `render` can trace with the numpy reference: pixels are averaged over plain sets of rays."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene

    def radiance(
        self,
        origins: np.ndarray,
        directions: np.ndarray,
        *,
        cutoff: float,
        absorption: bool,
        threads: int,
        cancel: Cancel,
    ) -> Radiance:
        """Trace rays, all at once on one thread; see `reference.radiance`."""
        cancel.check()
        return reference.radiance(self._traced(absorption), origins, directions, cutoff=cutoff)

    def image(
        self,
        film: Film,
        tiles: np.ndarray,
        wanted: np.ndarray,
        *,
        tolerance: float,
        halvings: int,
        cutoff: float,
        ambient: np.ndarray,
        absorption: bool,
        threads: int,
        cancel: Cancel,
    ) -> None:
        """Trace the wanted pixels of some tiles; see `NativeScene.image`.

        The error of n samples is estimated from their range h as that of an edge through the pixel,
        h n^(-3/4) / 2 (Mitchell 1996).
        """
        pixels = np.concatenate([pixels_of(tile, film.width, film.height) for tile in tiles])
        pixels = pixels[wanted.ravel()[pixels] != 0]
        film.depth_mm[pixels] = self._seen(pixels % film.width + 0.5, pixels // film.width + 0.5, 1.0, False).depth_mm
        brightest = self._scene.brightest()
        worst = max(np.max(ambient), brightest - np.min(ambient))
        for side in SIDES[min(halvings, 2) :]:
            cancel.check()
            if len(pixels) == 0:
                return
            values, left_out = [], []
            for step in range(side * side):
                column = pixels % film.width + (step + 0.5) / side**2
                row = pixels // film.width + step * GOLDEN_RATIO % 1.0
                answer = self._seen(column, row, cutoff, absorption)
                values.append(answer.radiance)
                left_out.append(answer.left_out)
                film.totals += [len(pixels), answer.crossings.sum(), answer.leaks.sum()]
            missing = np.mean(left_out, axis=0)
            film.radiance[pixels] = np.mean(values, axis=0) + missing * ambient
            film.pruned[pixels] = missing.max(axis=1) * worst
            height = np.ptp(values, axis=0).max(axis=1) if side > 1 else np.full(len(pixels), brightest)
            film.sampling[pixels] = 0.5 * height * len(values) ** -0.75
            pixels = pixels[film.sampling[pixels] > tolerance]

    def _seen(self, column: np.ndarray, row: np.ndarray, cutoff: float, absorption: bool) -> Radiance:
        width, height = self._scene.size
        rays = self._scene.camera.rays((2.0 * column - width) / height, 1.0 - 2.0 * row / height)
        return reference.radiance(self._traced(absorption), *rays, cutoff=cutoff)

    def _traced(self, absorption: bool) -> Scene:
        if absorption:
            return self._scene
        media = [replace(medium, absorption_per_mm=np.zeros(3)) for medium in self._scene.media]
        return replace(self._scene, media=media)
