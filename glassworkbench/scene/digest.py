"""A short name for all that an image of a scene depends on: two scenes with one digest have the same image."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterator

import numpy as np

from glassworkbench.scene.scene import Scene


def digest(scene: Scene) -> str:
    """Return the SHA-256 of bodies, media, lights, camera and size, to the last bit; not of the metadata."""
    total = hashlib.sha256()
    for field in dataclasses.fields(scene):
        if field.name != "metadata":
            for piece in _pieces(getattr(scene, field.name)):
                total.update(piece)
    return total.hexdigest()


def _pieces(value: object) -> Iterator[bytes]:
    """Yield the bytes of a value, each kind marked so that no two values share theirs."""
    if dataclasses.is_dataclass(value):
        yield f"<{type(value).__name__}>".encode()
        for field in dataclasses.fields(value):
            yield from _pieces(getattr(value, field.name))
    elif isinstance(value, tuple):
        yield f"({len(value)})".encode()
        for item in value:
            yield from _pieces(item)
    elif isinstance(value, np.ndarray):
        yield f"[{value.dtype}{value.shape}]".encode()
        yield np.ascontiguousarray(value).tobytes()
    else:
        yield f"{value!r};".encode()
