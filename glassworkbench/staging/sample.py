"""A tumbler to show stations with, where nobody has brought a mold."""

from __future__ import annotations

import numpy as np

from glassworkbench.scene import ContainerGeometry, Revolved
from glassworkbench.scene.file import read_meridian
from glassworkbench.settings import RESOURCES


def sample_container() -> ContainerGeometry:
    """Return a tumbler of 90 mm height, its meridians read from resources/stations."""
    outer, cavity = (
        Revolved(read_meridian(RESOURCES / "stations" / f"tumbler_{name}.csv")) for name in ("outer", "cavity")
    )
    radius, height = outer.meridian[..., :2].max(axis=(0, 1))
    high = np.array([radius, radius, height])
    return ContainerGeometry(outer, cavity, low_mm=(-radius, -radius, 0.0), high_mm=high, finish_height_mm=height)
