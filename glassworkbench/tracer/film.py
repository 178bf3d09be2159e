"""What a rendering has gathered so far, pixel by pixel."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np


class Film:
    """The image and its errors while a rendering runs.

    Parameters
    ----------
    width, height : int
        In pixels; arrays are row-major over pixels, in float32 as files hold them: an image of 24 megapixels takes
        half a gigabyte.

    Attributes
    ----------
    radiance : array (pixels, 3)
    sampling : array (pixels,)
        Estimated error of averaging over the pixel; infinite where nothing was traced yet.
    pruned : array (pixels,)
        Bound on the error of what was left out.
    depth_mm : array (pixels,)
        Distance to the first change of medium at the pixel's centre.
    totals : int64 array (3,)
        Traced rays from the camera, crossings, leaks.
    """

    def __init__(self, width: int, height: int) -> None:
        pixels = width * height
        self.width, self.height = width, height
        self.radiance = np.zeros((pixels, 3), dtype=np.float32)
        self.sampling = np.full(pixels, np.inf, dtype=np.float32)
        self.pruned = np.full(pixels, np.inf, dtype=np.float32)
        self.depth_mm = np.full(pixels, np.inf, dtype=np.float32)
        self.totals = np.zeros(3, dtype=np.int64)

    @property
    def error(self) -> np.ndarray:
        """The certificate (pixels,)."""
        return self.sampling + self.pruned

    def to_arrays(self) -> dict[str, np.ndarray]:
        """Return its arrays by name, not copied."""
        names = ("radiance", "sampling", "pruned", "depth_mm", "totals")
        return {name: getattr(self, name) for name in names}

    def fill(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Take over arrays of the same shapes, as `to_arrays` gave them.

        Raises
        ------
        ValueError
            If a shape differs.
        """
        for name, mine in self.to_arrays().items():
            if arrays[name].shape != mine.shape:
                raise ValueError(f"{name}: expected shape {mine.shape}, got {arrays[name].shape}")
            mine[:] = arrays[name]

    def mirror(self) -> None:
        """Write the left half of the image into the right one."""
        for values in (self.radiance, self.sampling, self.pruned, self.depth_mm):
            image = values.reshape(self.height, self.width, -1)
            half = self.width // 2
            image[:, self.width - half :] = image[:, :half][:, ::-1]
