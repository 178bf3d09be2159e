"""An image of a scene: radiance, how wrong it may be, how far away, and where it came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.images import files
from glassworkbench.images.tone import from_display, to_display
from glassworkbench.output import check_writable

CHANNELS = ("R", "G", "B", "certificate", "depth")
LINEAR_ENDINGS = (".exr", ".tif", ".tiff")
DISPLAY_ENDINGS = (".png", ".jpg", ".jpeg")
IMAGE_ENDINGS = LINEAR_ENDINGS + DISPLAY_ENDINGS


@dataclass(frozen=True, eq=False)
class Image:
    """A linear, scene-referred image: a panel of radiance 1 reads 1.0 where nothing is in the way.

    Its arrays are kept in float32.

    Parameters
    ----------
    pixels : array (h, w, 3)
        R, G, B radiance.
    certificate : array (h, w)
        Bound on the pixel's error, in radiance; NaN where unknown.
    depth_mm : array (h, w)
        Distance from the camera to the first surface; infinite where there is none, NaN where unknown.
    metadata : mapping of str to str
        Mold, wall, glass, station and whatever else the file shall tell.
    report : mapping
        What the rendering cost and which effects it traced, as ``--report`` writes it.
    corner : (int, int)
        Column and row, in the whole image, of the upper left pixel; not 0, 0 where this is a crop.
    whole : (int, int), optional
        Width and height of the whole image; that of `pixels` where not given.

    Raises
    ------
    InputError
        If the arrays' shapes do not belong together, or the crop does not lie in the whole.
    """

    pixels: np.ndarray
    certificate: np.ndarray
    depth_mm: np.ndarray
    metadata: Mapping[str, str] = field(default_factory=dict)
    report: Mapping = field(default_factory=dict)
    corner: tuple[int, int] = (0, 0)
    whole: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        for name in ("pixels", "certificate", "depth_mm"):
            object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name), dtype=np.float32))
        if self.pixels.ndim != 3 or self.pixels.shape[2] != 3 or self.pixels.size == 0:
            raise InputError(f"pixels: expected an array (height, width, 3), got shape {self.pixels.shape}")
        for name in ("certificate", "depth_mm"):
            shape = getattr(self, name).shape
            if shape != self.pixels.shape[:2]:
                raise InputError(f"{name}: expected shape {self.pixels.shape[:2]}, got {shape}")
        height, width = self.pixels.shape[:2]
        (left, top), whole = self.corner, self.whole or (width, height)
        object.__setattr__(self, "whole", tuple(whole))
        if min(left, top) < 0 or left + width > whole[0] or top + height > whole[1]:
            raise InputError(
                f"corner: {width}x{height} pixels at {left},{top} do not lie in an image of {whole[0]}x{whole[1]}"
            )

    def with_part(self, part: Image) -> Image:
        """Return the image with a crop of the same whole in place of what it has there.

        The report stays, and its ``parts`` list the reports of what was put in.

        Raises
        ------
        InputError
            If the crop does not lie in this image, or is of another whole.
        """
        left, top = part.corner[0] - self.corner[0], part.corner[1] - self.corner[1]
        height, width = part.pixels.shape[:2]
        rows, columns = slice(top, top + height), slice(left, left + width)
        if part.whole != self.whole or min(left, top) < 0 or self.pixels[rows, columns].shape != part.pixels.shape:
            raise InputError("part: it does not lie in this image; render it of the same scene, at the same size")
        arrays = {}
        for name in ("pixels", "certificate", "depth_mm"):
            values = getattr(self, name).copy()
            values[rows, columns] = getattr(part, name)
            arrays[name] = values
        report = {**self.report, "parts": [*self.report.get("parts", ()), part.report]}
        return replace(self, **arrays, report=report)

    def display(self, exposure: float = 0.0) -> np.ndarray:
        """Return the uint8 sRGB picture (h, w, 3); `exposure` in stops, radiance 1 is white at 0."""
        return to_display(self.pixels, exposure)

    def description(self) -> dict[str, str]:
        """Return the metadata as the file carries it: the scene's, and tolerance, seconds, effects and version."""
        told = {key: str(value) for key, value in self.metadata.items()}
        for key in ("tolerance", "seconds", "version"):
            if self.report.get(key) is not None:
                told[key] = str(self.report[key])
        if "effects" in self.report:
            told["effects"] = ", ".join(effect["name"] for effect in self.report["effects"] if effect["on"]) or "none"
        return told

    def save(self, path: str | Path, exposure: float = 0.0) -> None:
        """Write the image; the ending decides.

        ``.exr`` and ``.tif`` keep float32 linear values with the channels R, G, B, certificate, depth and ignore
        `exposure`; ``.exr`` also tells where in the whole image a crop lies (its data window). ``.png`` and ``.jpg``
        hold the sRGB picture. All carry `description()`.

        Parameters
        ----------
        path : str or Path
        exposure : float
            In stops; radiance 2 ** -exposure becomes white.

        Raises
        ------
        InputError
            If the ending is not known, or nothing can be written there.
        GlassWorkbenchError
            If writing fails.
        """
        path = check_writable(path, IMAGE_ENDINGS)
        told = self.description()
        if path.suffix.lower() in LINEAR_ENDINGS:
            channels = np.dstack([self.pixels, self.certificate, self.depth_mm])
            files.write(path, channels, CHANNELS, told, (self.corner, self.whole))
        else:
            told |= {"tone_curve": "sRGB", "exposure": f"{exposure:g}"}
            files.write(path, self.display(exposure), CHANNELS[:3], told)


def read_image(path: str | Path) -> Image:
    """Return the image that a file holds, its values linear.

    Certificate and depth are NaN where the file has none; one grey channel stands for R, G and B.

    Raises
    ------
    InputError
        If the file is missing, is no image, or has no colour channels.
    """
    values, names, told, (corner, whole) = files.read(path)
    if _is_display(path):
        values = from_display(values, float(told.get("exposure", 0.0)))
    columns = {name: values[:, :, k] for k, name in enumerate(names)}
    if all(name in columns for name in "RGB"):
        pixels = np.dstack([columns[name] for name in "RGB"])
    elif "Y" in columns or len(names) == 1:
        pixels = np.repeat(columns.get("Y", values[:, :, 0])[:, :, None], 3, axis=2)
    else:
        raise InputError(f"{path}: expected the channels R, G and B, found {', '.join(names)}")
    unknown = np.full(pixels.shape[:2], np.nan)
    certificate, depth_mm = columns.get("certificate", unknown), columns.get("depth", unknown)
    return Image(pixels, certificate, depth_mm, told, corner=corner, whole=whole)


def _is_display(path: str | Path) -> bool:
    return Path(path).suffix.lower() in DISPLAY_ENDINGS
