"""Where a camera must stand so that a container of any proportions fits its image."""

from __future__ import annotations

import itertools

import numpy as np

from glassworkbench.scene import ContainerGeometry, Pinhole
from glassworkbench.scene.cameras import camera_frame


def framing_camera(
    geometry: ContainerGeometry,
    size: tuple[int, int],
    azimuth_deg: float,
    elevation_deg: float,
    vertical_field_of_view_deg: float,
    margin: float,
) -> Pinhole:
    """Return a camera that looks at the container and holds all of it in the image.

    Parameters
    ----------
    geometry : ContainerGeometry
    size : (int, int)
        Width and height of the image in pixels.
    azimuth_deg, elevation_deg : float
        Where the camera stands, seen from the container; azimuth counts from +x towards +y.
    vertical_field_of_view_deg : float
    margin : float
        Part of the image, at each edge, that the container leaves free.
    """
    azimuth, elevation = np.radians([azimuth_deg, elevation_deg])
    towards_camera = np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )
    # A camera at -90 degrees stands at x = 0 exactly, or the scene would miss its mirror symmetry by 1e-14.
    towards_camera = np.round(towards_camera, 15)
    angle = np.radians(vertical_field_of_view_deg)
    corners = np.array(list(itertools.product(*zip(geometry.low_mm, geometry.high_mm, strict=True))))
    target = corners.mean(axis=0)
    frame = camera_frame(Pinhole(target + towards_camera, target, angle))
    side, above, behind = frame @ (corners - target).T
    # A corner is in the picture where |side| <= slope * aspect * (distance + behind), and |above| likewise.
    slope = (1.0 - 2.0 * margin) * np.tan(0.5 * angle)
    aspect = size[0] / size[1]
    distance = np.max(np.maximum(np.abs(side) / (slope * aspect), np.abs(above) / slope) - behind)
    return Pinhole(target + distance * towards_camera, target, angle)
