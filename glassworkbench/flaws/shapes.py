"""Containers that do not stand as they should: lean and ovality."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.flaws.defect import InShape


@dataclass(frozen=True, kw_only=True)
class Lean(InShape):
    """A container that leans to one side: every level is shifted in proportion to its height.

    Parameters
    ----------
    angle_deg : float
        Towards which side.
    lean_deg : float
        Of its axis from the vertical.
    """

    kind: ClassVar[str] = "lean"
    description: ClassVar[str] = "the axis is not upright"
    usual_severity: ClassVar[str] = "major"

    MOST_DEG: ClassVar[float] = 20.0

    lean_deg: float = 0.5

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("lean_deg")
        if self.lean_deg > self.MOST_DEG:
            raise InputError(f"{self.kind}: lean_deg: must be at most {self.MOST_DEG:g}, got {self.lean_deg:g}")

    def deformation(self, radius_mm: float) -> np.ndarray:
        """Return a shear."""
        angle = np.radians(self.angle_deg)
        matrix = np.eye(3)
        matrix[:2, 2] = np.tan(np.radians(self.lean_deg)) * np.array([np.cos(angle), np.sin(angle)])
        return matrix


@dataclass(frozen=True, kw_only=True)
class Ovality(InShape):
    """A container that is not round.

    Parameters
    ----------
    angle_deg : float
        Of the largest diameter.
    out_of_round_mm : float
        The largest diameter less the smallest, at the widest place.
    """

    kind: ClassVar[str] = "ovality"
    description: ClassVar[str] = "the container is not round"

    MOST_SHARE: ClassVar[float] = 0.2

    out_of_round_mm: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_positive("out_of_round_mm")

    def deformation(self, radius_mm: float) -> np.ndarray:
        """Return a stretch along one direction and as much shrinking across."""
        share = 0.25 * self.out_of_round_mm / radius_mm
        if share > self.MOST_SHARE:
            raise InputError(f"{self}: {self.out_of_round_mm:g} mm is too much for a radius of {radius_mm:.4g} mm")
        angle = np.radians(self.angle_deg)
        turn = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
        return turn @ np.diag([1.0 + share, 1.0 - share, 1.0]) @ turn.T
