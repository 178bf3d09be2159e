"""What tracing a ray answers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Radiance:
    """What each of n rays saw, and how much of it may be missing.

    Parameters
    ----------
    radiance : array (n, 3)
        R, G, B in the units of the scene's lights.
    left_out : array (n, 3)
        Weight of the paths that were left out.
    bound : array (n,)
        Upper bound, per channel, of the radiance on the paths that were left out; the true radiance lies in
        [radiance, radiance + bound].
    depth_mm : array (n,)
        Distance along the ray to the first change of medium; infinite where there is none.
    crossings : int array (n,)
        Crossings of bodies' surfaces over all paths that the ray split into.
    leaks : int array (n,)
        Crossings that contradicted what the ray was inside of, and escapes from inside a body: 0 on sound bodies.
    """

    radiance: np.ndarray
    left_out: np.ndarray
    bound: np.ndarray
    depth_mm: np.ndarray
    crossings: np.ndarray
    leaks: np.ndarray


@dataclass(frozen=True, eq=False)
class Crossing:
    """One interface on a ray's path.

    Parameters
    ----------
    point_mm : array (3,)
    body : str
        The body whose surface it is.
    entering : bool
        Whether the ray enters that body.
    medium_before, medium_after : int
        0 for the surroundings, k + 1 for ``scene.media[k]``.
    cos_incidence : float
    reflectance : float
        Of unpolarised light; 1 at total internal reflection.
    """

    point_mm: np.ndarray
    body: str
    entering: bool
    medium_before: int
    medium_after: int
    cos_incidence: float
    reflectance: float
