"""A scene: bodies, the media in them, lights, a camera, and the size of its image."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene.bodies import Body
from glassworkbench.scene.cameras import Camera
from glassworkbench.scene.lights import Environment, Light
from glassworkbench.scene.media import Medium, medium_table

MAXIMUM_SIDE = 65536


@dataclass(frozen=True, eq=False)
class Scene:
    """All that an image depends on.

    Parameters
    ----------
    bodies : tuple of Body
    media : tuple of Medium
        The first that matches holds; elsewhere is air (refractive index 1).
    lights : tuple of Light
        At most one of them an environment; without one the surroundings are black.
    camera : Camera
    size : (int, int)
        Width and height of the image in pixels.
    metadata : mapping of str to str
        Carried into the image file: mold, wall, glass, station.

    Raises
    ------
    InputError
        If two bodies share a name, an expression names an unknown body, or the size is impossible.
    """

    bodies: tuple[Body, ...]
    media: tuple[Medium, ...]
    lights: tuple[Light, ...]
    camera: Camera
    size: tuple[int, int] = (480, 640)
    metadata: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("bodies", "media", "lights"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        names = [body.name for body in self.bodies]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"body name {name!r}: used twice; give each body its own name")
        width, height = self.size
        if not (0 < width <= MAXIMUM_SIDE and 0 < height <= MAXIMUM_SIDE) or width != int(width):
            raise InputError(f"image size: {width}x{height} pixels is impossible; each side is 1 to {MAXIMUM_SIDE}")
        if sum(isinstance(light, Environment) for light in self.lights) > 1:
            raise InputError("light: a scene may have only one environment")
        self.medium_table()

    def medium_table(self) -> np.ndarray:
        """Return which medium holds for each combination of bodies, int32 (2 ** bodies,); 0 is air."""
        return medium_table(tuple(body.name for body in self.bodies), self.media)

    def refractive_indices(self) -> np.ndarray:
        """Return the refractive index of air and of each medium, (1 + media,)."""
        return np.array([1.0, *(medium.refractive_index for medium in self.media)])

    def absorptions_per_mm(self) -> np.ndarray:
        """Return the absorption coefficients of air and of each medium, (1 + media, 3)."""
        return np.array([np.zeros(3), *(medium.absorption_per_mm for medium in self.media)])

    def brightest(self) -> float:
        """Return the largest radiance any ray can meet, over lights and channels."""
        return max((float(np.max(light.radiance)) for light in self.lights), default=0.0)
