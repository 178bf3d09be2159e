"""Closed bodies: a name and the surface that bounds it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene.ellipsoids import Ellipsoids
from glassworkbench.scene.mesh import Mesh
from glassworkbench.scene.patches import Patches
from glassworkbench.scene.validate import finite_array, positive, unit_vector

JOINT_TOLERANCE = 1e-9
"""Largest gap between neighbouring meridian segments that is closed silently, relative to the meridian's size."""


@dataclass(frozen=True, eq=False)
class Revolved:
    """A meridian of rational cubic Bezier segments, turned about an axis.

    Parameters
    ----------
    meridian : array (n, 4, 3)
        Per segment four control points (r mm, z mm, weight). The chain either starts and ends on the axis
        (r = 0) or closes on itself; lines and quadratic arcs are stored degree-elevated, which is exact.
        It is stored so that the body lies to the left of the direction of travel (from the lower end on the
        axis, up the outside), whatever direction it is given in.
    base_mm : array (3,)
        The point of the axis where z = 0.
    axis : array (3,)
        The direction of growing z.

    Raises
    ------
    InputError
        If a control point is not finite or lies at r < 0, a weight is not positive, the chain has a gap,
        or it encloses no area.
    """

    meridian: np.ndarray
    base_mm: np.ndarray = field(default=(0.0, 0.0, 0.0))
    axis: np.ndarray = field(default=(0.0, 0.0, 1.0))

    def __post_init__(self) -> None:
        meridian = np.array(finite_array(self.meridian, (None, 4, 3), "meridian"))
        object.__setattr__(self, "base_mm", finite_array(self.base_mm, (3,), "base_mm"))
        object.__setattr__(self, "axis", unit_vector(self.axis, "axis"))
        object.__setattr__(self, "meridian", _closed_chain(meridian))


def _closed_chain(meridian: np.ndarray) -> np.ndarray:
    """Return the chain with joints made identical, axis ends at r = 0 exactly, and the body to its left."""
    if len(meridian) == 0:
        raise InputError("meridian: it has no segments")
    if np.any(meridian[:, :, 2] <= 0.0):
        raise InputError("meridian: every weight must be above 0")
    size = float(np.max(np.abs(meridian[:, :, :2])))
    tolerance = JOINT_TOLERANCE * max(size, 1e-300)
    if np.any(meridian[:, :, 0] < -tolerance):
        raise InputError(f"meridian: a control point lies at r = {meridian[:, :, 0].min():g} mm, left of the axis")
    meridian[:, :, 0] = np.maximum(meridian[:, :, 0], 0.0)

    extent = np.ptp(meridian[:, :, :2], axis=1).max(axis=1)
    on_axis = np.all(meridian[:, :, 0] <= tolerance, axis=1)
    meridian = meridian[(extent > 0.0) & ~on_axis]
    if len(meridian) == 0:
        raise InputError("meridian: it has no segment off the axis")

    gaps = np.abs(meridian[1:, 0, :2] - meridian[:-1, 3, :2]).max(axis=1, initial=0.0)
    if np.any(gaps > tolerance):
        worst = int(np.argmax(gaps))
        raise InputError(
            f"meridian: a gap of {gaps[worst]:.3g} mm between segments {worst + 1} and {worst + 2}; close the profile"
        )
    meridian[1:, 0, :2] = meridian[:-1, 3, :2]

    ends = meridian[0, 0, :2], meridian[-1, 3, :2]
    if all(end[0] <= tolerance for end in ends):
        meridian[0, 0, 0] = meridian[-1, 3, 0] = 0.0
    elif np.abs(ends[0] - ends[1]).max() <= tolerance:
        meridian[-1, 3, :2] = meridian[0, 0, :2]
    else:
        raise InputError(
            f"meridian: open, it starts at r, z = ({ends[0][0]:g}, {ends[0][1]:g}) mm and ends at "
            f"({ends[1][0]:g}, {ends[1][1]:g}) mm; both ends must lie on the axis, or coincide"
        )

    area = _signed_area(meridian)
    if abs(area) <= (tolerance * size):
        raise InputError("meridian: it encloses no area")
    if area < 0.0:
        meridian = meridian[::-1, ::-1]
    meridian = np.ascontiguousarray(meridian)
    meridian.setflags(write=False)
    return meridian


def _signed_area(meridian: np.ndarray) -> float:
    """Return the area (mm^2) between the chain and the axis, positive if the body lies to the left of travel."""
    u = np.linspace(0.0, 1.0, 33)
    basis = np.stack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
    weights = meridian[:, :, 2] @ basis
    r = (meridian[:, :, 0] * meridian[:, :, 2]) @ basis / weights
    z = (meridian[:, :, 1] * meridian[:, :, 2]) @ basis / weights
    r, z = r.ravel(), z.ravel()
    return float(0.5 * np.sum(r * np.roll(z, -1) - np.roll(r, -1) * z))


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """An ellipsoid: a bubble, a stone, a lens.

    Parameters
    ----------
    centre_mm : array (3,)
    semi_axes_mm : array (3,)
    rotation : array (3, 3)
        Columns are the directions of the semi-axes, orthonormal.
    """

    centre_mm: np.ndarray
    semi_axes_mm: np.ndarray
    rotation: np.ndarray = field(default=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre_mm", finite_array(self.centre_mm, (3,), "centre_mm"))
        semi_axes = finite_array(self.semi_axes_mm, (3,), "semi_axes_mm")
        for length in semi_axes:
            positive(length, "semi_axes_mm")
        object.__setattr__(self, "semi_axes_mm", semi_axes)
        rotation = finite_array(self.rotation, (3, 3), "rotation")
        if np.abs(rotation.T @ rotation - np.eye(3)).max() > 1e-9:
            raise InputError("rotation: its columns must be orthonormal")
        object.__setattr__(self, "rotation", rotation)


Surface = Revolved | Mesh | Ellipsoid | Ellipsoids | Patches


@dataclass(frozen=True, eq=False)
class Body:
    """A closed body with the name that media refer to."""

    name: str
    surface: Surface

    def __post_init__(self) -> None:
        if not self.name.isidentifier() or self.name in ("and", "or", "not"):
            raise InputError(f"body name {self.name!r}: use letters, digits and underscores, like outer or bubble_1")


@dataclass(frozen=True, eq=False)
class ContainerGeometry:
    """What a station needs to know of a container: standing upright, axis on z, lowest point at z = 0.

    The cavity reaches past the mouth on purpose: glass is `outer and not cavity`, so no two faces coincide there.

    Parameters
    ----------
    outer : Surface
    cavity : Surface or None
        None where the outer surface bounds the glass all around, inside too: nothing then says what it could hold.
    low_mm, high_mm : array (3,)
        Corners of the outer surface's bounding box.
    finish_height_mm : float
        Height of the sealing surface.
    notes : tuple of str
        What is not as exact as it could be, in sentences; a station passes them on with the image.
    """

    outer: Surface
    cavity: Surface | None
    low_mm: np.ndarray
    high_mm: np.ndarray
    finish_height_mm: float
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "low_mm", finite_array(self.low_mm, (3,), "low_mm"))
        object.__setattr__(self, "high_mm", finite_array(self.high_mm, (3,), "high_mm"))
        if np.any(self.high_mm <= self.low_mm):
            raise InputError("high_mm: each coordinate must lie above low_mm's")
        positive(self.finish_height_mm, "finish_height_mm")
