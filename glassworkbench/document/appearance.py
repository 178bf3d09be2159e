"""How a glass looks in the 3D view, which knows a colour and a transparency but no path length."""

from __future__ import annotations

from glassworkbench.glass import Glass
from glassworkbench.images import to_display

PATH_MM = 8.0
"""A typical path through both walls of a container."""


def colour(glass: Glass) -> tuple[float, float, float]:
    """Return the sRGB colour (0 to 1) of light that went through two walls."""
    red, green, blue = to_display(glass.rgb_transmittance(PATH_MM)) / 255.0
    return float(red), float(green), float(blue)


def transparency_percent(glass: Glass) -> int:
    """Return a transparency: clear glass lets most of the view behind it through, dark glass less."""
    return round(40.0 + 35.0 * float(glass.rgb_transmittance(PATH_MM).mean()))
