"""The thickness asked of one particular mold, where it depends on the height alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.wall.asking.interpolation import monotone_cubic


@dataclass(frozen=True, eq=False)
class ThicknessOverHeight:
    """The thickness asked at each height of one particular mold.

    Parameters
    ----------
    heights_mm, thicknesses_mm : array (n,)
        Heights above the lowest point, ascending, n >= 1; the end values hold beyond the ends.
    interpolation : {"smooth", "linear"}
        Smooth is monotone and piecewise cubic.
    underside_mm : float, optional
        Thickness of the base inside the ring it stands on, where that differs from what the height says: a
        push-up rises to heights that belong to the heel.
    """

    heights_mm: np.ndarray
    thicknesses_mm: np.ndarray
    interpolation: str = "smooth"
    underside_mm: float | None = None

    @property
    def uniform_mm(self) -> float | None:
        """The thickness, if it is the same everywhere."""
        values = set(map(float, self.thicknesses_mm))
        if self.underside_mm is not None:
            values.add(self.underside_mm)
        return values.pop() if len(values) == 1 else None

    @property
    def minimum_mm(self) -> float:
        """The smallest thickness asked anywhere."""
        return float(min(self.thicknesses_mm.min(), np.inf if self.underside_mm is None else self.underside_mm))

    @property
    def maximum_mm(self) -> float:
        """The largest thickness asked anywhere."""
        return float(max(self.thicknesses_mm.max(), -np.inf if self.underside_mm is None else self.underside_mm))

    def at(self, height_mm: np.ndarray, underside: np.ndarray | bool = False) -> np.ndarray:
        """Return the thickness (mm) at heights of any shape; `underside` marks points inside the standing ring."""
        thickness = self._interpolate(np.asarray(height_mm, dtype=np.float64), derivative=False)
        return thickness if self.underside_mm is None else np.where(underside, self.underside_mm, thickness)

    def slope(self, height_mm: np.ndarray, underside: np.ndarray | bool = False) -> np.ndarray:
        """Return the change of thickness per mm of height."""
        slope = self._interpolate(np.asarray(height_mm, dtype=np.float64), derivative=True)
        return slope if self.underside_mm is None else np.where(underside, 0.0, slope)

    def _interpolate(self, height_mm: np.ndarray, derivative: bool) -> np.ndarray:
        if len(self.heights_mm) == 1:
            return np.full(height_mm.shape, 0.0 if derivative else self.thicknesses_mm[0])
        if self.interpolation == "smooth":
            value, slope = monotone_cubic(self.heights_mm, self.thicknesses_mm, height_mm)
        else:
            value = np.interp(height_mm, self.heights_mm, self.thicknesses_mm)
            steps = np.diff(self.thicknesses_mm) / np.diff(self.heights_mm)
            row = np.clip(np.searchsorted(self.heights_mm, height_mm, side="right") - 1, 0, len(steps) - 1)
            beyond = (height_mm < self.heights_mm[0]) | (height_mm > self.heights_mm[-1])
            slope = np.where(beyond, 0.0, steps[row])
        return slope if derivative else value
