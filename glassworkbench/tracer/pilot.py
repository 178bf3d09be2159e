"""A few patches of an image, traced as the whole image would be: what it costs and shows, before it is rendered."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from glassworkbench.scene import Scene, is_mirror_symmetric
from glassworkbench.tracer.control import Cancel
from glassworkbench.tracer.part import Part
from glassworkbench.tracer.plan import Plan
from glassworkbench.tracer.progress import Meter
from glassworkbench.tracer.rendering import Place, Rendering

PATCH = 8
"""Pixels along a patch: far below a tile, so that few patches meet all there is in an image, and whole blocks of 2."""

GOLDEN = np.array([0.7548776662466927, 0.5698402909980532])
"""Steps of the additive recurrence in two dimensions that fills a square most evenly (powers of 1 / 1.32471...)."""


def patches(scene: Scene) -> list[Part]:
    """Return all patches of the image's traced part in an order whose every beginning covers the image evenly."""
    width, height = _traced_columns(scene), scene.size[1]
    across, down = -(-width // PATCH), -(-height // PATCH)
    places = ((np.arange(8 * across * down)[:, None] * GOLDEN + 0.5) % 1.0 * (across, down)).astype(int)
    places = np.vstack([places, [(i, j) for j in range(down) for i in range(across)]])
    _, first = np.unique(places @ (1, across), return_index=True)
    return [
        Part(left, top, min(PATCH, width - left), min(PATCH, height - top))
        for left, top in (PATCH * places[np.sort(first)]).tolist()
    ]


class Pilot:
    """Traces patches of an image by a plan.

    Parameters
    ----------
    scene : Scene
    chosen : Plan
    threads : int
    cancel : Cancel

    Attributes
    ----------
    set_up : array (2,)
        Seconds, and processor seconds, that pass before the first pixel of the whole image.
    pixels : int
        That the whole image traces: half of them where the other half is their mirror image.
    """

    def __init__(self, scene: Scene, chosen: Plan, threads: int, cancel: Cancel) -> None:
        began = _clocks()
        self._rendering = _OfPatches(
            scene,
            chosen,
            crop=Part(0, 0, *scene.size),
            region=Part(0, 0, *scene.size),
            threads=threads,
            cancel=cancel,
            meter=Meter(None),
            checkpoint=None,
        )
        self.set_up = _clocks() - began
        self.pixels = _traced_columns(scene) * scene.size[1]

    def trace(self, parts: Sequence[Part]) -> tuple[np.ndarray, np.ndarray]:
        """Trace patches.

        Returns
        -------
        cost : array (2,)
            Seconds, and processor seconds, that they take as parts of the whole image.
        radiance : array (pixels of all patches, 3)
        """
        film = self._rendering.film
        rays = film.totals[0]
        began = _clocks()
        self._rendering.trace_parts(parts)
        cost = _clocks() - began
        rays = film.totals[0] - rays
        # In the whole image neighbouring patches share the rays at their corners.
        shared = sum(part.width + part.height + 1 for part in parts)
        image = film.radiance.reshape(film.height, film.width, 3)
        radiance = np.concatenate([part.cut(image).reshape(-1, 3) for part in parts]).astype(np.float64)
        return cost * max(rays - shared, 1) / max(rays, 1), radiance


class _OfPatches(Rendering):
    def trace_parts(self, parts: Sequence[Part]) -> None:
        self._region = np.any([part.mask(self.scene.size) for part in parts], axis=0)
        # Only passes after the first look at the region.
        self.place = Place(1)
        self.trace(self.chosen.tolerance, np.inf)


def _traced_columns(scene: Scene) -> int:
    return -(-scene.size[0] // 2) if is_mirror_symmetric(scene) else scene.size[0]


def _clocks() -> np.ndarray:
    return np.array([time.perf_counter(), time.process_time()])
