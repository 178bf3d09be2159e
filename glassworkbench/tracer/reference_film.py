"""The reference tracer behind the same door as the native core, for machines without a compiler."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from glassworkbench.scene import Scene
from glassworkbench.tracer import reference
from glassworkbench.tracer.control import Cancel
from glassworkbench.tracer.film import Film
from glassworkbench.tracer.sampling import sample_points


class ReferenceScene:
    """A scene that `render` can sample with the numpy reference, slowly."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene

    def sample(
        self,
        film: Film,
        pixels: np.ndarray,
        samples: int,
        *,
        cutoff: float,
        absorption: bool,
        threads: int,
        cancel: Cancel,
    ) -> None:
        """Add the next samples to some pixels of a film; see `NativeScene.sample`."""
        if len(pixels) == 0:
            return
        width, height = self._scene.size
        scene = self._scene if absorption else _without_absorption(self._scene)
        for number in range(int(film.samples[pixels[0]]), samples):
            cancel.check()
            inside = sample_points(pixels, number)
            column, row = pixels % width + inside[:, 0], pixels // width + inside[:, 1]
            rays = self._scene.camera.rays((2.0 * column - width) / height, 1.0 - 2.0 * row / height)
            answer = reference.radiance(scene, *rays, cutoff=cutoff)
            film.sum[pixels] += answer.radiance
            film.low[pixels] = np.minimum(film.low[pixels], answer.radiance)
            film.high[pixels] = np.maximum(film.high[pixels], answer.radiance)
            film.bound[pixels] += answer.bound
            if number == 0:
                film.depth_mm[pixels] = answer.depth_mm
            film.add_totals(len(pixels), answer.crossings.sum(), answer.leaks.sum())
        film.samples[pixels] = samples


def _without_absorption(scene: Scene) -> Scene:
    return replace(scene, media=[replace(medium, absorption_per_mm=np.zeros(3)) for medium in scene.media])
