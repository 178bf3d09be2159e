"""A golden image: what one camera of the line should see of a good container, pixel by pixel, with a band."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy import ndimage

from glassworkbench.errors import InputError
from glassworkbench.images import Image, check_writable, files, luminance
from glassworkbench.scene.image_scale import ImageScale

LAYERS = ("nominal", "mean", "sigma", "lower", "upper", "valid", "zone")
ENDINGS = (".exr",)
FORMAT = "1"
"""Of the file; goes into its metadata as ``golden``."""

BAND = 1.959964
"""Half the width of a band that holds 95 % of a normal distribution, in standard deviations."""

USUAL_NOISE = 0.01
"""Standard deviation taken where nothing is known of the process but one rendering, as a share of white."""


USUAL_EDGE = 0.15
"""What is added to it, as a share of the range among a pixel and its neighbours: good containers do not stand still."""


@dataclass(frozen=True, eq=False)
class GoldenImage:
    """Luminance (a panel of radiance 1 reads 1) and its spread over good containers, at every pixel.

    Parameters
    ----------
    nominal : array (h, w)
        The container as it was asked.
    mean, sigma : array (h, w)
        Over the process variation.
    lower, upper : array (h, w)
        The band that holds 95 % of good samples.
    valid : array (h, w) of bool
        Pixels that are judged.
    zone : array (h, w) of int
        Number of each pixel's zone, counted from 1; 0 where there is none.
    zones : tuple of str
        Their names, like finish, neck, shoulder, body, heel, base.
    scale : ImageScale, optional
        What takes pixels to millimetres on the container; without it sizes are told in pixels alone.
    metadata : mapping of str to str
        Mold, wall, glass, station and whatever else the file shall tell.

    Raises
    ------
    InputError
        If the arrays' shapes do not belong together, a sigma is negative, the band is upside down, or a zone has no
        name.
    """

    nominal: np.ndarray
    mean: np.ndarray
    sigma: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    valid: np.ndarray
    zone: np.ndarray
    zones: tuple[str, ...]
    scale: ImageScale | None = None
    metadata: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        kinds = dict.fromkeys(LAYERS, np.float32) | {"valid": np.bool_, "zone": np.int32}
        for name, kind in kinds.items():
            array = np.ascontiguousarray(getattr(self, name)).astype(kind)
            if array.ndim != 2 or array.shape != np.shape(self.mean) or array.size == 0:
                raise InputError(f"{name}: expected shape {np.shape(self.mean)}, got {array.shape}")
            object.__setattr__(self, name, array)
        object.__setattr__(self, "zones", tuple(self.zones))
        judged = self.valid
        for name in LAYERS[:5]:
            if not np.all(np.isfinite(getattr(self, name)[judged])):
                raise InputError(f"{name}: a valid pixel is not finite")
        if np.any(self.sigma[judged] < 0.0) or np.any(self.lower[judged] > self.upper[judged]):
            raise InputError("sigma, lower, upper: a valid pixel has a negative sigma, or its band is upside down")
        if not np.any(judged):
            raise InputError("valid: no pixel is judged")
        if self.zone.min() < 0 or self.zone.max() > len(self.zones):
            raise InputError(f"zone: numbers run to {self.zone.max()}, but there are {len(self.zones)} names")

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.mean.shape[1], self.mean.shape[0]

    def save(self, path: str | Path) -> None:
        """Write an EXR file with one channel a layer, float32.

        Raises
        ------
        InputError
            If the ending is not .exr, or nothing can be written there.
        GlassWorkbenchError
            If writing fails.
        """
        path = check_writable(path, ENDINGS)
        told = {**self.metadata, "golden": FORMAT, "zones": ",".join(self.zones)}
        if self.scale is not None:
            told |= self.scale.to_metadata()
        files.write(path, np.dstack([getattr(self, name).astype(np.float32) for name in LAYERS]), LAYERS, told)


def read_golden(path: str | Path) -> GoldenImage:
    """Return the golden image in an EXR file; of a plain rendering, the one that `golden_of` makes of it.

    Raises
    ------
    InputError
        If the file is missing, or neither.
    """
    values, names, told, (corner, whole) = files.read(path)
    columns = {name: values[:, :, k] for k, name in enumerate(names)}
    try:
        if "mean" in columns:
            return _of_layers(columns, told)
        if all(name in columns for name in ("R", "G", "B", "certificate", "depth")):
            colours = np.dstack([columns[name] for name in "RGB"])
            return golden_of(Image(colours, columns["certificate"], columns["depth"], told, corner=corner, whole=whole))
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    raise InputError(
        f"{path}: no golden image; it needs the channels {', '.join(LAYERS)}, or those of a rendering saved as .exr, "
        f"and has {', '.join(names)}"
    )


def _of_layers(columns: Mapping[str, np.ndarray], told: Mapping[str, str]) -> GoldenImage:
    missing = [name for name in LAYERS if name not in columns]
    if missing:
        raise InputError(f"the layer {missing[0]!r} is missing; write golden images with GoldenImage.save")
    if told.get("golden") != FORMAT:
        raise InputError(f"golden format {told.get('golden')!r} is not known, only {FORMAT!r}; update GlassWorkbench")
    zones = tuple(name for name in told.get("zones", "").split(",") if name)
    layers = {name: columns[name] for name in LAYERS}
    layers["zone"] = np.rint(layers["zone"])
    layers["valid"] = layers["valid"] > 0.5
    return GoldenImage(**layers, zones=zones, scale=ImageScale.from_metadata(told), metadata=dict(told))


def golden_of(
    image: Image, noise: float = USUAL_NOISE, zones_mm: Mapping[str, tuple[float, float]] | None = None
) -> GoldenImage:
    """Return a golden image of one rendering, where nothing is known of the process.

    Parameters
    ----------
    image : Image
        Of a station, with depth.
    noise : float
        Standard deviation of good images, as a share of white; the certificate is added to it, and what moves at edges.
    zones_mm : mapping of str to (float, float), optional
        Lower and upper height of each zone; one zone, container, where not given.

    Raises
    ------
    InputError
        If the image shows no container, or zones are asked of an image that has no scale of height.
    """
    grey = luminance(image.pixels)
    edge = USUAL_EDGE * (ndimage.maximum_filter(grey, size=3) - ndimage.minimum_filter(grey, size=3))
    sigma = np.sqrt(noise**2 + np.nan_to_num(image.certificate) ** 2 + edge**2)
    valid = np.isfinite(image.depth_mm)
    scale = ImageScale.from_metadata(image.metadata)
    if not np.any(valid):
        raise InputError("image: it shows no container, or knows no depth; render a container at a station, as .exr")
    zone = valid.astype(np.int32)
    if zones_mm is not None:
        if scale is None or scale.view != "side":
            raise InputError("zones_mm: the image has no scale of height; render it at a station that looks sidewise")
        height = (scale.base_row - (np.arange(len(grey)) + 0.5)) / scale.rows_per_mm
        zone = np.zeros_like(zone)
        for number, (low, high) in enumerate(zones_mm.values(), start=1):
            zone[(height >= low) & (height < high)] = number
        zone[~valid] = 0
    return GoldenImage(
        nominal=grey,
        mean=grey,
        sigma=sigma,
        lower=grey - BAND * sigma,
        upper=grey + BAND * sigma,
        valid=valid,
        zone=zone,
        zones=("container",) if zones_mm is None else tuple(zones_mm),
        scale=scale,
        metadata=image.description(),
    )
