"""A comparison as a picture for people: the camera's image with what was found, and the z-map beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glassworkbench.images import to_display
from glassworkbench.judging.compare import Comparison
from glassworkbench.output import check_drawing, new_figure, save_figure

OVERLAY = "an overlay"

COLOURS = {"critical": "#d7191c", "major": "#f57c00", "minor": "#c9a800"}
VERDICTS = {"accept": "#2e7d32", "reject": "#d7191c"}
MOST_Z = 8.0
MOST_LABELS = 40
ROOM_PX = 4
"""Between a finding and its frame."""


def save_overlay(comparison: Comparison, title: str, path: str | Path) -> None:
    """Draw a comparison into a PNG, SVG or PDF file; raises as `check_drawing`."""
    path = check_drawing(path, OVERLAY)
    from matplotlib.patches import Rectangle

    height, width = comparison.z.shape
    figure = new_figure(2.0 * 8.0 * min(1.0, width / height) + 1.6, 8.0 * min(1.0, height / width) + 1.2)
    figure.set_layout_engine("constrained")
    camera, departures = figure.subplots(1, 2)
    found, grey = comparison.registration, comparison.image.grey
    camera.imshow(to_display(grey / max(float(np.percentile(grey, 99.5)), 1e-300)), cmap="gray", vmin=0, vmax=255)
    shown = departures.imshow(comparison.z, cmap="RdBu_r", vmin=-MOST_Z, vmax=MOST_Z)
    bar = figure.colorbar(shown, ax=departures, shrink=0.7)
    bar.set_label("z: departure from the mean, in standard deviations")
    for finding in comparison.findings[:MOST_LABELS]:
        colour = COLOURS[finding.defect_class]
        left, top, right, bottom = finding.box
        reach_x, reach_y = 0.5 * (right - left) + ROOM_PX, 0.5 * (bottom - top) + ROOM_PX
        middle = 0.5 * (left + right), 0.5 * (top + bottom)
        seen = found.to_camera(*middle, size=(width, height))
        for axis, (x, y) in ((camera, seen), (departures, middle)):
            corner = x - 0.5 - reach_x, y - 0.5 - reach_y
            axis.add_patch(Rectangle(corner, 2 * reach_x, 2 * reach_y, fill=False, edgecolor=colour, linewidth=1.6))
        size = f"{finding.size_px:.0f} px" if finding.size_mm is None else f"{finding.size_mm:.2g} mm"
        camera.annotate(
            f"{finding.kind} {size}",
            (seen[0] + reach_x, seen[1] - reach_y),
            xytext=(2, 1),
            textcoords="offset points",
            color=colour,
            fontsize=8,
        )
    zones = ", ".join(f"{zone} {verdict}" for zone, verdict in comparison.zones.items())
    camera.set_title("camera", fontsize=10, color="0.35")
    departures.set_title("against the golden image", fontsize=10, color="0.35")
    figure.suptitle(
        f"{title}: {comparison.verdict}  ({zones})", fontsize=12, color=VERDICTS[comparison.verdict], wrap=True
    )
    for axis in (camera, departures):
        axis.set_axis_off()
    save_figure(figure, path)
