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


def write(path: Path, values: np.ndarray, channels: Sequence[str], text: Mapping[str, str]) -> None:
    """Write `values` (h, w, channels), uint8 or float32, with `text` as metadata.

    TIFF and JPEG keep only the tags they know, TIFF no channel names, and OpenImageIO 3 drops an EXR attribute
    called version: so `text` and the channels' names also go, as JSON, into the image's description.
    """
    height, width = values.shape[:2]
    spec = OpenImageIO.ImageSpec(
        width, height, len(channels), OpenImageIO.UINT8 if values.dtype == np.uint8 else OpenImageIO.FLOAT
    )
    spec.channelnames = tuple(channels)
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


def read(path: str | Path) -> tuple[np.ndarray, tuple[str, ...], dict[str, str]]:
    """Return values (h, w, channels) as float64 (integers scaled to 0..1), channel names, and the text written.

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
    return values, channels, text


def _text(spec: OpenImageIO.ImageSpec) -> dict[str, str]:
    try:
        text = json.loads(spec.get_string_attribute("ImageDescription"))
    except ValueError:
        return {}
    return {str(key): str(value) for key, value in text.items()} if isinstance(text, dict) else {}
