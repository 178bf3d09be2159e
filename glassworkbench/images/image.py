"""An image of a scene: radiance, how wrong it may be, how far away, and where it came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
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

    Raises
    ------
    InputError
        If the arrays' shapes do not belong together.
    """

    pixels: np.ndarray
    certificate: np.ndarray
    depth_mm: np.ndarray
    metadata: Mapping[str, str] = field(default_factory=dict)
    report: Mapping = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("pixels", "certificate", "depth_mm"):
            object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name), dtype=np.float32))
        if self.pixels.ndim != 3 or self.pixels.shape[2] != 3 or self.pixels.size == 0:
            raise InputError(f"pixels: expected an array (height, width, 3), got shape {self.pixels.shape}")
        for name in ("certificate", "depth_mm"):
            shape = getattr(self, name).shape
            if shape != self.pixels.shape[:2]:
                raise InputError(f"{name}: expected shape {self.pixels.shape[:2]}, got {shape}")

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
        `exposure`; ``.png`` and ``.jpg`` hold the sRGB picture. All carry `description()`.

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
            files.write(path, channels, CHANNELS, told)
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
    values, names, told = files.read(path)
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
    return Image(pixels, columns.get("certificate", unknown), columns.get("depth", unknown), told)


def _is_display(path: str | Path) -> bool:
    return Path(path).suffix.lower() in DISPLAY_ENDINGS
