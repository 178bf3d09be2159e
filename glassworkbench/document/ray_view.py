"""The path of a ray as a line in the 3D view."""

from __future__ import annotations

from typing import Any

import numpy as np

from glassworkbench.tracer.path import RayPath

OUTSIDE = (0.95, 0.55, 0.05)
"""A leg outside all media, on its way from the camera."""

INSIDE = (0.85, 0.10, 0.35)
"""A refracted leg inside glass or filling."""

REFLECTED = (0.10, 0.35, 0.95)
"""A leg that begins with a total reflection."""

LINE_PIXELS, POINT_PIXELS = 2.5, 4.0


def leg_colours(path: RayPath) -> np.ndarray:
    """Return the colour (n - 1, 3) of each leg of a path."""
    before = [crossing.medium_before for crossing in path.crossings]
    last = _medium_of_last_leg(path)
    media = np.array([*before, last])[:, None]
    return np.where(path.is_reflected()[:, None], REFLECTED, np.where(media == 0, OUTSIDE, INSIDE))


def _medium_of_last_leg(path: RayPath) -> int:
    if not path.crossings:
        return 0
    last = path.crossings[-1]
    return last.medium_before if last.reflectance >= 1.0 else last.medium_after


def ray_node(path: RayPath, placement: np.ndarray) -> Any:
    """Return the node of a path in the scene of FreeCAD's 3D view; it is seen through what stands before it.

    Parameters
    ----------
    path : RayPath
    placement : array (4, 4)
        Takes upright coordinates to those of the document.
    """
    from pivy import coin

    points = path.points_mm @ placement[:3, :3].T + placement[:3, 3]
    legs = np.repeat(points, 2, axis=0)[1:-1]
    channels = np.round(255.0 * np.repeat(leg_colours(path), 2, axis=0)).astype(np.int64)
    packed = (channels[:, 0] << 24) | (channels[:, 1] << 16) | (channels[:, 2] << 8) | 255
    ends = coin.SoVertexProperty()
    ends.vertex.setValues(0, len(legs), legs.tolist())
    ends.orderedRGBA.setValues(0, len(packed), packed.tolist())
    ends.materialBinding = coin.SoVertexProperty.PER_VERTEX
    lines = coin.SoLineSet()
    lines.vertexProperty = ends
    lines.numVertices.setValues(0, len(points) - 1, [2] * (len(points) - 1))
    style = coin.SoDrawStyle()
    style.lineWidth, style.pointSize = LINE_PIXELS, POINT_PIXELS
    unlit = coin.SoLightModel()
    unlit.model = coin.SoLightModel.BASE_COLOR
    node = coin.SoAnnotation()
    for child in (unlit, style, lines):
        node.addChild(child)
    if path.crossings:
        inner = coin.SoVertexProperty()
        inner.vertex.setValues(0, len(path.crossings), points[1:-1].tolist())
        inner.orderedRGBA.setValue(0x202020FF)
        interfaces = coin.SoPointSet()
        interfaces.vertexProperty = inner
        node.addChild(interfaces)
    # The view fits itself to the container, not to the camera that the ray comes from.
    apart = coin.SoType.fromName("SoSkipBoundingGroup")
    group = coin.SoGroup() if apart.isBad() else apart.createInstance()
    group.addChild(node)
    return group
