"""How large the bodies of a scene are together."""

from __future__ import annotations

import numpy as np

from glassworkbench.scene import Ellipsoids, Mesh, Patches, Revolved, Scene


def longest_chord_mm(scene: Scene) -> float:
    """Return the diagonal of the box around all bodies; 0 where there are none."""
    if not scene.bodies:
        return 0.0
    low, high = box_mm(scene)
    return float(np.linalg.norm(high - low))


def box_mm(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower and the upper corner (3,) of a box around all bodies, of which there is one at least."""
    corners = []
    for body in scene.bodies:
        surface = body.surface
        if isinstance(surface, Mesh | Patches):
            mesh = surface.mesh if isinstance(surface, Patches) else surface
            corners += [mesh.vertices_mm.min(axis=0), mesh.vertices_mm.max(axis=0)]
        elif isinstance(surface, Revolved):
            r, z = surface.meridian[:, :, 0].max(), surface.meridian[:, :, 1]
            ends = [surface.base_mm + height * surface.axis for height in (z.min(), z.max())]
            reach = r * np.sqrt(np.maximum(0.0, 1.0 - surface.axis**2))
            corners += [end + sign * reach for end in ends for sign in (-1.0, 1.0)]
        elif isinstance(surface, Ellipsoids):
            reach = surface.reaches_mm()
            corners += [(surface.centres_mm - reach).min(axis=0), (surface.centres_mm + reach).max(axis=0)]
        else:
            reach = np.full(3, surface.semi_axes_mm.max())
            corners += [surface.centre_mm - reach, surface.centre_mm + reach]
    return np.min(corners, axis=0), np.max(corners, axis=0)
