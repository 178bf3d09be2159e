"""Glass that is unevenly distributed: thin spots, slugs, washboard, choked necks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from glassworkbench.flaws.defect import InThickness

SAMPLES = 17
"""Rows of a table over the extent of a defect."""


@dataclass(frozen=True, kw_only=True)
class _Spot(InThickness):
    length_mm: float
    width_mm: float

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("length_mm", "width_mm")

    def rows_mm(self) -> np.ndarray:
        """Return heights over its length."""
        return self.height_mm + 0.5 * self.length_mm * np.linspace(-1.0, 1.0, SAMPLES)

    def columns_deg(self, radius_mm: float) -> np.ndarray:
        """Return angles over its width."""
        return self.angle_deg + np.degrees(0.5 * self.width_mm / radius_mm) * np.linspace(-1.0, 1.0, SAMPLES)

    def _bump(self, height_mm: np.ndarray, angle_deg: np.ndarray, radius_mm: float) -> np.ndarray:
        """Return a smooth bump: 1 in the middle, 0 from the edge on."""
        turn = (angle_deg - self.angle_deg + 180.0) % 360.0 - 180.0
        return _bump(
            np.hypot((height_mm - self.height_mm) / self.length_mm, np.radians(turn) * radius_mm / self.width_mm)
        )


@dataclass(frozen=True, kw_only=True)
class ThinSpot(_Spot):
    """A place where the wall is thinner.

    Parameters
    ----------
    length_mm, width_mm : float
        Up along the wall, and around it.
    loss_mm : float
        How much thinner it is in the middle.
    """

    kind: ClassVar[str] = "thin spot"
    description: ClassVar[str] = "a place where the wall is thinner"
    usual_severity: ClassVar[str] = "major"

    length_mm: float = 40.0
    width_mm: float = 30.0
    loss_mm: float = 0.8

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("loss_mm")

    def added_mm(self, height_mm: np.ndarray, angle_deg: np.ndarray, radius_mm: float) -> np.ndarray:
        """Return what it takes away."""
        return -self.loss_mm * self._bump(height_mm, angle_deg, radius_mm)


@dataclass(frozen=True, kw_only=True)
class Slug(_Spot):
    """A place where the wall is thicker.

    Parameters
    ----------
    length_mm, width_mm : float
        Up along the wall, and around it.
    gain_mm : float
        How much thicker it is in the middle.
    """

    kind: ClassVar[str] = "slug"
    description: ClassVar[str] = "a place where the wall is thicker"

    length_mm: float = 40.0
    width_mm: float = 30.0
    gain_mm: float = 1.5

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("gain_mm")

    def added_mm(self, height_mm: np.ndarray, angle_deg: np.ndarray, radius_mm: float) -> np.ndarray:
        """Return what it adds."""
        return self.gain_mm * self._bump(height_mm, angle_deg, radius_mm)


@dataclass(frozen=True, kw_only=True)
class ChokedNeck(InThickness):
    """A bore that is too narrow at one height, all around.

    Parameters
    ----------
    length_mm : float
        Along the axis.
    gain_mm : float
        How much thicker the wall is in the middle of it: the bore is narrower by twice that.
    """

    kind: ClassVar[str] = "choked neck"
    description: ClassVar[str] = "a bore that is too narrow at one height, all around"
    usual_severity: ClassVar[str] = "critical"

    angle_deg: float = 0.0
    length_mm: float = 15.0
    gain_mm: float = 1.5

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("length_mm", "gain_mm")

    def added_mm(self, height_mm: np.ndarray, angle_deg: np.ndarray, radius_mm: float) -> np.ndarray:
        """Return what it adds."""
        return self.gain_mm * _bump(np.abs(height_mm - self.height_mm) / self.length_mm) + 0.0 * angle_deg

    def rows_mm(self) -> np.ndarray:
        """Return heights over its length."""
        return self.height_mm + 0.5 * self.length_mm * np.linspace(-1.0, 1.0, SAMPLES)


@dataclass(frozen=True, kw_only=True)
class Washboard(InThickness):
    """Waves one above the other on the inside, all around.

    Parameters
    ----------
    length_mm : float
        Of all waves together, along the axis.
    pitch_mm : float
        From crest to crest.
    amplitude_mm : float
        Of the thickness, from its mean.
    """

    kind: ClassVar[str] = "washboard"
    description: ClassVar[str] = "waves one above the other on the inside, all around"

    angle_deg: float = 0.0
    length_mm: float = 40.0
    pitch_mm: float = 5.0
    amplitude_mm: float = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("length_mm", "pitch_mm", "amplitude_mm")

    def added_mm(self, height_mm: np.ndarray, angle_deg: np.ndarray, radius_mm: float) -> np.ndarray:
        """Return waves that fade at both ends."""
        along = height_mm - self.height_mm
        waves = np.cos(2.0 * np.pi * along / self.pitch_mm) * _bump(np.abs(along) / self.length_mm)
        return self.amplitude_mm * waves + 0.0 * angle_deg

    def rows_mm(self) -> np.ndarray:
        """Return heights over its length, twelve to a wave."""
        count = int(np.ceil(12.0 * self.length_mm / self.pitch_mm))
        return self.height_mm + 0.5 * self.length_mm * np.linspace(-1.0, 1.0, count + 1)


def _bump(share: np.ndarray) -> np.ndarray:
    """Return 1 where `share` is 0, 0 from one half on, and a smooth step in between."""
    return np.where(share < 0.5, np.cos(np.pi * np.minimum(share, 0.5)) ** 2, 0.0)
