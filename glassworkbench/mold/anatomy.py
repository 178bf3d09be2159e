"""What stands where on a container: axis, base, finish, and the regions between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

REVOLVED_MM = 1e-3
"""Largest departure of a body that counts as revolved.

CAD programs write seams and sewn faces that are off by up to about 1e-4 mm, mold cavities are cut to about 1e-2 mm, and
a camera of an inspection line sees 1e-1 mm: a thousandth of a millimetre parts noise in the file from shape.
"""


@dataclass(frozen=True, eq=False)
class Anatomy:
    """Measures of a container; heights and radii are those of the upright container, in mm.

    Parameters
    ----------
    axis, base_point_mm : array (3,)
        Unit vector from base to finish; the point of the axis at the height of the lowest point. CAD coordinates.
    height_mm : float
    finish_height_mm : float
        Height of the sealing surface.
    finish_outer_radius_mm : float
        Largest radius in the finish region (ring or thread included).
    finish_face : int
        1-based number, in the solid, of the planar face that closes the mouth.
    maximum_radius_mm, smallest_width_mm : float
        Largest distance from the axis; smallest distance between two vertical planes that hold the body.
    bearing_radius_mm : float
        Radius of the circle that the container stands on; the base is inside it.
    push_up_mm : float
        Height of the base on the axis above the lowest point.
    departure_mm : float
        Largest distance, in the meridian half-plane, between the surface and the body of revolution at its core;
        where it has none, the largest difference of its radii at one height.
    departure_at_mm : array (3,)
        Where that is, upright.
    stem_top_mm : float
        Height where the stem opens into the bowl, below which the glass stays solid; 0 without a stem.
    regions : mapping of str to (float, float)
        Heights (low, high) of base, heel, body, shoulder, neck, finish (a stemmed glass: base, stem, body, finish).
    """

    axis: np.ndarray
    base_point_mm: np.ndarray
    height_mm: float
    finish_height_mm: float
    finish_outer_radius_mm: float
    finish_face: int
    maximum_radius_mm: float
    smallest_width_mm: float
    bearing_radius_mm: float
    push_up_mm: float
    departure_mm: float
    departure_at_mm: np.ndarray
    stem_top_mm: float
    regions: Mapping[str, tuple[float, float]]

    @property
    def is_revolved(self) -> bool:
        """Whether the body is one of revolution, so that its meridian says all."""
        return self.departure_mm < REVOLVED_MM
