"""A prescribed bore: in the finish the inside is a cylinder about the axis, whatever the outside does there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.mold import Mold, outside_mesh
from glassworkbench.mold.tessellation import MOUTH
from glassworkbench.wall.asking.interpolation import smooth_step
from glassworkbench.wall.asking.limits import THINNEST_MM

DEVIATION_MM = 0.2
"""Of the mesh that tells how wide the finish is; its sides are lifted onto the surface."""

LIP_RISING = 0.35
"""Where the outward normal rises by more than this, the surface closes over the bore: it is lip or shoulder."""

POINTS_PER_SIDE = 8
"""Points on each side of a triangle, lifted onto the surface, that tell how wide the finish is."""


@dataclass(frozen=True)
class Bore:
    """A bore in one particular mold.

    Parameters
    ----------
    radius_mm : float
    full_from_mm : float
        Above this height the inside is the cylinder: the lower end of the finish.
    none_below_mm : float
        Below this height the wall is as asked without a bore; in between the one becomes the other, smoothly.

    Notes
    -----
    An outer point at radius r that asks for the thickness r - R keeps a ball free whose nearest point to the axis is
    at radius R and at the same height. The balls of all outer points above a height therefore leave exactly the
    cylinder of radius R, also under rings and threads: to whoever offsets the outside, the bore is a thickness.
    """

    radius_mm: float
    full_from_mm: float
    none_below_mm: float

    def share(self, height_mm: np.ndarray) -> np.ndarray:
        """Return how far the bore decides at each height: 1 in the finish, 0 below the blend."""
        return smooth_step((height_mm - self.none_below_mm) / (self.full_from_mm - self.none_below_mm))

    def thickness(self, radius_mm: np.ndarray, height_mm: np.ndarray, wall_mm: np.ndarray) -> np.ndarray:
        """Return the thickness asked at outer points that ask for `wall_mm` where no bore is."""
        share = self.share(height_mm)
        return np.maximum(share * (radius_mm - self.radius_mm) + (1.0 - share) * wall_mm, THINNEST_MM)


def bore_in(mold: Mold, diameter_mm: float) -> Bore:
    """Return a bore as it lies in a mold.

    The cylinder reaches through the whole finish. Below, it blends into the wall over the finish's own height, but
    not beyond the region under it.

    Raises
    ------
    InputError
        If the finish is no wider than the bore.
    """
    width = 2.0 * mold.anatomy.finish_outer_radius_mm
    if diameter_mm >= width:
        raise InputError(
            f"wall bore: {diameter_mm:g} mm leaves no glass in the finish, which is only {width:.4g} mm wide outside; "
            "ask for a narrower bore"
        )
    regions = mold.anatomy.regions
    low, high = regions["finish"]
    below = max((region for region in regions.values() if region[1] <= low), default=(0.0, low))
    return Bore(0.5 * diameter_mm, low, max(low - (high - low), below[0]))


def check_fits(bore: Bore, points_mm: np.ndarray, thickness_mm: np.ndarray) -> None:
    """Check that a bore leaves glass everywhere, with the thickness (n,) asked at points (n, 3) around it.

    Raises
    ------
    InputError
        If the outside is not wider than the bore somewhere.
    """
    thinnest = int(np.argmin(thickness_mm))
    if thickness_mm[thinnest] <= THINNEST_MM:
        width = 2.0 * np.hypot(*points_mm[thinnest, :2])
        raise InputError(
            f"wall bore: {2.0 * bore.radius_mm:g} mm leaves no glass at height {points_mm[thinnest, 2]:.1f} mm, where "
            f"the outside is {width:.2f} mm wide; ask for a narrower bore"
        )


def points_around(bore: Bore, mold: Mold) -> tuple[np.ndarray, np.ndarray]:
    """Return outer points that a bore concerns, where the outside does not close over it.

    Returns
    -------
    points_mm : array (n, 3)
        In the finish and the blend; the lip's rounding is left out.
    faces : int array (n,)
        Numbers of the CAD faces they lie on, 0 without.
    """
    low = bore.none_below_mm
    mesh, numbers = outside_mesh(mold, DEVIATION_MM)
    glass = ~np.isin(numbers, (mold.anatomy.finish_face, MOUTH)) | (numbers == 0)
    reaching = mesh.vertices_mm[mesh.triangles][:, :, 2].max(axis=1) >= low
    triangles, numbers = mesh.triangles[glass & reaching], np.maximum(numbers[glass & reaching], 0)
    starts, ends = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    p, q, n, m = mesh.vertices_mm[starts], mesh.vertices_mm[ends], mesh.normals[starts], mesh.normals[ends]
    upright = np.maximum(n[:, 2], m[:, 2]) < LIP_RISING
    p, q, n, m, faces = p[upright], q[upright], n[upright], m[upright], np.repeat(numbers, 3)[upright]
    # The point of each side nearest to the axis, and some more, each as far above the chord as the normals turn.
    along = (q - p)[:, :2]
    nearest = -np.einsum("ij,ij->i", p[:, :2], along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    shares = np.column_stack([np.tile(np.linspace(0.0, 1.0, POINTS_PER_SIDE), (len(p), 1)), np.clip(nearest, 0.0, 1.0)])
    sag = 0.5 * np.einsum("ij,ij->i", m - n, q - p)[:, None] * shares * (1.0 - shares)
    share, sag = shares[:, :, None], sag[:, :, None]
    points = (1.0 - share) * p[:, None] + share * q[:, None]
    normals = (1.0 - share) * n[:, None] + share * m[:, None]
    points = (points + sag * normals).reshape(-1, 3)
    faces = np.repeat(faces, shares.shape[1])
    above = points[:, 2] >= low
    return points[above], faces[above]
