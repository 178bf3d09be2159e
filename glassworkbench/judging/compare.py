"""A camera's image held against the golden one: the verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.judging.camera_image import CameraImage, read_camera_image
from glassworkbench.judging.findings import Finding, find, z_map
from glassworkbench.judging.golden_image import GoldenImage, read_golden
from glassworkbench.judging.limits import CLASSES, Limits, read_limits
from glassworkbench.judging.registration import Registration, register

MOST_SATURATED = 0.2
"""Share of the judged pixels that may be at full scale."""

LEAST_SEEN = 0.9
"""Share of the judged pixels that the camera's image must reach."""

MOST_SHIFT = 0.25
"""Of the image's shorter side."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """What a camera's image shows that the golden one does not.

    Parameters
    ----------
    verdict : str
        ``"accept"`` or ``"reject"``.
    zones : mapping of str to str
        Verdict by zone.
    findings : tuple of Finding
        Those that are of a class, the worst first.
    registration : Registration
    z : array (h, w)
        Departure in standard deviations, on the golden image's pixels; NaN where not judged.
    image : CameraImage
    """

    verdict: str
    zones: Mapping[str, str]
    findings: tuple[Finding, ...]
    registration: Registration
    z: np.ndarray
    image: CameraImage

    def to_json(self) -> dict:
        """Return the report of the verb compare, without what it was given."""
        counts = {
            zone: {name: sum(f.zone == zone and f.defect_class == name for f in self.findings) for name in CLASSES}
            for zone in self.zones
        }
        return {
            "verdict": self.verdict,
            "zones": [{"name": zone, "verdict": told, **counts[zone]} for zone, told in self.zones.items()],
            "findings": [finding.to_json() for finding in self.findings],
            "registration": dict(vars(self.registration)),
        }


def compare(
    golden: GoldenImage | str | Path,
    image: CameraImage | str | Path,
    *,
    limits: Limits | str | Path | None = None,
    tone: str | None = None,
) -> Comparison:
    """Return how a camera's image compares with a golden one.

    Parameters
    ----------
    golden : GoldenImage or path
        A golden image, or a rendering saved as .exr.
    image : CameraImage or path
        Of the same size; 8 to 16-bit PNG or TIFF, or EXR.
    limits : Limits or path, optional
        The usual ones where not given.
    tone : str, optional
        ``"linear"`` or ``"sRGB"``, of the camera's image; as its metadata say where not given, else linear.

    Raises
    ------
    InputError
        If a file cannot be read, the images are of different sizes, or the camera's image is blank, saturated, or does
        not show what the golden one shows.
    """
    name = "image" if isinstance(image, CameraImage) else str(image)
    golden = golden if isinstance(golden, GoldenImage) else read_golden(golden)
    limits = limits if isinstance(limits, Limits) else read_limits(limits)
    image = image if isinstance(image, CameraImage) else read_camera_image(image, tone)
    if image.size != golden.size:
        (width, height), (wide, high) = image.size, golden.size
        turned = "turn it by 90 degrees" if (height, width) == (wide, high) else "crop it as the golden image is"
        raise InputError(f"{name}: it has {width}x{height} pixels, the golden image {wide}x{high}; {turned}")
    saturated = float(np.mean(image.saturated[golden.valid]))
    if saturated > MOST_SATURATED:
        raise InputError(
            f"{name}: {100.0 * saturated:.0f} % of the judged pixels are saturated; expose the camera for less"
        )
    registration = _registered(golden, image, name)
    z = z_map(golden, registration.resampled(image.grey))
    z = _clipped_is_no_news(z, registration, image)
    reached = float(np.mean(np.isfinite(z[golden.valid])))
    if reached < LEAST_SEEN:
        raise InputError(f"{name}: it shows only {100.0 * reached:.0f} % of what is judged; move the camera")
    classed = [replace(f, defect_class=_class_of(limits, f)) for f in find(golden, z)]
    findings = tuple(finding for finding in classed if finding.defect_class is not None)
    zones = {zone: _verdict(limits, [f for f in findings if f.zone == zone]) for zone in golden.zones}
    verdict = _verdict(limits, [f for f in findings if f.zone not in zones])
    if "reject" in zones.values():
        verdict = "reject"
    return Comparison(verdict, zones, findings, registration, z, image)


def _registered(golden: GoldenImage, image: CameraImage, name: str) -> Registration:
    try:
        found = register(np.nan_to_num(golden.mean), image.grey, golden.valid)
    except InputError as error:
        raise InputError(f"{name}: {str(error).removeprefix('image: ')}") from error
    if max(np.abs(found.shift_px)) > MOST_SHIFT * min(golden.size):
        right, down = found.shift_px
        raise InputError(f"{name}: it is shifted by {right:.0f}, {down:.0f} pixels; too far to be judged, align it")
    return found


def _clipped_is_no_news(z: np.ndarray, found: Registration, image: CameraImage) -> np.ndarray:
    """Return the z-map without dark departures of clipped pixels, which are brighter than they say."""
    clipped = found.resampled(image.saturated.astype(np.float64)) > 0.5 / found.gain
    return np.where(clipped & (z < 0.0), 0.0, z)


def _class_of(limits: Limits, finding: Finding) -> str | None:
    """Return the class by size; where the scale is not known, everything found is minor."""
    return "minor" if finding.size_mm is None else limits.class_of(finding.zone, finding.size_mm)


def _verdict(limits: Limits, findings: list[Finding]) -> str:
    classes = [finding.defect_class for finding in findings]
    bad = any(name in limits.reject for name in classes) or classes.count("minor") > limits.most_minor
    return "reject" if bad else "accept"
