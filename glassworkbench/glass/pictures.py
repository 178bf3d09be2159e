"""Pictures of the catalogue, by matplotlib: swatches against the wall thickness, transmission over the wavelength."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.glass.material import Filling, Glass
from glassworkbench.glass.swatch import shown_colour, wedge
from glassworkbench.output import check_drawing, new_figure, save_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SWATCHES, CURVES = "a picture of swatches", "a plot of transmission"

GLASS_WALLS_MM, LIQUID_PATHS_MM = 12.0, 80.0
"""The thickest that swatches show."""

GLASS_PLATE_MM, LIQUID_LAYER_MM = 2.0, 10.0
"""What transmission is plotted for: the wall that pharmacopoeias look at, and the usual cuvette."""

SHORTEST_NM, LONGEST_NM = 290.0, 1000.0
PROTECTED_NM, PROTECTED_PASSES = (290.0, 450.0), 0.10
"""Light-protecting glass passes no more than this in this range (USP <660>, Ph. Eur. 3.2.1)."""

_SHADES = 480
_COLUMNS = 4


def save_swatches(glasses: Mapping[str, Glass], fillings: Mapping[str, Filling], path: str | Path) -> None:
    """Draw the colour of daylight behind each material, from thin to thick.

    Parameters
    ----------
    glasses, fillings : dict
        By name.
    path : str or Path
        PNG, SVG or PDF.

    Raises
    ------
    InputError
        If there is nothing to draw, or the file cannot be written.
    """
    path = check_drawing(path, SWATCHES)
    from matplotlib.patches import Rectangle

    groups = [(known, longest) for known, longest in ((glasses, GLASS_WALLS_MM), (fillings, LIQUID_PATHS_MM)) if known]
    if not groups:
        raise InputError(f"{path}: there is nothing to draw; name a glass or a filling")
    rows = [len(known) for known, _ in groups]
    height = 0.42 * sum(rows) + 0.75 * len(groups)
    figure = new_figure(9.0, height)
    grid = figure.add_gridspec(len(groups), 1, height_ratios=rows, left=0.18, right=0.97)
    grid.update(top=1.0 - 0.12 / height, bottom=0.6 / height, hspace=0.75 * len(groups) / (0.42 * sum(rows)) * 1.1)
    for row, (known, longest) in enumerate(groups):
        axis = figure.add_subplot(grid[row, 0])
        for line, material in enumerate(known.values()):
            extent = (0.0, longest, line + 0.92, line + 0.08)
            axis.imshow(wedge(material, longest, _SHADES)[None], aspect="auto", extent=extent, interpolation="nearest")
            # Without a frame, colourless glass could not be told from the paper.
            axis.add_patch(Rectangle((0.0, line + 0.08), longest, 0.84, fill=False, edgecolor="0.75", lw=0.8))
        axis.set_xlim(-0.002 * longest, 1.002 * longest)
        axis.set_ylim(len(known), 0.0)
        axis.set_yticks(np.arange(len(known)) + 0.5, known)
        axis.set_xlabel("wall, mm" if longest == GLASS_WALLS_MM else "liquid, mm")
        axis.tick_params(length=0)
        axis.spines[:].set_visible(False)
    save_figure(figure, path)


def save_curves(glasses: Mapping[str, Glass], fillings: Mapping[str, Filling], path: str | Path) -> None:
    """Draw what a plate of each glass, with its reflections, and a layer of each liquid passes; as `save_swatches`."""
    path = check_drawing(path, CURVES)
    known = [*glasses.values(), *fillings.values()]
    if not known:
        raise InputError(f"{path}: there is nothing to draw; name a glass or a filling")
    columns = min(_COLUMNS, len(known))
    rows = -(-len(known) // columns)
    figure = new_figure(max(3.2 * columns, 5.0), 2.25 * rows + 0.5)
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    width, height = figure.get_size_inches()
    figure.subplots_adjust(left=0.55 / width, right=1.0 - 0.25 / width, hspace=0.32, wspace=0.1)
    figure.subplots_adjust(top=1.0 - 0.3 / height, bottom=0.5 / height)
    for axis, material in zip(axes, known, strict=False):
        _draw_curve(axis, material)
    for axis in axes[len(known) :]:
        axis.axis("off")
    for axis in axes[max(0, len(known) - columns) : len(known)]:
        axis.set_xlabel("wavelength, nm", fontsize=9)
        axis.tick_params(labelbottom=True)
    for axis in axes[::columns]:
        axis.set_ylabel("passed", fontsize=9)
    save_figure(figure, path)


def _draw_curve(axis: Axes, material: Glass | Filling) -> None:
    low, high = max(material.range_nm[0], SHORTEST_NM), min(material.range_nm[1], LONGEST_NM)
    wavelengths = np.linspace(low, high, 500)
    if isinstance(material, Glass):
        passed, path_mm = material.plate_transmittance(wavelengths, GLASS_PLATE_MM), GLASS_PLATE_MM
        left, right = PROTECTED_NM
        axis.fill_between((left, right), PROTECTED_PASSES, 1.0, color="#d1495b", alpha=0.12, lw=0, zorder=3)
    else:
        passed, path_mm = material.transmittance(wavelengths, LIQUID_LAYER_MM), LIQUID_LAYER_MM
    axis.fill_between(wavelengths, passed, color=shown_colour(material, path_mm), lw=0)
    axis.plot(wavelengths, passed, color="0.15", lw=1.1)
    axis.set_xlim(SHORTEST_NM, LONGEST_NM)
    axis.set_ylim(0.0, 1.0)
    axis.set_title(f"{material.name}, {path_mm:g} mm", fontsize=10, loc="left")
    axis.tick_params(labelsize=8)
    axis.grid(color="0.9")
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)
