"""Cameras: where the ray of a point of the image starts, and where it goes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene.validate import finite_array, positive


@dataclass(frozen=True, eq=False)
class Pinhole:
    """An ideal entocentric camera.

    Parameters
    ----------
    origin_mm, target_mm, up : array (3,)
        The eye, the point at the image's centre, and the direction that points up in the image.
    vertical_field_of_view_rad : float
        Angle between the top and the bottom edge of the image, in (0, pi).
    """

    origin_mm: np.ndarray
    target_mm: np.ndarray
    vertical_field_of_view_rad: float
    up: np.ndarray = field(default=(0.0, 0.0, 1.0))

    def __post_init__(self) -> None:
        _set_pose(self)
        angle = positive(self.vertical_field_of_view_rad, "vertical_field_of_view")
        if angle >= np.pi:
            raise InputError("vertical_field_of_view: must be below 180 degrees")

    def rays(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return origins and unit directions (n, 3) for image points (n,): x right, y up, in half image heights."""
        frame = camera_frame(self)
        half = np.tan(0.5 * self.vertical_field_of_view_rad)
        directions = frame[2] + half * (np.multiply.outer(x, frame[0]) + np.multiply.outer(y, frame[1]))
        directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
        return np.broadcast_to(self.origin_mm, directions.shape).copy(), directions


@dataclass(frozen=True, eq=False)
class Telecentric:
    """An object-space telecentric camera: all rays are parallel.

    Parameters
    ----------
    origin_mm, target_mm, up : array (3,)
    height_mm : float
        Height of the field of view.
    """

    origin_mm: np.ndarray
    target_mm: np.ndarray
    height_mm: float
    up: np.ndarray = field(default=(0.0, 0.0, 1.0))

    def __post_init__(self) -> None:
        _set_pose(self)
        positive(self.height_mm, "height_mm")

    def rays(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return origins and unit directions (n, 3) for image points (n,): x right, y up, in half image heights."""
        frame = camera_frame(self)
        half = 0.5 * self.height_mm
        origins = self.origin_mm + half * (np.multiply.outer(x, frame[0]) + np.multiply.outer(y, frame[1]))
        return origins, np.broadcast_to(frame[2], origins.shape).copy()


Camera = Pinhole | Telecentric


def camera_frame(camera: Camera) -> np.ndarray:
    """Return the unit vectors right, up and forward as the rows of a (3, 3) array."""
    forward = camera.target_mm - camera.origin_mm
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, camera.up)
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(right, forward), forward])


def _set_pose(camera: Camera) -> None:
    for name in ("origin_mm", "target_mm", "up"):
        object.__setattr__(camera, name, finite_array(getattr(camera, name), (3,), f"camera {name}"))
    forward = camera.target_mm - camera.origin_mm
    if not np.any(forward):
        raise InputError("camera target_mm: must differ from origin_mm")
    if np.linalg.norm(np.cross(forward, camera.up)) <= 1e-12 * np.linalg.norm(forward) * np.linalg.norm(camera.up):
        raise InputError("camera up: must not be parallel to the view direction")
