"""The camera of a station file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene import Camera, ContainerGeometry, Pinhole, Telecentric
from glassworkbench.scene.validate import finite, finite_array
from glassworkbench.settings import check_keys, unknown_name
from glassworkbench.staging import framing
from glassworkbench.staging.directions import corners, towards
from glassworkbench.staging.lengths import Lengths, length_keys
from glassworkbench.staging.optics import Optics, lens

KINDS = ("pinhole", "telecentric", "line")
"""A line camera is a telecentric one with one column of pixels: the container turns before it."""
POSE = ("azimuth_deg", "elevation_deg", "view", "aim_mm")
FITTED = ("margin", "field_of_view_deg", *length_keys(["distance"]))
LENS = ("sensor_mm", "pixels", "focal_length_mm", "magnification", "working_distance_mm", "f_number")

POSITION = (("azimuth_deg", -90.0), ("elevation_deg", 0.0))
"""Where the camera stands, and where it does if that is not given: in front."""

USUAL_SIZE = (480, 640)
USUAL_MARGIN = 0.05
SHARP_PX = 1.0
"""A blur of more pixels than this is told."""


@dataclass(frozen=True, eq=False)
class Placed:
    """A camera, the size of its image in pixels, and what the user should know of it, in sentences."""

    camera: Camera
    size: tuple[int, int]
    notes: tuple[str, ...] = ()


def place_camera(table: Mapping, geometry: ContainerGeometry, size: tuple[int, int] | None) -> Placed:
    """Return the camera that a station's table ``[camera]`` describes.

    Parameters
    ----------
    table : mapping
        Either fitted to the container, by a margin, or a lens in front of a sensor; `docs/stations.md` lists the keys.
    geometry : ContainerGeometry
    size : (int, int), optional
        Pixels of the image; the sensor's where None. With other pixels a sensor keeps its height.

    Raises
    ------
    InputError
        If a key is not known, absent or impossible.
    """
    check_keys(table, ("kind",), (*POSE, *FITTED, *LENS), "camera")
    kind = table["kind"]
    if kind not in KINDS:
        raise unknown_name("camera: kind", kind, KINDS)
    is_lens = any(key in table for key in LENS)
    wrong = [key for key in (FITTED if is_lens else ()) if key in table]
    if wrong:
        raise InputError(f"camera: {wrong[0]} is for a camera fitted to the container; leave it or the lens out")
    if "field_of_view_deg" in table and kind != "pinhole":
        raise InputError(f"camera: field_of_view_deg: a {kind} camera has none; give a margin, or a magnification")
    there, up = towards(*(finite(table.get(key, usual), f"camera: {key}") for key, usual in POSITION))
    seen = corners(geometry, table.get("view", "all"), "camera")
    if "aim_mm" in table:
        seen = seen - seen.mean(axis=0) + finite_array(table["aim_mm"], (3,), "camera: aim_mm")
    if kind == "line":
        size = size and (1, size[1])
        # One column of pixels has only heights to fit, and the container turns about the axis.
        across = np.cross(there, up)
        aim = seen.mean(axis=0) @ across if "aim_mm" in table else 0.0
        seen = seen + np.multiply.outer(aim - seen @ across, across)
    if is_lens:
        return _with_lens(table, kind, seen, there, up, size)
    usual = (1, USUAL_SIZE[1]) if kind == "line" else USUAL_SIZE
    return _fitted(table, kind, seen, there, up, size or usual, geometry)


def _fitted(
    table: Mapping,
    kind: str,
    seen: np.ndarray,
    there: np.ndarray,
    up: np.ndarray,
    size: tuple[int, int],
    geometry: ContainerGeometry,
) -> Placed:
    margin = finite(table.get("margin", USUAL_MARGIN), "camera: margin")
    if not 0.0 <= margin < 0.5:
        raise InputError(f"camera: margin: must be at least 0 and below 0.5, got {margin:g}")
    lengths = Lengths.of(geometry)
    distance = lengths.mm(table, "distance", "camera")
    if distance is not None and distance <= 0.0:
        raise InputError(f"camera: distance: must be above 0, got {distance:g} mm")
    if kind != "pinhole":
        return Placed(framing.telecentric(seen, size, there, up, distance or 3.0 * lengths.sizes_mm, margin), size)
    if (distance is None) == ("field_of_view_deg" not in table):
        raise InputError("camera: give either field_of_view_deg or a distance; the other follows from the margin")
    if distance is not None:
        return Placed(framing.pinhole_at_distance(seen, size, there, up, distance, margin), size)
    angle = finite(table["field_of_view_deg"], "camera: field_of_view_deg")
    if not 0.0 < angle < 180.0:
        raise InputError(f"camera: field_of_view_deg: must be above 0 and below 180, got {angle:g}")
    return Placed(framing.pinhole_at_angle(seen, size, there, up, np.radians(angle), margin), size)


def _with_lens(
    table: Mapping, kind: str, seen: np.ndarray, there: np.ndarray, up: np.ndarray, size: tuple[int, int] | None
) -> Placed:
    optics = _optics({key: table[key] for key in LENS if key in table}, kind)
    target = seen.mean(axis=0)
    eye = target + optics.working_distance_mm * there
    camera: Camera
    if kind != "pinhole":
        camera = Telecentric(eye, target, optics.field_height_mm, up)
    else:
        camera = Pinhole(eye, target, optics.vertical_field_of_view_rad, up)
    nearer = float(np.max((seen - target) @ there))
    blur = optics.blur_px(nearer)
    notes = ()
    if blur > SHARP_PX:
        notes = (
            f"at f/{optics.f_number:g} the container's near side is {nearer:.3g} mm before the focus and blurred by "
            f"{blur:.2g} pixels, which is not traced",
        )
    return Placed(camera, size or optics.pixels, notes)


def _optics(table: Mapping, kind: str) -> Optics:
    needed = ("sensor_mm", "pixels")
    if kind == "pinhole":
        check_keys(table, needed, LENS, "camera")
        return lens(**table)
    if "focal_length_mm" in table:
        raise InputError("camera: focal_length_mm: a telecentric lens is told by magnification and working_distance_mm")
    check_keys(table, (*needed, "magnification", "working_distance_mm"), LENS, "camera")
    if kind == "line" and table["pixels"][0] != 1:
        raise InputError(f"camera: pixels: a line camera has one column, as [1, 2048], got {table['pixels']!r}")
    return Optics(**table)
