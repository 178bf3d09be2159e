"""Sidewall inspection in bright field: a diffuse panel behind, darkness elsewhere, the camera in front."""

from __future__ import annotations

from glassworkbench.scene import ContainerGeometry, Panel, Pinhole
from glassworkbench.staging.framing import framing_camera


def sidewall(
    geometry: ContainerGeometry,
    size: tuple[int, int],
    *,
    vertical_field_of_view_deg: float,
    frame_margin: float,
    panel_margin: float,
    panel_gap: float,
    panel_radiance: float,
) -> tuple[tuple[Panel, ...], Pinhole]:
    """Return the lights and the camera.

    Parameters
    ----------
    geometry : ContainerGeometry
    size : (int, int)
        Width and height of the image in pixels.
    vertical_field_of_view_deg : float
    frame_margin : float
        Part of the image, at each edge, that the container leaves free.
    panel_margin, panel_gap : float
        How far the panel reaches past the container on each side, and stands behind it, as parts of the larger of the
        container's width and height.
    panel_radiance : float
    """
    low, high = geometry.low_mm, geometry.high_mm
    width, _, height = high - low
    margin, gap = panel_margin * max(width, height), panel_gap * max(width, height)
    left, right = low[0] - margin, high[0] + margin
    bottom, top = low[2] - margin, high[2] + margin
    panel = Panel(
        origin_mm=(left, high[1] + gap, bottom),
        u_mm=(right - left, 0.0, 0.0),
        v_mm=(0.0, 0.0, top - bottom),
        radiance=panel_radiance,
    )
    camera = framing_camera(
        geometry,
        size,
        azimuth_deg=-90.0,
        elevation_deg=0.0,
        vertical_field_of_view_deg=vertical_field_of_view_deg,
        margin=frame_margin,
    )
    return (panel,), camera
