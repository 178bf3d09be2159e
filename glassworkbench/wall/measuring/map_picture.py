"""A picture of a wall map: the container in the colours of its wall, and thickness over height."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from glassworkbench.output import check_drawing, written_aside
from glassworkbench.wall.measuring.wall_map import WallMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAP = "a map of the wall"

VIEWS = (("front", 0.0, 8.0), ("side", 90.0, 8.0), ("from below", 0.0, -50.0))
"""Name, azimuth and elevation (deg) from which the container is seen."""

TURNED_AWAY = -0.3
"""Triangles that are turned away from the viewer by less than this (cosine) are drawn."""

PALETTE = "viridis"
NO_WALL, NO_WALL_IS = (0.86, 0.86, 0.88), "no wall: the mouth, a lip's rounding, a stem and its foot"

EDGES_ARE = "at sharp outer edges and embossing the way in is longer, though the wall inside is as asked"


def save_picture(wall_map: WallMap, title: str, path: str | Path) -> None:
    """Draw a wall map into a PNG, SVG or PDF file; raises as `check_drawing`."""
    path = check_drawing(path, MAP)
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 7.2), facecolor="white")
    FigureCanvasAgg(figure)
    left = figure.add_gridspec(1, 4, width_ratios=[1, 1, 1, 0.06], left=0.02, right=0.66, top=0.86, bottom=0.09)
    right = figure.add_gridspec(1, 1, left=0.735, right=0.935, top=0.86, bottom=0.09)
    colours = ScalarMappable(Normalize(*wall_map.span_mm()), PALETTE)
    half = 0.0
    axes = [figure.add_subplot(left[0, column]) for column in range(len(VIEWS))]
    for axis, (name, azimuth, elevation) in zip(axes, VIEWS, strict=True):
        half = max(half, _draw_view(axis, wall_map, colours, azimuth, elevation))
        axis.set_title(name, fontsize=10, color="0.35")
    for axis in axes:
        axis.set_xlim(-half, half)
    bar = figure.colorbar(colours, cax=figure.add_subplot(left[0, 3]), extend="both")
    bar.set_label("wall, mm")
    bar.outline.set_visible(False)
    if np.any(np.isnan(wall_map.thickness_mm)):
        figure.text(0.022, 0.025, "\N{BLACK SQUARE}", color=NO_WALL, fontsize=14, va="center")
        figure.text(0.037, 0.025, NO_WALL_IS, color="0.35", fontsize=9, va="center")
    _draw_profile(figure.add_subplot(right[0, 0]), wall_map)
    figure.text(0.022, 0.055, EDGES_ARE, color="0.35", fontsize=9, va="center")
    figure.suptitle(title, x=0.02, ha="left", fontsize=13)
    with written_aside(path) as aside:
        figure.savefig(aside, dpi=130, format=path.suffix[1:].lower())


def _draw_view(axis: Axes, wall_map: WallMap, colours: object, azimuth_deg: float, elevation_deg: float) -> float:
    """Draw the triangles that face the viewer or nearly so, far ones first; return half the width that they take."""
    from matplotlib.collections import TriMesh
    from matplotlib.tri import Triangulation

    turn, rise = np.radians(azimuth_deg), np.radians(elevation_deg)
    toward = np.array([np.cos(turn - np.pi / 2) * np.cos(rise), np.sin(turn - np.pi / 2) * np.cos(rise), np.sin(rise)])
    right = np.array([np.cos(turn), np.sin(turn), 0.0])
    up = np.cross(toward, right)
    normals = wall_map.normals.mean(axis=1)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    # What is turned away a little fills the notches that the silhouette's triangles would leave; it is drawn first.
    seen = np.flatnonzero(normals @ toward > TURNED_AWAY)
    seen = seen[np.argsort(wall_map.corners_mm[seen].mean(axis=1) @ toward)]
    corners = wall_map.corners_mm[seen]
    flat = np.stack([corners @ right, corners @ up], axis=2)
    thickness = wall_map.thickness_mm[seen].mean(axis=1)
    colour = colours.to_rgba(np.nan_to_num(thickness))[:, :3]
    colour[np.isnan(thickness)] = NO_WALL
    # Light from the viewer's upper left; enough to show the shape, too little to be taken for another thickness.
    light = toward - 0.5 * right + 0.6 * up
    shade = 0.78 + 0.22 * np.clip(normals[seen] @ (light / np.linalg.norm(light)), 0.0, 1.0)
    colour = colour * shade[:, None]
    # Drawn as polygons, hundreds of thousands of them would take longer than all the rest.
    places = flat.reshape(-1, 2)
    mesh = TriMesh(Triangulation(*places.T, np.arange(len(places)).reshape(-1, 3)), rasterized=True)
    mesh.set_facecolors(np.repeat(colour, 3, axis=0))
    axis.add_collection(mesh, autolim=False)
    axis.update_datalim([places.min(axis=0), places.max(axis=0)])
    axis.set_aspect("equal", adjustable="box", anchor="C")
    axis.autoscale_view()
    axis.margins(0.02)
    axis.axis("off")
    return float(1.03 * np.abs(flat[:, :, 0]).max())


def _draw_profile(axis: Axes, wall_map: WallMap) -> None:
    profile = wall_map.over_height
    heights, (thinnest, thickest) = profile.heights_mm, profile.got_mm.T
    # The edge keeps the band visible where it is thinner than a line.
    axis.fill_betweenx(heights, thinnest, thickest, fc="#3b8ea559", ec="#1f6377", lw=1.0, label="got, all around")
    asked = {"color": "#d1495b", "ls": (0, (4, 2))}
    axis.plot(profile.asked_mm[:, 0], heights, lw=1.2, label="asked", **asked)
    if np.any(np.ptp(profile.asked_mm, axis=1) > 1e-3):
        axis.plot(profile.asked_mm[:, 1], heights, lw=0.8, **asked)
    both = np.concatenate([profile.got_mm.ravel(), profile.asked_mm.ravel(), wall_map.span_mm()])
    low, high = np.nanmin(both), np.nanmax(both)
    margin = 0.15 * (high - low)
    axis.set_xlim(max(0.0, low - margin), high + margin)
    axis.set_ylim(0.0, profile.edges_mm[-1])
    axis.set_xlabel("wall, mm")
    axis.set_ylabel("height of the inner surface, mm")
    axis.yaxis.set_label_position("right")
    axis.yaxis.tick_right()
    axis.grid(color="0.9")
    axis.set_axisbelow(True)
    axis.spines[["top", "left"]].set_visible(False)
    axis.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=2, frameon=False, fontsize=9, borderaxespad=0.2)
