"""The thickness asked at each point of one particular mold's outside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from glassworkbench.wall.bore import Bore
from glassworkbench.wall.thickness import ThicknessOverHeight


@dataclass(frozen=True, eq=False)
class AskedThickness:
    """A thickness as data, applied to a mold.

    Parameters
    ----------
    at : callable
        Takes points of the outside (n, 3), upright, in mm, and the 1-based numbers (n,) of the CAD faces they lie on (0
        where there is none); returns the thickness (n,), mm. A bore is in it: see `bore.Bore`.
    minimum_mm, maximum_mm : float
        The range of what is asked anywhere.
    over_height : ThicknessOverHeight or None
        The same as a function of the height alone, where it is one; a bore is not in it.
    bore : Bore or None
        The cylinder prescribed for the inside of the finish, whatever the thickness there.
    """

    at: Callable[[np.ndarray, np.ndarray], np.ndarray]
    minimum_mm: float
    maximum_mm: float
    over_height: ThicknessOverHeight | None = None
    bore: Bore | None = None

    @property
    def bore_radius_mm(self) -> float | None:
        """The radius prescribed for the inside of the finish."""
        return None if self.bore is None else self.bore.radius_mm
