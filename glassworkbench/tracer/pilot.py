"""A few patches of an image, traced as the whole image would be: what it costs and shows, before it is rendered."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from glassworkbench.scene import Scene, is_mirror_symmetric
from glassworkbench.tracer.control import Cancel
from glassworkbench.tracer.part import Part
from glassworkbench.tracer.plan import Plan
from glassworkbench.tracer.progress import Meter
from glassworkbench.tracer.rendering import Place, Rendering
from glassworkbench.tracer.surface_error import surface_error

PATCH = 8
"""Pixels along a patch: far below a tile, so that few patches meet all there is in an image, and whole blocks of 2."""

PROBED = 20_000
"""Pixels of the image that tells what the error of approximate surfaces takes."""

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
    """Traces patches of an image, by one plan or another.

    Parameters
    ----------
    scene : Scene
    chosen : Plan
        That sets it up.
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
            crop=patches(scene)[0],
            region=Part(0, 0, *scene.size),
            threads=threads,
            cancel=cancel,
            meter=Meter(None),
            checkpoint=None,
        )
        self.set_up = _clocks() - began + self._surface_cost()
        self.pixels = _traced_columns(scene) * scene.size[1]

    def trace(self, parts: Sequence[Part], chosen: Plan) -> tuple[np.ndarray, np.ndarray]:
        """Trace patches.

        Returns
        -------
        cost : array (2,)
            Seconds, and processor seconds, that they take as parts of the whole image.
        radiance : array (pixels of all patches, 3)
        """
        film = self._rendering.film
        self._rendering.turn_to(parts, chosen)
        rays = film.totals[0]
        began = _clocks()
        self._rendering.trace(chosen.tolerance, np.inf)
        cost = _clocks() - began
        rays = film.totals[0] - rays
        # In the whole image neighbouring patches share the rays at their corners.
        shared = sum(part.width + part.height + 1 for part in parts)
        image = film.radiance.reshape(film.height, film.width, 3)
        radiance = np.concatenate([part.cut(image).reshape(-1, 3) for part in parts]).astype(np.float64)
        return cost * max(rays - shared, 1) / max(rays, 1), radiance

    def _surface_cost(self) -> np.ndarray:
        """Return what the error of approximate surfaces takes for the whole image, told by a smaller one."""
        width, height = self._rendering.scene.size
        shrunk = max(1.0, np.sqrt(width * height / PROBED))
        small = replace(self._rendering.scene, size=(int(np.ceil(width / shrunk)), int(np.ceil(height / shrunk))))
        clocks = [_clocks()]
        for part in (Part(0, 0, 1, 1), Part(0, 0, *small.size)):
            self._rendering.probe_surfaces(small, part)
            clocks.append(_clocks())
        share = small.size[0] * small.size[1] / (width * height)
        return np.maximum(np.diff(clocks, n=2, axis=0)[0], 0.0) / share


class _OfPatches(Rendering):
    def turn_to(self, parts: Sequence[Part], chosen: Plan) -> None:
        """Make these patches, by this plan, what the next pass traces."""
        if chosen != self.chosen:
            self.chosen = chosen
            self._ambient = self._measured_ambient()
        self._crop = self._region = np.any([part.mask(self.scene.size) for part in parts], axis=0)
        self.trace_anew()
        self.place = Place()

    def probe_surfaces(self, scene: Scene, part: Part) -> None:
        surface_error(scene, part, self._probe)


def _traced_columns(scene: Scene) -> int:
    return -(-scene.size[0] // 2) if is_mirror_symmetric(scene) else scene.size[0]


def _clocks() -> np.ndarray:
    return np.array([time.perf_counter(), time.process_time()])
