"""What departs from the golden image: blobs of the z-map, with their size, and their place on the container."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from skimage.filters import apply_hysteresis_threshold
from skimage.measure import label, regionprops

from glassworkbench.judging.golden_image import GoldenImage

SEED_Z, REACH_Z = 5.0, 3.0
"""A blob has a pixel that departs by so many standard deviations, and reaches as far as they depart by these."""

SMALLEST_PX = 3
"""Blobs of fewer pixels are noise."""

EDGE_SHARE = 0.1
"""By this share of the range among a pixel and its neighbours the band is wider: at an edge, a registration that is off
by a twentieth of a pixel, and other places of the pixels on it, change that much."""

CLEAR_SHARE = 0.1
"""What departs by less than this share of a blob's greatest departure does not count to its size: noise beside it."""

HALO_PX = 1.5
"""A blob appears larger by this: it is cut into whole pixels, and resampling spreads it."""

ONE_SIGN = 0.8
"""A blob is dark or bright if this share of its departure is; else it is mixed."""


@dataclass(frozen=True)
class Finding:
    """A blob.

    Parameters
    ----------
    kind : str
        ``"dark"``, ``"bright"`` or ``"mixed"``.
    size_mm : float or None
        Its greatest extent; None where the golden image has no scale.
    size_px, area_px : float
    height_mm, angle_deg : float or None
        Where it is on the container: above its lowest point (not known from above), and about the axis, from +x
        towards +y.
    z : float
        Its greatest departure from the mean, in standard deviations, with its sign.
    zone : str
    defect_class : str or None
        Critical, major, minor; None if it is too small for any.
    column, row : float
        Of its middle, in the golden image.
    box : (int, int, int, int)
        Left, top, right, bottom in the golden image.
    """

    kind: str
    size_mm: float | None
    size_px: float
    area_px: float
    height_mm: float | None
    angle_deg: float | None
    z: float
    zone: str
    defect_class: str | None
    column: float
    row: float
    box: tuple[int, int, int, int]

    def to_json(self) -> dict:
        """Return the finding as the report has it."""
        told = dict(vars(self))
        told["class"] = told.pop("defect_class")
        return told


def z_map(golden: GoldenImage, seen: np.ndarray) -> np.ndarray:
    """Return by how many standard deviations an image (h, w), registered, departs from the mean; NaN where not judged.

    To the golden image's sigma comes what happens at edges, by `EDGE_SHARE`.
    """
    mean = golden.mean.astype(np.float64)
    known = np.nan_to_num(mean)
    edge = EDGE_SHARE * (ndimage.maximum_filter(known, size=3) - ndimage.minimum_filter(known, size=3))
    spread = np.sqrt(golden.sigma.astype(np.float64) ** 2 + edge**2)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = (seen - mean) / np.maximum(spread, 1e-6)
    return np.where(golden.valid, z, np.nan)


def find(golden: GoldenImage, z: np.ndarray) -> tuple[Finding, ...]:
    """Return the blobs of a z-map, without their classes, the worst first."""
    departure = np.nan_to_num(np.abs(z), nan=0.0, posinf=1e6)
    blobs = label(apply_hysteresis_threshold(departure, REACH_Z, SEED_Z), connectivity=2)
    found = [_finding(golden, z, blob) for blob in regionprops(blobs) if blob.area >= SMALLEST_PX]
    return tuple(sorted(found, key=lambda finding: -abs(finding.z)))


def _finding(golden: GoldenImage, z: np.ndarray, blob: object) -> Finding:
    rows, columns = blob.coords.T
    values = z[rows, columns]
    dark = -values[values < 0.0].sum() / np.abs(values).sum()
    weight = np.abs(values)
    column, row = (float(np.average(places, weights=weight)) + 0.5 for places in (columns, rows))
    clear = np.zeros(blob.image.shape, dtype=np.uint8)
    top, left, bottom, right = blob.bbox
    clear[rows - top, columns - left] = weight >= CLEAR_SHARE * weight.max()
    size_px = max(1.0, float(regionprops(clear)[0].feret_diameter_max) - HALO_PX)
    number = np.bincount(golden.zone[rows, columns]).argmax()
    size_mm = height_mm = angle_deg = None
    if golden.scale is not None:
        size_mm = size_px / golden.scale.px_per_mm
        height_mm, angle_deg = golden.scale.place(column, row, _half_width_mm(golden, int(row)))
    return Finding(
        kind="dark" if dark >= ONE_SIGN else "bright" if dark <= 1.0 - ONE_SIGN else "mixed",
        size_mm=size_mm,
        size_px=size_px,
        area_px=float(blob.area),
        height_mm=height_mm,
        angle_deg=angle_deg,
        z=float(values[np.argmax(weight)]),
        zone=golden.zones[number - 1] if number > 0 else "none",
        defect_class=None,
        column=column,
        row=row,
        box=(left, top, right, bottom),
    )


def _half_width_mm(golden: GoldenImage, row: int) -> float:
    """Return half of what is judged of a row, which is half of the container's width there."""
    columns = np.flatnonzero(golden.valid[row])
    return 0.5 * (columns[-1] - columns[0] + 1) / golden.scale.px_per_mm if len(columns) else 0.0
