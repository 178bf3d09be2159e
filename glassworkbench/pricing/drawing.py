"""Pictures of a price list, by matplotlib: error over seconds, and crops side by side."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from glassworkbench.output import new_figure, save_figure

if TYPE_CHECKING:
    from glassworkbench.images import Image
    from glassworkbench.pricing.price_list import Price

KINDS = {"unbent": ("v", "0.45"), "mesh": ("^", "#d1812c"), "effect": ("s", "#3a86a8"), "exact": ("o", "#23813e")}
"""Marker and colour."""

LEAST_SHOWN = 1e-7
"""An error of 0 has no place on a logarithmic axis."""

COLUMNS = 6
GAIN = 10
"""By which differences between crops are multiplied."""


def save_plot(prices: Sequence[Price], path: Path) -> None:
    """Draw error over seconds, both logarithmic: hollow as predicted, filled as measured, a line between the two."""
    figure = new_figure(8.4, 5.2)
    axis = figure.add_axes((0.1, 0.12, 0.87, 0.83))
    for kind, (marker, colour) in KINDS.items():
        of_kind = [price for price in prices if price.kind == kind]
        predicted = np.array([(p.predicted_seconds, max(p.predicted_error, LEAST_SHOWN)) for p in of_kind])
        if len(predicted) == 0:
            continue
        style = {"color": colour, "marker": marker, "ls": ""}
        axis.plot(*predicted.T, mfc="white", ms=8, **style)
        if kind in ("exact", "mesh"):
            axis.plot(*predicted.T, color=colour, lw=0.8, ls=":", zorder=1)
        measured = [(place, p) for place, p in zip(predicted, of_kind, strict=True) if p.error is not None]
        if measured:
            places = np.array([(p.seconds, max(p.error, LEAST_SHOWN)) for _, p in measured])
            axis.plot(*places.T, ms=6, **style)
            for (place, _), there in zip(measured, places, strict=True):
                axis.plot(*np.transpose([place, there]), color=colour, lw=0.8)
        for price, place in zip(of_kind, predicted, strict=True):
            axis.annotate(price.name, place, (7, 6), textcoords="offset points", fontsize=8, color=colour)
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.margins(0.12)
    # Names are written to the right of their points.
    low, high = axis.get_xlim()
    axis.set_xlim(low, high * (high / low) ** 0.12)
    axis.set_xlabel("seconds")
    axis.set_ylabel("error, root mean square (white is 1)")
    axis.grid(color="0.9", which="major")
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)
    axis.plot([], [], "o", color="0.3", mfc="white", ms=8, label="predicted")
    axis.plot([], [], "o", color="0.3", ms=6, label="measured")
    axis.legend(fontsize=8, frameon=False, ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
    save_figure(figure, path)


def save_crops(crops: Sequence[tuple[str, Image]], path: Path) -> None:
    """Draw crops at equal scale, and under each how it differs from the last, `GAIN` times."""
    if not crops:
        path.unlink(missing_ok=True)
        return
    rows = -(-len(crops) // COLUMNS)
    columns = -(-len(crops) // rows)
    figure = new_figure(2.1 * columns, 4.4 * rows)
    axes = figure.subplots(2 * rows, columns, squeeze=False)
    figure.subplots_adjust(left=0.01, right=0.99, top=1.0 - 0.3 / (4.4 * rows), bottom=0.01, wspace=0.04, hspace=0.12)
    for axis in axes.ravel():
        axis.axis("off")
    finest = crops[-1][1]
    for k, (name, image) in enumerate(crops):
        row, column = divmod(k, columns)
        upper, lower = axes[2 * row, column], axes[2 * row + 1, column]
        upper.imshow(image.display(), interpolation="nearest")
        upper.set_title(name, fontsize=8)
        if image is finest:
            continue
        off = np.abs(image.pixels - finest.pixels)
        lower.imshow(np.clip(GAIN * off, 0.0, 1.0), interpolation="nearest")
        lower.set_title(f"{GAIN} x difference", fontsize=7, color="0.4")
    save_figure(figure, path)
