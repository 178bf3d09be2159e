"""The designer's sky: a soft gradient from ground to zenith, with a few soft boxes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np


def sky_light(
    ground: Sequence[float],
    sky: Sequence[float],
    soft_boxes: Sequence[Mapping],
    rows: int = 512,
) -> np.ndarray:
    """Return the sky's light as a latitude-longitude map.

    Parameters
    ----------
    ground, sky : (3,)
        Radiance R, G, B straight below and above; a smooth gradient lies between.
    soft_boxes : sequence of mappings
        ``azimuth_deg``, ``elevation_deg`` of the middle, ``half_width_deg``, ``half_height_deg``,
        ``softness_deg`` (over what angle it fades at its edges), ``radiance`` (3,).
    rows : int
        Height of the map; it is twice as wide.

    Returns
    -------
    array (rows, 2 * rows, 3)
        Laid out as `Environment` wants it.
    """
    elevation = 90.0 - 180.0 * (np.arange(rows) + 0.5) / rows
    azimuth = -180.0 + 360.0 * (np.arange(2 * rows) + 0.5) / (2 * rows)
    height = 0.5 + 0.5 * np.sin(np.radians(elevation))
    blend = (height * height * (3.0 - 2.0 * height))[:, None, None]
    light = (1.0 - blend) * np.asarray(ground) + blend * np.asarray(sky) + np.zeros((1, 2 * rows, 1))
    for box in soft_boxes:
        turn = (azimuth - box["azimuth_deg"] + 180.0) % 360.0 - 180.0
        across = _fade(box["half_width_deg"] - np.abs(turn), box["softness_deg"])
        along = _fade(box["half_height_deg"] - np.abs(elevation - box["elevation_deg"]), box["softness_deg"])
        light += np.multiply.outer(along, across)[:, :, None] * np.asarray(box["radiance"])
    return light


def _fade(inside_deg: np.ndarray, softness_deg: float) -> np.ndarray:
    return 1.0 / (1.0 + np.exp(-inside_deg / softness_deg))
