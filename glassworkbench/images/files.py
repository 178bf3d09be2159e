"""Arrays with named channels and text, to and from image files through OpenImageIO."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import OpenImageIO

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.output import written_aside

Place = tuple[tuple[int, int], tuple[int, int]]
"""Where an image's upper left pixel lies in the whole of which it is a crop, and the whole's width and height."""


def write(
    path: Path, values: np.ndarray, channels: Sequence[str], text: Mapping[str, str], place: Place | None = None
) -> None:
    """Write `values` (h, w, channels), uint8 or float32, with `text` as metadata.

    The place goes into EXR files, as data window within a display window; other formats know of none.

    TIFF and JPEG keep only the tags they know, TIFF no channel names, and OpenImageIO 3 drops an EXR attribute
    called version: so `text` and the channels' names also go, as JSON, into the image's description.
    """
    height, width = values.shape[:2]
    spec = OpenImageIO.ImageSpec(
        width, height, len(channels), OpenImageIO.UINT8 if values.dtype == np.uint8 else OpenImageIO.FLOAT
    )
    spec.channelnames = tuple(channels)
    if place is not None and path.suffix.lower() == ".exr":
        (spec.x, spec.y), (spec.full_width, spec.full_height) = place
    spec.attribute("oiio:ColorSpace", "sRGB" if values.dtype == np.uint8 else "Linear")
    spec.attribute("CompressionQuality", 95)
    spec.attribute("Software", f"GlassWorkbench {text['version']}" if "version" in text else "GlassWorkbench")
    for key, value in text.items():
        spec.attribute(key, value)
    described = dict(text) | {"channels": ",".join(channels)}
    spec.attribute("ImageDescription", json.dumps(described, ensure_ascii=False))
    with written_aside(path) as aside:
        output = OpenImageIO.ImageOutput.create(str(aside))
        if output is None:
            raise GlassWorkbenchError(f"{path}: OpenImageIO cannot write this format ({OpenImageIO.geterror()})")
        if not (output.open(str(aside), spec) and output.write_image(values) and output.close()):
            raise GlassWorkbenchError(f"{path}: could not be written ({output.geterror()})")


def read(path: str | Path) -> tuple[np.ndarray, tuple[str, ...], dict[str, str], Place]:
    """Return values (h, w, channels) as float64 (integers scaled to 0..1), channel names, the text written, the place.

    An EXR file of another program may hold pixels outside its display window: it is read as if it were whole.

    Raises
    ------
    InputError
        If the file is missing or OpenImageIO cannot read it.
    """
    if not isinstance(path, (str, os.PathLike)):
        raise InputError(f"image: {path!r} is no path; give the name of a file")
    if not Path(path).is_file():
        raise InputError(f"{path}: there is no such file; check the path")
    source = OpenImageIO.ImageInput.open(str(path))
    if source is None:
        raise InputError(f"{path}: not an image that can be read ({OpenImageIO.geterror()})")
    spec = source.spec()
    values = source.read_image(0, 0, 0, spec.nchannels, OpenImageIO.FLOAT)
    if values is None:
        raise InputError(f"{path}: the image is damaged ({source.geterror()})")
    values = np.asarray(values, dtype=np.float64).reshape(spec.height, spec.width, spec.nchannels)
    source.close()
    text = _text(spec)
    channels = tuple(text.pop("channels", "").split(","))
    if len(channels) != spec.nchannels or Path(path).suffix.lower() == ".exr":
        channels = tuple(spec.channelnames)
    return values, channels, text, _place(spec)


def _place(spec: OpenImageIO.ImageSpec) -> Place:
    left, top = spec.x - spec.full_x, spec.y - spec.full_y
    if min(left, top) < 0 or left + spec.width > spec.full_width or top + spec.height > spec.full_height:
        return (0, 0), (spec.width, spec.height)
    return (left, top), (spec.full_width, spec.full_height)


def _text(spec: OpenImageIO.ImageSpec) -> dict[str, str]:
    try:
        text = json.loads(spec.get_string_attribute("ImageDescription"))
    except ValueError:
        return {}
    return {str(key): str(value) for key, value in text.items()} if isinstance(text, dict) else {}


def stored_bits(path: str | Path) -> int | None:
    """Return how many bits an image file stores of each channel, 8, 16 or 32; None where they are floating-point.

    Raises
    ------
    InputError
        If OpenImageIO cannot read it.
    """
    source = OpenImageIO.ImageInput.open(str(path))
    if source is None:
        raise InputError(f"{path}: not an image that can be read ({OpenImageIO.geterror()})")
    kind = source.spec().format
    source.close()
    return None if kind.basetype in (OpenImageIO.FLOAT, OpenImageIO.HALF, OpenImageIO.DOUBLE) else 8 * kind.basesize()
