"""What an engineer knows of a camera, and what follows from it by the thin lens."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene.validate import finite_array, positive

SQUARE = 0.01
"""How much the two sides of a pixel may differ, as a share."""

AGREE = 0.01
"""How much a magnification may differ from what focal length and working distance give, as a share."""


@dataclass(frozen=True)
class Optics:
    """A lens in front of a sensor.

    Parameters
    ----------
    sensor_mm : (float, float)
        Width and height.
    pixels : (int, int)
    magnification : float
        Size of the image on the sensor over that of the object.
    working_distance_mm : float
        From the lens to the point aimed at, which is in focus.
    f_number : float, optional
        Focal length over aperture; of a telecentric lens the working one on the side of the sensor.
    focal_length_mm : float, optional
        None for a telecentric lens, whose rays are parallel in front of it.
    """

    sensor_mm: tuple[float, float]
    pixels: tuple[int, int]
    magnification: float
    working_distance_mm: float
    f_number: float | None = None
    focal_length_mm: float | None = None

    def __post_init__(self) -> None:
        sensor = finite_array(self.sensor_mm, (2,), "sensor_mm")
        pixels = finite_array(self.pixels, (2,), "pixels")
        for side in sensor:
            positive(side, "sensor_mm")
        if np.any(pixels < 1) or np.any(pixels != np.round(pixels)):
            raise InputError(f"pixels: expected whole numbers above 0, got {self.pixels!r}")
        pitch = sensor / pixels
        if abs(pitch[0] / pitch[1] - 1.0) > SQUARE:
            raise InputError(
                f"sensor_mm, pixels: a pixel would be {1e3 * pitch[0]:.3g} x {1e3 * pitch[1]:.3g} um; only square "
                "ones are simulated, correct the sensor's size"
            )
        for name in ("magnification", "working_distance_mm"):
            positive(getattr(self, name), name)
        if self.f_number is not None:
            positive(self.f_number, "f_number")
        object.__setattr__(self, "sensor_mm", tuple(map(float, sensor)))
        object.__setattr__(self, "pixels", tuple(map(int, pixels)))

    @property
    def field_height_mm(self) -> float:
        """Height of what is seen, where the lens focuses."""
        return self.sensor_mm[1] / self.magnification

    @property
    def pixel_mm(self) -> float:
        """Side of a pixel, where the lens focuses."""
        return self.field_height_mm / self.pixels[1]

    @property
    def vertical_field_of_view_rad(self) -> float:
        """Angle between the image's upper and lower edge, from the lens."""
        return 2.0 * float(np.arctan(0.5 * self.field_height_mm / self.working_distance_mm))

    def blur_px(self, nearer_mm: float) -> float:
        """Return the diameter, in pixels, of a point's image that lies `nearer_mm` before the focus; 0 at no aperture.

        By similar triangles: the cone of rays from the focus to the aperture, cut at the point, scaled to the focus.
        """
        if self.f_number is None:
            return 0.0
        if self.focal_length_mm is None:
            blur_mm = abs(nearer_mm) * self.magnification / self.f_number
        else:
            aperture = self.focal_length_mm / self.f_number
            blur_mm = aperture * abs(nearer_mm) / max(self.working_distance_mm - nearer_mm, 1e-9)
        return blur_mm / self.pixel_mm


def lens(
    sensor_mm: tuple[float, float],
    pixels: tuple[int, int],
    focal_length_mm: float | None = None,
    magnification: float | None = None,
    working_distance_mm: float | None = None,
    f_number: float | None = None,
) -> Optics:
    """Return the optics of an entocentric lens; two of focal length, magnification and working distance tell the third.

    The thin lens: 1/f = 1/a + 1/b with a the working distance and b = m a.

    Raises
    ------
    InputError
        If fewer are given, they contradict each other, or the focus would lie inside the lens.
    """
    given = {
        "focal_length_mm": focal_length_mm,
        "magnification": magnification,
        "working_distance_mm": working_distance_mm,
    }
    known = {name: positive(value, name) for name, value in given.items() if value is not None}
    if len(known) < 2:
        raise InputError(f"camera: give two of {', '.join(given)}; it has {' and '.join(known) or 'none'}")
    focal, distance = known.get("focal_length_mm"), known.get("working_distance_mm")
    if focal is None:
        focal = distance * known["magnification"] / (1.0 + known["magnification"])
    elif distance is None:
        distance = focal * (1.0 + 1.0 / known["magnification"])
    if distance <= focal:
        raise InputError(
            f"working_distance_mm: {distance:g} mm lies inside the focal length of {focal:g} mm, where nothing comes "
            "into focus; move the camera away or take a shorter lens"
        )
    enlarged = focal / (distance - focal)
    if abs(known.get("magnification", enlarged) / enlarged - 1.0) > AGREE:
        raise InputError(
            f"magnification: {known['magnification']:g} contradicts focal length and working distance, which give "
            f"{enlarged:.4g}; leave one of the three out"
        )
    return Optics(sensor_mm, pixels, enlarged, distance, f_number, focal)
