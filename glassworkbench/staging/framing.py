"""Where a camera must stand, or how much it must see, so that a container of any proportions fits its image."""

from __future__ import annotations

import numpy as np

from glassworkbench.scene import Pinhole, Telecentric
from glassworkbench.scene.cameras import camera_frame


def pinhole_at_angle(
    corners_mm: np.ndarray,
    size: tuple[int, int],
    there: np.ndarray,
    up: np.ndarray,
    field_of_view_rad: float,
    margin: float,
) -> Pinhole:
    """Return a camera so far away that all corners are in its image.

    Parameters
    ----------
    corners_mm : array (n, 3)
        What has to be in the image; the camera aims at their middle.
    size : (int, int)
        Width and height of the image in pixels.
    there, up : array (3,)
        Unit vectors from what is seen towards the camera, and up in the image.
    field_of_view_rad : float
        Angle between the image's upper and lower edge.
    margin : float
        Part of the image, at each edge, that stays free.
    """
    target = corners_mm.mean(axis=0)
    slope = np.tan(0.5 * field_of_view_rad)
    # A corner is in the picture where its reach is at most slope * (distance + behind).
    reach, behind = _reach(corners_mm, size, target, there, up)
    distance = np.max(reach / ((1.0 - 2.0 * margin) * slope) - behind)
    return Pinhole(target + distance * there, target, field_of_view_rad, up)


def pinhole_at_distance(
    corners_mm: np.ndarray,
    size: tuple[int, int],
    there: np.ndarray,
    up: np.ndarray,
    distance_mm: float,
    margin: float,
) -> Pinhole:
    """Return a camera at a distance from the corners' middle, whose field of view is so wide that it sees them all."""
    target = corners_mm.mean(axis=0)
    reach, behind = _reach(corners_mm, size, target, there, up)
    slope = np.max(reach / (distance_mm + behind)) / (1.0 - 2.0 * margin)
    return Pinhole(target + distance_mm * there, target, 2.0 * float(np.arctan(slope)), up)


def telecentric(
    corners_mm: np.ndarray,
    size: tuple[int, int],
    there: np.ndarray,
    up: np.ndarray,
    distance_mm: float,
    margin: float,
) -> Telecentric:
    """Return a telecentric camera with a field so high that all corners are in its image."""
    target = corners_mm.mean(axis=0)
    reach, _ = _reach(corners_mm, size, target, there, up)
    height = 2.0 * float(np.max(reach)) / (1.0 - 2.0 * margin)
    return Telecentric(target + distance_mm * there, target, height, up)


def _reach(
    corners_mm: np.ndarray, size: tuple[int, int], target: np.ndarray, there: np.ndarray, up: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far from the image's middle each corner is, in half heights of an image that is 2 mm high; and how
    far (mm) behind the middle.
    """
    frame = camera_frame(Telecentric(target + there, target, 1.0, up))
    side, above, behind = frame @ (corners_mm - target).T
    return np.maximum(np.abs(side) * size[1] / size[0], np.abs(above)), behind
