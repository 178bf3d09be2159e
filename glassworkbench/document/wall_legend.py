"""What the colours of a wall mean: a bar with thicknesses in mm at the left of the 3D view."""

from __future__ import annotations

from typing import Any

import numpy as np

from glassworkbench.document.wall_view import NO_WALL, PALETTE

LEFT, BOTTOM, TOP = -0.96, -0.55, 0.45
"""Where the bar stands; the view reaches from -1 to 1 both ways."""

BAR_WIDTH, PANEL_WIDTH, MARGIN = 0.03, 0.2, 0.03
TITLE_HEIGHT = 0.15

NO_WALL_IS, NO_WALL_HEIGHT, LINE_HEIGHT = ("no wall", "mouth,", "lip, stem"), 0.19, 0.05
"""What grey is, in lines, the first beside it, and the room that they take below the bar."""

STEPS = 5
"""About how many thicknesses are written beside the bar."""

FONT, FONT_PIXELS = "Arial", 13
PAPER, INK = (0.97, 0.97, 0.98), (0.12, 0.12, 0.14)


def legend_node(low_mm: float, high_mm: float, place: int = 0) -> Any:
    """Return the node of a legend in the scene of FreeCAD's 3D view, which stays where it is when the view turns.

    Parameters
    ----------
    low_mm, high_mm : float
        What the first and the last colour stand for.
    place : int
        How many legends are to its left.
    """
    from pivy import coin

    left = LEFT + place * (PANEL_WIDTH + MARGIN)
    legend = coin.SoSeparator()
    legend.renderCaching = coin.SoSeparator.OFF
    for node in _on_the_screen():
        legend.addChild(node)
    foot = BOTTOM - NO_WALL_HEIGHT
    low, high = np.array([left - MARGIN / 2, foot - MARGIN]), np.array([left + PANEL_WIDTH, TOP + TITLE_HEIGHT])
    legend.addChild(_strip(low, high, np.tile(PAPER, (2, 1))))
    legend.addChild(_strip(np.array([left, BOTTOM]), np.array([left + BAR_WIDTH, TOP]), PALETTE))
    beside = foot + (len(NO_WALL_IS) - 1) * LINE_HEIGHT
    grey = np.array([left, beside]), np.array([left + BAR_WIDTH, beside + 0.8 * LINE_HEIGHT])
    legend.addChild(_strip(*grey, np.tile(NO_WALL, (2, 1))))
    ink = coin.SoBaseColor()
    ink.rgb = INK
    font = coin.SoFont()
    font.name, font.size = FONT, FONT_PIXELS
    legend.addChild(ink)
    legend.addChild(font)
    legend.addChild(_text("wall, mm", left, TOP + 0.5 * TITLE_HEIGHT))
    for thickness in round_steps(low_mm, high_mm):
        height = BOTTOM + (thickness - low_mm) / (high_mm - low_mm) * (TOP - BOTTOM)
        legend.addChild(_text(f"{thickness:.2f}", left + 1.5 * BAR_WIDTH, height - 0.012))
    for line, words in enumerate(NO_WALL_IS):
        indent = 0.0 if line else 1.5 * BAR_WIDTH
        legend.addChild(_text(words, left + indent, beside - line * LINE_HEIGHT + 0.01))
    # The view fits itself to the container alone.
    apart = coin.SoType.fromName("SoSkipBoundingGroup")
    group = coin.SoGroup() if apart.isBad() else apart.createInstance()
    group.addChild(legend)
    return group


def round_steps(low_mm: float, high_mm: float) -> np.ndarray:
    """Return the lower end of a range and about `STEPS` round thicknesses above it, as they are written."""
    least = (high_mm - low_mm) / STEPS
    power = 10.0 ** np.floor(np.log10(least))
    step = power * next(factor for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= (1.0 - 1e-9) * least)
    steps = step * np.arange(np.ceil(low_mm / step), np.floor(high_mm / step + 1e-9) + 1.0)
    # What would touch the lower end is left out.
    return np.append(low_mm, steps[steps > low_mm + 0.5 * step])


def _on_the_screen() -> list[Any]:
    """Return the nodes that put what follows flat in front of everything, deaf to the mouse."""
    from pivy import coin

    camera = coin.SoOrthographicCamera()
    camera.viewportMapping = coin.SoCamera.LEAVE_ALONE
    camera.position = (0.0, 0.0, 1.0)
    camera.nearDistance, camera.farDistance, camera.height = 0.5, 1.5, 2.0
    deaf = coin.SoPickStyle()
    deaf.style = coin.SoPickStyle.UNPICKABLE
    unlit = coin.SoLightModel()
    unlit.model = coin.SoLightModel.BASE_COLOR
    in_front = coin.SoDepthBuffer()
    in_front.function = coin.SoDepthBufferElement.ALWAYS
    in_front.range = (0.0, 0.0)
    return [camera, deaf, unlit, in_front]


def _strip(low: np.ndarray, high: np.ndarray, colours: np.ndarray) -> Any:
    """Return an upright rectangle from corner to corner (2,) in colours (n, 3) from bottom to top."""
    from pivy import coin

    heights = np.linspace(low[1], high[1], len(colours))
    points = [(x, float(y), 0.0) for y in heights for x in (float(low[0]), float(high[0]))]
    vertices = coin.SoVertexProperty()
    vertices.vertex.setValues(0, len(points), points)
    red, green, blue = np.round(255.0 * np.repeat(colours, 2, axis=0).T).astype(np.int64)
    packed = (red << 24) | (green << 16) | (blue << 8) | 255
    vertices.orderedRGBA.setValues(0, len(packed), packed.tolist())
    vertices.materialBinding = coin.SoVertexProperty.PER_VERTEX
    strip = coin.SoTriangleStripSet()
    strip.vertexProperty = vertices
    strip.numVertices.setValue(len(points))
    return strip


def _text(words: str, x: float, y: float) -> Any:
    from pivy import coin

    place = coin.SoTranslation()
    place.translation = (x, float(y), 0.0)
    text = coin.SoText2()
    text.string = words
    node = coin.SoSeparator()
    node.addChild(place)
    node.addChild(text)
    return node
