"""Many ellipsoids as one body: a field of bubbles, the grains of a batch stone."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene.touching import touching_pairs
from glassworkbench.scene.validate import finite_array

NAMED_PAIRS = 3
"""As many pairs that touch are named in a message; the others are counted."""


@dataclass(frozen=True, eq=False)
class Ellipsoids:
    """Ellipsoids that do not touch each other, as one body. They may touch and cross other bodies.

    Parameters
    ----------
    centres_mm : array (n, 3)
        One at least.
    semi_axes_mm : array (n, 3)
    rotations : array (n, 3, 3), optional
        Of each, columns are the directions of its semi-axes, orthonormal; along x, y, z where not given.

    Raises
    ------
    InputError
        If there is none, a semi-axis is not above 0, a rotation is none, or two ellipsoids touch; they are named by
        their numbers, counted from 1.
    """

    centres_mm: np.ndarray
    semi_axes_mm: np.ndarray
    rotations: np.ndarray | None = field(default=None)

    def __post_init__(self) -> None:
        centres = finite_array(self.centres_mm, (None, 3), "centres_mm")
        count = len(centres)
        if count == 0:
            raise InputError("ellipsoids: there is none; leave the body away")
        semi_axes = finite_array(self.semi_axes_mm, (count, 3), "semi_axes_mm")
        if np.any(semi_axes <= 0.0):
            number = int(np.flatnonzero(np.any(semi_axes <= 0.0, axis=1))[0])
            raise InputError(
                f"semi_axes_mm: must be above 0, got {semi_axes[number].min():g} of ellipsoid {number + 1}"
            )
        turned = np.tile(np.eye(3), (count, 1, 1)) if self.rotations is None else self.rotations
        rotations = finite_array(turned, (count, 3, 3), "rotations")
        if np.abs(rotations.swapaxes(1, 2) @ rotations - np.eye(3)).max() > 1e-9:
            raise InputError("rotations: the columns of each must be orthonormal")
        object.__setattr__(self, "centres_mm", centres)
        object.__setattr__(self, "semi_axes_mm", semi_axes)
        object.__setattr__(self, "rotations", rotations)
        self._check_apart()

    def reaches_mm(self) -> np.ndarray:
        """Return how far each ellipsoid reaches from its centre along x, y and z, (n, 3)."""
        return np.linalg.norm(self.rotations * self.semi_axes_mm[:, None, :], axis=2)

    def _check_apart(self) -> None:
        pairs = touching_pairs(self.centres_mm, self.semi_axes_mm, self.rotations)
        if len(pairs) == 0:
            return
        named = ", ".join(f"{a + 1} and {b + 1}" for a, b in pairs[:NAMED_PAIRS])
        others = f" and {len(pairs) - NAMED_PAIRS} more pairs" if len(pairs) > NAMED_PAIRS else ""
        place = ", ".join(f"{coordinate:.4g}" for coordinate in self.centres_mm[pairs[0, 0]])
        raise InputError(f"ellipsoids {named}{others} touch or overlap (the first lies at {place} mm); move them apart")
