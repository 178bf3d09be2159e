"""Where on the container a place of the image is: pixels to the millimetre, and where axis and base appear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene.cameras import Camera, Telecentric, camera_frame

STEEP = np.sqrt(0.5)
"""Vertical part of the view direction (45 degrees) from which a view is one from above or below."""

VIEWS = ("side", "above", "below")


@dataclass(frozen=True)
class ImageScale:
    """What takes pixels to places on a container that stands on z = 0 with its axis on z.

    Columns and rows count from the image's upper left corner: the middle of the first pixel is at 0.5, 0.5.

    Parameters
    ----------
    view : str
        ``"side"``, ``"above"`` or ``"below"``.
    px_per_mm : float
        Across, at the axis; from above and below, where the camera aims.
    rows_per_mm : float
        To a millimetre of height; 0 from above and below.
    axis_column : float
        Where the axis appears.
    base_row : float
        Where the axis meets z = 0; from above and below, the row where the axis appears at the height aimed at.
    azimuth_deg : float
        Where the camera stands, from +x towards +y.
    """

    view: str
    px_per_mm: float
    rows_per_mm: float
    axis_column: float
    base_row: float
    azimuth_deg: float

    def to_metadata(self) -> dict[str, str]:
        """Return the fields as an image file carries them."""
        return {name: value if name == "view" else f"{value:.9g}" for name, value in vars(self).items()}

    @classmethod
    def from_metadata(cls, told: Mapping[str, str]) -> ImageScale | None:
        """Return what an image file carries, None if it carries none.

        Raises
        ------
        InputError
            If the numbers are none, or the view is not known.
        """
        names = list(cls.__dataclass_fields__)
        if not all(name in told for name in names):
            return None
        try:
            scale = cls(told["view"], *(float(told[name]) for name in names[1:]))
        except ValueError as error:
            raise InputError(f"metadata: {', '.join(names[1:])} must be numbers ({error})") from error
        if scale.view not in VIEWS or not scale.px_per_mm > 0.0:
            raise InputError(f"metadata: view {scale.view!r} at {scale.px_per_mm:g} px/mm is impossible")
        return scale

    def place(self, column: float, row: float, radius_mm: float) -> tuple[float | None, float]:
        """Return height (mm) and angle (deg, 0 to 360, from +x towards +y) of a place in the image.

        Parameters
        ----------
        column, row : float
        radius_mm : float
            Half the container's width at this row: a side view takes the place to be on the near side.

        Returns
        -------
        (float or None, float)
            The height is not known from above or below.
        """
        right_mm = (column - self.axis_column) / self.px_per_mm
        if self.view == "side":
            angle = self.azimuth_deg + np.degrees(np.arcsin(np.clip(right_mm / max(radius_mm, 1e-9), -1.0, 1.0)))
            return (self.base_row - row) / self.rows_per_mm, float(angle % 360.0)
        turn = np.degrees(np.arctan2((self.base_row - row) / self.px_per_mm, right_mm))
        return None, float((self.azimuth_deg + 90.0 + (turn if self.view == "above" else -turn)) % 360.0)


def image_scale(camera: Camera, size: tuple[int, int]) -> ImageScale:
    """Return the scale of a camera's image of `size` (width, height); exact at the axis of an upright view."""
    forward = camera_frame(camera)[2]
    steep = abs(forward[2]) > STEEP
    # The point of the axis nearest to where the camera aims.
    aimed = np.array([0.0, 0.0, camera.target_mm[2]])
    right = camera_frame(camera)[0]
    here, aside = _seen(camera, size, np.array([aimed, aimed + right]))
    below, above = _seen(camera, size, aimed + np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]))
    rows_per_mm = 0.0 if steep else float(below[1] - above[1])
    up = camera_frame(camera)[1]
    towards_camera = -forward if not steep else up * np.sign(forward[2])
    return ImageScale(
        view="side" if not steep else "above" if forward[2] < 0.0 else "below",
        px_per_mm=float(aside[0] - here[0]),
        rows_per_mm=rows_per_mm,
        axis_column=float(here[0]),
        base_row=float(here[1] + rows_per_mm * aimed[2]),
        azimuth_deg=float(np.degrees(np.arctan2(towards_camera[1], towards_camera[0]))),
    )


def _seen(camera: Camera, size: tuple[int, int], points_mm: np.ndarray) -> np.ndarray:
    """Return column and row (n, 2) where points (n, 3) appear."""
    width, height = size
    right, up, ahead = camera_frame(camera) @ (points_mm - camera.origin_mm).T
    if isinstance(camera, Telecentric):
        half = np.broadcast_to(0.5 * camera.height_mm, ahead.shape)
    else:
        half = ahead * np.tan(0.5 * camera.vertical_field_of_view_rad)
    return np.stack([0.5 * (width + height * right / half), 0.5 * height * (1.0 - up / half)], axis=1)
