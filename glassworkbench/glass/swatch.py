"""The colour of a material as it is shown: of one path, and along a wedge."""

from __future__ import annotations

import numpy as np

from glassworkbench.colour import linear_srgb
from glassworkbench.glass.material import Filling, Glass
from glassworkbench.images import to_display


def shown_colour(material: Glass | Filling, path_mm: float) -> str:
    """Return the colour of daylight after a path, as web pages write it, clipped to what a screen shows."""
    return "#" + bytes(to_display(linear_srgb(material.colour(path_mm)))).hex()


def wedge(material: Glass | Filling, longest_mm: float, shades: int) -> np.ndarray:
    """Return the colours of daylight behind a wedge, from nothing to its thick end.

    Returns
    -------
    uint8 array (shades, 3)
        sRGB, clipped to what a screen shows.
    """
    return to_display(linear_srgb(material.colour(longest_mm * (np.arange(shades) + 0.5) / shades)))
