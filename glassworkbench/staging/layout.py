"""A drawing of a station: camera, light and container from the side and from above, and what the camera sees."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from glassworkbench.output import check_drawing, new_figure, save_figure
from glassworkbench.scene import Mesh, Panel, Patches, Revolved, Scene
from glassworkbench.staging.directions import along_meridian

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LAYOUT = "the layout of a station"

GLASS, LIGHT, CAMERA, FIELD = "#4c9f8a", "#e0a300", "#2b4a8b", "#9fb3dd"
PLANES = (("from the side", (1, 2), "y, mm"), ("from above", (0, 1), "x, mm"))
"""Title, the two coordinates, and the name of the first."""
SQUARE = ((0, 0), (1, 0), (1, 1), (0, 1))


def save_layout(scene: Scene, picture: np.ndarray, title: str, path: str | Path) -> None:
    """Draw a station into a PNG, SVG or PDF file.

    Parameters
    ----------
    scene : Scene
        Of a station, with the bodies outer and cavity.
    picture : array (h, w, 3)
        What the camera sees, uint8.
    title : str
    path : str or Path

    Raises
    ------
    InputError
        As `check_drawing`.
    """
    path = check_drawing(path, LAYOUT)
    figure = new_figure(13.0, 5.2)
    figure.set_layout_engine("constrained")
    axes = figure.subplots(1, 3, width_ratios=(1.3, 1.3, 0.8))
    for axis, (name, plane, label) in zip(axes, PLANES, strict=False):
        _draw_plane(axis, scene, plane)
        axis.set_title(name, fontsize=10, color="0.35")
        axis.set_xlabel(label)
        axis.set_ylabel(f"{'xyz'[plane[1]]}, mm")
    # The one column of a line camera is drawn wide, to be seen.
    axes[2].imshow(picture, aspect="auto" if picture.shape[1] == 1 else "equal")
    axes[2].set_axis_off()
    axes[2].set_title(f"what the camera sees, {scene.size[0]} x {scene.size[1]} px", fontsize=10, color="0.35")
    figure.suptitle(title, x=0.01, ha="left", fontsize=12, wrap=True)
    save_figure(figure, path)


def _draw_plane(axis: Axes, scene: Scene, plane: tuple[int, int]) -> None:
    for body in scene.bodies:
        if body.name in ("outer", "cavity"):
            _draw_surface(axis, body.surface, plane, fill=body.name == "outer")
    brightest = max(scene.brightest(), 1e-300)
    (hidden,) = {0, 1, 2} - set(plane)
    for light in scene.lights:
        if isinstance(light, Panel):
            corners = np.array([light.origin_mm + i * light.u_mm + j * light.v_mm for i, j in SQUARE])
            # Beside the plane of the drawing it is faint: so a frame shows its hole.
            crosses = corners[:, hidden].min() <= 0.0 <= corners[:, hidden].max()
            opacity = (0.25 + 0.75 * float(light.radiance.max()) / brightest) * (1.0 if crosses else 0.2)
            axis.fill(*corners[:, plane].T, color=LIGHT, alpha=opacity, linewidth=2.5, zorder=0.5)
        else:
            axis.text(0.02, 0.97, "light from all around", transform=axis.transAxes, va="top", color=LIGHT)
    camera, aspect = scene.camera, scene.size[0] / scene.size[1]
    x, y = np.array([(-aspect, -1.0), (aspect, -1.0), (aspect, 1.0), (-aspect, 1.0)]).T
    origins, directions = camera.rays(x, y)
    forward = camera.target_mm - camera.origin_mm
    for origin, direction in zip(origins, directions, strict=True):
        ends = np.stack([origin, origin + (forward @ forward) / (direction @ forward) * direction])[:, plane]
        axis.plot(*ends.T, color=FIELD, linewidth=0.8, zorder=2)
    axis.plot(*camera.origin_mm[list(plane)], marker="s", color=CAMERA, markersize=8)
    axis.annotate("camera", camera.origin_mm[list(plane)], (6, 8), textcoords="offset points", color=CAMERA)
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.08)
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)


def _draw_surface(axis: Axes, surface: object, plane: tuple[int, int], fill: bool) -> None:
    """Draw the outline of a turned body, or the triangles of any other."""
    style = {"facecolor": GLASS if fill else "white", "edgecolor": GLASS, "linewidth": 0.8}
    if isinstance(surface, Revolved):
        r, z = along_meridian(surface.meridian)
        axis.fill(*_turned(surface, r, z)[:, plane].T, **style)
        if plane == (0, 1):
            widest = np.argmax(r)
            turn = np.linspace(0.0, 2.0 * np.pi, 181)
            ring = np.stack([r[widest] * np.cos(turn), r[widest] * np.sin(turn), np.full_like(turn, z[widest])], axis=1)
            axis.fill(*(ring + surface.base_mm)[:, plane].T, **style)
    elif isinstance(surface, Mesh | Patches):
        mesh = surface.mesh if isinstance(surface, Patches) else surface
        axis.triplot(*mesh.vertices_mm[:, plane].T, mesh.triangles, color=GLASS, linewidth=0.15)


def _turned(surface: Revolved, r: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return the outline (n, 3) of a turned body in the plane of its axis and y."""
    across = np.array([0.0, 1.0, 0.0])
    across = across - (across @ surface.axis) * surface.axis
    across = across / np.linalg.norm(across)
    half = surface.base_mm + np.multiply.outer(z, surface.axis)
    return np.concatenate([half + np.multiply.outer(r, across), (half - np.multiply.outer(r, across))[::-1]])
