"""STEP files that name their product: OCC calls everything after itself."""

from __future__ import annotations

import re
from pathlib import Path

from glassworkbench.freecad import Part

OCC_NAMES = re.compile(rb"'Open CASCADE (?:STEP translator|Shape Model)[^']*'")
"""What OCC calls a product, and the file's title."""


def write_step(solid: Part.Shape, name: str, path: Path) -> None:
    """Write a solid as STEP; the product and the file's title have this name."""
    solid.exportStep(str(path))
    quoted = f"'{_encoded(name)}'".encode("ascii")
    path.write_bytes(OCC_NAMES.sub(lambda _: quoted, path.read_bytes()))


def _encoded(name: str) -> str:
    """Return a text as it stands between a STEP file's quotes (ISO 10303-21, 6.4.3)."""
    doubled = name.replace("\\", "\\\\").replace("'", "''")
    return re.sub(r"[^\x20-\x7e]+", lambda found: f"\\X2\\{found[0].encode('utf-16-be').hex().upper()}\\X0\\", doubled)
