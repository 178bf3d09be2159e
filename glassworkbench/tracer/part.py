"""A rectangle of the image's pixels: what is delivered of it, or refined in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError


@dataclass(frozen=True)
class Part:
    """A rectangle of whole pixels; column 0, row 0 is the image's upper left pixel."""

    left: int
    top: int
    width: int
    height: int

    @classmethod
    def of(cls, value: object, size: tuple[int, int], field: str) -> Part:
        """Return the part that four numbers x, y, width, height name; the whole image for None.

        Parameters
        ----------
        value : sequence of 4 int, or None
        size : (int, int)
            Width and height of the whole image.
        field : str
            What the message of an error begins with.

        Raises
        ------
        InputError
            If it is no such sequence, or does not lie in the image.
        """
        if value is None:
            return cls(0, 0, *size)
        try:
            left, top, width, height = (int(number) for number in value)
            is_whole = all(float(number).is_integer() for number in value)
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(f"{field}: expected x, y, width, height in pixels, got {value!r}") from error
        if not is_whole:
            raise InputError(f"{field}: expected whole numbers of pixels, got {value!r}")
        if min(left, top) < 0 or min(width, height) < 1 or left + width > size[0] or top + height > size[1]:
            raise InputError(
                f"{field}: {width}x{height} pixels at {left},{top} do not lie in the image of {size[0]}x{size[1]}"
            )
        return cls(left, top, width, height)

    def cut(self, values: np.ndarray) -> np.ndarray:
        """Return this part of an array (h, w, ...) over the whole image, as a view."""
        return values[self.top : self.top + self.height, self.left : self.left + self.width]

    def mask(self, size: tuple[int, int]) -> np.ndarray:
        """Return a mask (h, w) of the image of which it is a part."""
        mask = np.zeros((size[1], size[0]), dtype=bool)
        self.cut(mask)[:] = True
        return mask
