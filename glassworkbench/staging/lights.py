"""The lights of a station file: panels plain or with a pattern, frames, rings, skies and environment maps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene import Camera, ContainerGeometry, Environment, Light, Panel
from glassworkbench.scene.validate import finite, finite_array
from glassworkbench.settings import check_keys, unknown_name
from glassworkbench.staging.directions import corners, towards
from glassworkbench.staging.lengths import Lengths, length_keys
from glassworkbench.staging.sky import sky_light

PLACE = ("azimuth_deg", "elevation_deg", *length_keys(["gap", "distance"]))
EXTENT = length_keys(["width", "height", "margin"])
GRADIENT_STEPS = 16
CLEARANCE = 0.02
"""How far a frame stands off what the camera sees, as a share of that."""
GRAZING = 0.05
"""Rays that meet a frame's plane at a flatter angle (sine) do not look through it."""
MOST_PANELS = 128
"""More would make each ray look for its light for longer than for the glass."""


def place_light(
    table: Mapping, geometry: ContainerGeometry, camera: Camera, size: tuple[int, int], folder: Path
) -> tuple[Light, ...]:
    """Return the lights that one of a station's tables ``[[light]]`` describes.

    Parameters
    ----------
    table : mapping
        `docs/stations.md` lists the keys.
    geometry : ContainerGeometry
    camera : Camera
    size : (int, int)
        Width and height of its image, in pixels.
    folder : Path
        Where the files that it names are.

    Raises
    ------
    InputError
        If a key is not known, absent or impossible.
    """
    kinds: dict[str, Callable[[], tuple[Light, ...]]] = {
        "panel": lambda: _panel(table, geometry),
        "frame": lambda: _frame(table, geometry, camera, size),
        "ring": lambda: _ring(table, geometry),
        "sky": lambda: _sky(table),
        "environment": lambda: _environment(table, folder),
    }
    kind = table.get("kind")
    if kind not in kinds:
        raise unknown_name("light: kind", kind, kinds)
    return kinds[kind]()


class _Rectangle:
    """A rectangle that faces the container's middle.

    Its coordinates across and up are in mm from its middle; across runs to the right for one who looks at it from the
    container.
    """

    def __init__(self, table: Mapping, geometry: ContainerGeometry, where: str) -> None:
        there, self.up = towards(
            finite(table.get("azimuth_deg", 90.0), f"{where}: azimuth_deg"),
            finite(table.get("elevation_deg", 0.0), f"{where}: elevation_deg"),
        )
        self.across = np.cross(there, self.up)
        box = corners(geometry, "all", where)
        middle = box.mean(axis=0)
        self.half_box = np.abs((box - middle) @ np.stack([self.across, self.up], axis=1)).max(axis=0)
        lengths = Lengths.of(geometry)
        gap, distance = (lengths.mm(table, name, where) for name in ("gap", "distance"))
        if (gap is None) == (distance is None):
            raise InputError(f"{where}: give either a gap (from the container's box) or a distance (from its middle)")
        depth = float(np.max((box - middle) @ there))
        self.middle = middle + (depth + gap if distance is None else distance) * there
        if min(length for length in (gap, distance) if length is not None) <= 0.0:
            raise InputError(f"{where}: the light must stand away from the container; give a length above 0")

    def panel(self, left: float, right: float, bottom: float, top: float, radiance: object) -> Panel:
        """Return a panel between coordinates across and up."""
        corner = self.middle + left * self.across + bottom * self.up
        return Panel(corner, (right - left) * self.across, (top - bottom) * self.up, radiance)

    def seen_through(self, camera: Camera, size: tuple[int, int]) -> np.ndarray | None:
        """Return where the corners of a camera's image lie in the rectangle's plane (4, 2), None if some do not."""
        aspect = size[0] / size[1]
        x, y = np.array([(-aspect, -1.0), (aspect, -1.0), (aspect, 1.0), (-aspect, 1.0)]).T
        origins, directions = camera.rays(x, y)
        normal = np.cross(self.across, self.up)
        slope = directions @ normal
        if np.any(np.abs(slope) < GRAZING):
            return None
        distance = (self.middle - origins) @ normal / slope
        if np.any(distance <= 0.0):
            return None
        return (origins + distance[:, None] * directions - self.middle) @ np.stack([self.across, self.up], axis=1)

    def half_extent(self, table: Mapping, lengths: Lengths, where: str) -> np.ndarray:
        """Return half of width and height, as given, or as the container's box with a margin."""
        width, height, margin = (lengths.mm(table, name, where) for name in ("width", "height", "margin"))
        if margin is not None and width is None and height is None:
            half = self.half_box + margin
        elif margin is None and width is not None and height is not None:
            half = 0.5 * np.array([width, height])
        else:
            raise InputError(f"{where}: give either margin, or width and height")
        if np.any(half <= 0.0):
            raise InputError(f"{where}: width and height must be above 0")
        return half


def _panel(table: Mapping, geometry: ContainerGeometry) -> tuple[Panel, ...]:
    check_keys(table, ("kind",), (*PLACE, *EXTENT, "radiance", "pattern"), "light panel")
    lengths = Lengths.of(geometry)
    rectangle = _Rectangle(table, geometry, "light panel")
    half = rectangle.half_extent(table, lengths, "light panel")
    radiance = _colour(table, "light panel")
    if "pattern" not in table:
        return (rectangle.panel(-half[0], half[0], -half[1], half[1], radiance),)
    pattern = table["pattern"]
    bands = _bands(pattern, lengths, half)
    upright = pattern.get("direction", "horizontal") == "horizontal"
    if upright:
        return tuple(rectangle.panel(a, b, -half[1], half[1], share * radiance) for a, b, share in bands)
    return tuple(rectangle.panel(-half[0], half[0], a, b, share * radiance) for a, b, share in bands)


def _bands(pattern: Mapping, lengths: Lengths, half: np.ndarray) -> list[tuple[float, float, float]]:
    """Return begin, end (mm from the middle) and share of the radiance of each band of a pattern.

    The tracer's panels have one radiance each, so a gradient is a row of narrow ones.
    """
    where = "light panel: pattern"
    common = ("kind", "direction")
    if not isinstance(pattern, Mapping) or pattern.get("kind") not in ("gradient", "stripes"):
        raise unknown_name(f"{where}: kind", dict(pattern).get("kind"), ("gradient", "stripes"))
    direction = pattern.get("direction", "horizontal")
    if direction not in ("horizontal", "vertical"):
        raise unknown_name(f"{where}: direction", direction, ("horizontal", "vertical"))
    reach = float(half[0] if direction == "horizontal" else half[1])
    if pattern["kind"] == "gradient":
        check_keys(pattern, (*common[:1], "from", "to"), ("direction", "steps"), where)
        begin, end = (_share(pattern, name, where) for name in ("from", "to"))
        steps = int(finite(pattern.get("steps", GRADIENT_STEPS), f"{where}: steps"))
        if not 2 <= steps <= MOST_PANELS:
            raise InputError(f"{where}: steps: must be 2 to {MOST_PANELS}, got {steps}")
        edges = np.linspace(-reach, reach, steps + 1)
        return list(zip(edges[:-1], edges[1:], np.linspace(begin, end, steps), strict=True))
    check_keys(pattern, common[:1], ("direction", "dark", "bright", *length_keys(["period"])), where)
    period = lengths.mm(pattern, "period", where)
    if period is None or period <= 0.0:
        raise InputError(f"{where}: stripes need a period above 0, as period_mm = 10")
    dark, bright = (_share({"dark": 0.0, "bright": 1.0, **pattern}, name, where) for name in ("dark", "bright"))
    stripes = int(np.ceil(4.0 * reach / period))
    if stripes > MOST_PANELS:
        raise InputError(f"{where}: {stripes} stripes are too many, {MOST_PANELS} at most; widen the period")
    # A bright stripe has its middle in the panel's, so that the pattern is its own mirror image.
    first = int(np.ceil(reach / (0.5 * period) - 0.5))
    edges = np.clip((np.arange(-first, first + 2) - 0.5) * 0.5 * period, -reach, reach)
    shares = np.where(np.arange(-first, first + 1) % 2 == 0, bright, dark)
    # What shines not need not be there: each panel costs time.
    return [(a, b, share) for a, b, share in zip(edges[:-1], edges[1:], shares, strict=True) if b > a and share > 0.0]


def _frame(table: Mapping, geometry: ContainerGeometry, camera: Camera, size: tuple[int, int]) -> tuple[Panel, ...]:
    """Return four panels around what the camera sees: no ray that goes straight on meets them."""
    where = "light frame"
    check_keys(table, ("kind",), (*PLACE, *length_keys(["band"]), "radiance"), where)
    band = Lengths.of(geometry).mm(table, "band", where)
    if band is None or band <= 0.0:
        raise InputError(f"{where}: give the width of its band, above 0, as band_mm = 80")
    rectangle = _Rectangle(table, geometry, where)
    corners_mm = rectangle.seen_through(camera, size)
    if corners_mm is None:
        raise InputError(f"{where}: the camera does not look through it; put it behind the container")
    room = CLEARANCE * float(np.ptp(corners_mm, axis=0).max())
    (left, bottom), (right, top) = corners_mm.min(axis=0) - room, corners_mm.max(axis=0) + room
    sides = (
        (left - band, right + band, top, top + band),
        (left - band, right + band, bottom - band, bottom),
        (left - band, left, bottom, top),
        (right, right + band, bottom, top),
    )
    return tuple(rectangle.panel(*side, _colour(table, where)) for side in sides)


def _ring(table: Mapping, geometry: ContainerGeometry) -> tuple[Panel, ...]:
    keys = length_keys(["diameter", "band", "above_finish"])
    check_keys(table, ("kind",), (*keys, "tilt_deg", "lamps", "radiance"), "light ring")
    lengths = Lengths.of(geometry)
    diameter, band, above = (lengths.mm(table, name, "light ring") for name in ("diameter", "band", "above_finish"))
    if diameter is None or band is None or above is None:
        raise InputError("light ring: give its diameter, its band and its height above_finish, as above_finish_mm")
    tilt = np.radians(finite(table.get("tilt_deg", 0.0), "light ring: tilt_deg"))
    lamps = int(finite(table.get("lamps", 24), "light ring: lamps"))
    if not 3 <= lamps <= MOST_PANELS:
        raise InputError(f"light ring: lamps: must be 3 to {MOST_PANELS}, got {lamps}")
    if not (diameter > 0.0 and band > 0.0) or band * np.cos(tilt) >= diameter:
        raise InputError(
            f"light ring: a band of {band:.4g} mm does not fit a diameter of {diameter:.4g} mm; both are above 0"
        )
    height = geometry.finish_height_mm + above
    chord = diameter * np.tan(np.pi / lamps)
    panels = []
    for angle in 2.0 * np.pi * (np.arange(lamps) + 0.5) / lamps:
        outwards = np.array([np.cos(angle), np.sin(angle), 0.0])
        along = np.array([-np.sin(angle), np.cos(angle), 0.0])
        # At no tilt the band lies flat and shines down, at 90 degrees it stands and shines inwards.
        across = np.cos(tilt) * outwards - np.sin(tilt) * np.array([0.0, 0.0, 1.0])
        middle = 0.5 * diameter * outwards + np.array([0.0, 0.0, height])
        corner = middle - 0.5 * chord * along - 0.5 * band * across
        panels.append(Panel(corner, chord * along, band * across, _colour(table, "light ring")))
    return tuple(panels)


def _sky(table: Mapping) -> tuple[Environment, ...]:
    check_keys(table, ("kind", "ground", "sky"), ("soft_boxes",), "light sky")
    return (Environment(sky_light(table["ground"], table["sky"], table.get("soft_boxes", []))),)


def _environment(table: Mapping, folder: Path) -> tuple[Environment, ...]:
    check_keys(table, ("kind",), ("image", "radiance"), "light environment")
    if ("image" in table) == ("radiance" in table):
        raise InputError("light environment: give it either an image or a radiance")
    if "radiance" in table:
        return (Environment(table["radiance"]),)
    # Only a station with a picture in it needs OpenImageIO.
    from glassworkbench.images import read_image

    return (Environment(read_image(folder / table["image"]).pixels),)


def _share(table: Mapping, name: str, where: str) -> float:
    value = finite(table[name], f"{where}: {name}")
    if value < 0.0:
        raise InputError(f"{where}: {name}: must not be negative, got {value:g}")
    return value


def _colour(table: Mapping, where: str) -> np.ndarray:
    value = table.get("radiance", 1.0)
    if isinstance(value, (int, float)):
        return np.full(3, _share(table | {"radiance": value}, "radiance", where))
    return finite_array(value, (3,), f"{where}: radiance")
