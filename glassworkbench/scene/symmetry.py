"""Whether the two halves of an image mirror each other, so that one need not be traced."""

from __future__ import annotations

import numpy as np

from glassworkbench.scene.bodies import Ellipsoid, Revolved
from glassworkbench.scene.cameras import camera_frame
from glassworkbench.scene.lights import Environment, Light
from glassworkbench.scene.scene import Scene

CLOSE = 1e-12
"""How far, as a share of its coordinates, a thing may lie from its mirror image."""


def is_mirror_symmetric(scene: Scene) -> bool:
    """Tell whether a scene is its own mirror image, left for right as the camera sees it.

    Bodies of revolution and ellipsoids are examined, panels and environments; meshes and patches count as not
    symmetric.
    """
    normal = camera_frame(scene.camera)[0]
    point = scene.camera.origin_mm
    if not all(_is_body_symmetric(body.surface, normal, point) for body in scene.bodies):
        return False
    return all(_is_light_symmetric(light, normal, point) for light in scene.lights)


def _is_body_symmetric(surface: object, normal: np.ndarray, point: np.ndarray) -> bool:
    if isinstance(surface, Revolved):
        return _in_plane(surface.base_mm, normal, point) and abs(surface.axis @ normal) <= CLOSE
    if isinstance(surface, Ellipsoid):
        matrix = surface.rotation @ np.diag(surface.semi_axes_mm**2) @ surface.rotation.T
        mirror = np.eye(3) - 2.0 * np.outer(normal, normal)
        same = np.allclose(mirror @ matrix @ mirror, matrix, rtol=0.0, atol=CLOSE * np.abs(matrix).max())
        return _in_plane(surface.centre_mm, normal, point) and same
    return False


def _in_plane(place: np.ndarray, normal: np.ndarray, point: np.ndarray) -> bool:
    return abs((place - point) @ normal) <= CLOSE * max(1.0, np.abs(place - point).max())


def _is_light_symmetric(light: Light, normal: np.ndarray, point: np.ndarray) -> bool:
    if isinstance(light, Environment):
        return _is_environment_symmetric(light.radiance, normal)
    corners = [light.origin_mm + i * light.u_mm + j * light.v_mm for i, j in ((0, 0), (1, 0), (0, 1), (1, 1))]
    mirrored = [corner - 2.0 * ((corner - point) @ normal) * normal for corner in corners]
    reach = CLOSE * max(1.0, np.abs(corners).max())
    return all(min(np.abs(corner - other).max() for other in corners) <= reach for corner in mirrored)


def _is_environment_symmetric(radiance: np.ndarray, normal: np.ndarray) -> bool:
    if radiance.shape[:2] == (1, 1):
        return True
    if abs(normal[2]) > CLOSE:
        return False
    # A mirror with its normal at azimuth a takes azimuth b to 2 a + pi - b; pixel j's centre lies at j + 1/2.
    width = radiance.shape[1]
    turned = 2.0 * (np.arctan2(normal[1], normal[0]) / (2.0 * np.pi)) * width - 0.5 * width - 1.0
    if abs(turned - round(turned)) > 1e-9:
        return False
    return bool(np.array_equal(radiance[:, (round(turned) - np.arange(width)) % width], radiance))
