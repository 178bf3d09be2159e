"""Glass inside the container: bird swings and spikes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.flaws.defect import InCavity, Site, Thread
from glassworkbench.scene import Revolved


@dataclass(frozen=True, kw_only=True)
class BirdSwing(InCavity):
    """A thread of glass across the inside, from wall to wall.

    Parameters
    ----------
    diameter_mm, root_diameter_mm : float
        In its middle, and where it meets the wall.
    to_angle_deg : float, optional
        Where its other end is; across, where not given.
    """

    kind: ClassVar[str] = "bird swing"
    description: ClassVar[str] = "a thread of glass across the inside, from wall to wall"
    usual_severity: ClassVar[str] = "critical"

    diameter_mm: float = 0.8
    root_diameter_mm: float = 3.0
    to_angle_deg: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("diameter_mm", "root_diameter_mm")
        if self.to_angle_deg is not None:
            object.__setattr__(self, "to_angle_deg", self._finite("to_angle_deg"))
            if abs((self.to_angle_deg - self.angle_deg + 180.0) % 360.0 - 180.0) < 10.0:
                raise InputError(
                    f"{self.kind}: to_angle_deg: it ends where it begins; let it end elsewhere in the wall"
                )

    @property
    def other_angle_deg(self) -> float:
        """The angle at which it ends."""
        return super().other_angle_deg if self.to_angle_deg is None else self.to_angle_deg

    def thread(self, site: Site, other: Site) -> Thread:
        """Return a thread that is thinnest in its middle and round at its ends, which lie in the middle of the wall."""
        start, end = site.at_depth_mm(None), other.at_depth_mm(None)
        length = float(np.linalg.norm(end - start))
        middle, root = 0.5 * self.diameter_mm, 0.5 * self.root_diameter_mm
        rows = [(0.0, 0.0), (root, 0.0), (root, 0.08), (middle, 0.12), (middle, 0.5)]
        half = np.array([(r, share * length) for r, share in rows])
        mirrored = half[::-1] * (1.0, -1.0) + (0.0, length)
        meridian = [
            _line(half[0], half[1]),
            _cubic(*half[1:]),
            _cubic(*mirrored[:-1]),
            _line(mirrored[-2], mirrored[-1]),
        ]
        axis = (end - start) / length
        return Thread(Revolved(np.array(meridian), start, axis), np.array([start, end]), root)


@dataclass(frozen=True, kw_only=True)
class Spike(InCavity):
    """A thorn of glass that stands on the inside.

    Parameters
    ----------
    length_mm : float
        From the inner surface to its tip.
    root_diameter_mm, tip_diameter_mm : float
        Where it meets the wall, and shortly before its round tip.
    """

    kind: ClassVar[str] = "spike"
    description: ClassVar[str] = "a thorn of glass on the inside"
    usual_severity: ClassVar[str] = "critical"

    length_mm: float = 8.0
    root_diameter_mm: float = 3.0
    tip_diameter_mm: float = 0.6

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("length_mm", "root_diameter_mm", "tip_diameter_mm")

    def thread(self, site: Site, other: Site) -> Thread:
        """Return a thorn with its root in the middle of the wall."""
        start, inward = site.at_depth_mm(None), -site.frame[:, 2]
        length = 0.5 * site.wall_mm + self.length_mm
        root, tip = 0.5 * self.root_diameter_mm, 0.5 * self.tip_diameter_mm
        neck = length - tip
        if neck <= 0.5 * length:
            raise InputError(f"{self}: tip_diameter_mm: a tip of {2.0 * tip:g} mm is too thick for its length")
        meridian = [
            _line((0.0, 0.0), (root, 0.0)),
            _cubic((root, 0.0), (root, 0.3 * neck), (tip, 0.4 * neck), (tip, neck)),
            _quarter_circle((0.0, neck), tip),
        ]
        return Thread(Revolved(np.array(meridian), start, inward), start[None], root)


def _line(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    return _cubic(*np.linspace(start, end, 4))


def _cubic(*points: np.ndarray) -> np.ndarray:
    return np.column_stack([points, np.ones(4)])


def _quarter_circle(centre: tuple[float, float], radius: float) -> np.ndarray:
    """Return the arc from the side of a circle to its top: a rational quadratic, degree-elevated."""
    (r, z), weight = centre, np.sqrt(0.5)
    first, middle, last = (
        weight_here * np.array([right, up, 1.0])
        for right, up, weight_here in ((r + radius, z, 1.0), (r + radius, z + radius, weight), (r, z + radius, 1.0))
    )
    elevated = np.array([first, (first + 2.0 * middle) / 3.0, (2.0 * middle + last) / 3.0, last])
    elevated[:, :2] /= elevated[:, 2:]
    return elevated
