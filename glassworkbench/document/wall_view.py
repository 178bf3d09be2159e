"""The wall of a container as colours in the 3D view."""

from __future__ import annotations

from typing import Any

import numpy as np

from glassworkbench.wall.measuring.wall_map import WallMap

PALETTE = np.array([[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]]) / 255.0
"""From the thinnest to the thickest wall; the same hues as in the map's picture (viridis)."""

NO_WALL = np.array([0.86, 0.86, 0.88])


LIGHT = np.array([-0.45, -0.65, 0.62])
"""Where the light comes from: fixed to the container, so that a colour always means the same thickness."""


def colours(wall_map: WallMap) -> np.ndarray:
    """Return a colour (3 m, 3) for each corner of a map's triangles."""
    low, high = wall_map.span_mm()
    thickness = wall_map.thickness_mm.ravel()
    share = np.clip((np.nan_to_num(thickness) - low) / (high - low), 0.0, 1.0)
    places = np.linspace(0.0, 1.0, len(PALETTE))
    colour = np.column_stack([np.interp(share, places, channel) for channel in PALETTE.T])
    colour[np.isnan(thickness)] = NO_WALL
    return colour


def wall_node(wall_map: WallMap, placement: np.ndarray) -> Any:
    """Return the node of a map in the scene of FreeCAD's 3D view.

    Parameters
    ----------
    wall_map : WallMap
    placement : array (4, 4)
        Takes upright coordinates to those of the document.
    """
    from pivy import coin

    points = wall_map.corners_mm.reshape(-1, 3) @ placement[:3, :3].T + placement[:3, 3]
    shade = 0.8 + 0.2 * np.clip(wall_map.normals.reshape(-1, 3) @ LIGHT, -0.5, 1.0)
    channels = np.round(255.0 * shade[:, None] * colours(wall_map)).astype(np.int64)
    packed = (channels[:, 0] << 24) | (channels[:, 1] << 16) | (channels[:, 2] << 8) | 255
    vertices = coin.SoVertexProperty()
    vertices.vertex.setValues(0, len(points), points.tolist())
    vertices.orderedRGBA.setValues(0, len(packed), packed.tolist())
    vertices.materialBinding = coin.SoVertexProperty.PER_VERTEX
    faces = coin.SoFaceSet()
    faces.vertexProperty = vertices
    faces.numVertices.setValues(0, len(points) // 3, [3] * (len(points) // 3))
    unlit = coin.SoLightModel()
    unlit.model = coin.SoLightModel.BASE_COLOR
    node = coin.SoSeparator()
    node.addChild(unlit)
    node.addChild(faces)
    return node
