"""From a spectrum of absorption to three coefficients, for light that is traced as R, G and B."""

from __future__ import annotations

import numpy as np

from glassworkbench.colour import linear_srgb, tristimulus, white

FAINTEST = 0.05
"""The least that a channel passes where it is fitted: saturated colours of less are beyond sRGB."""


def fitted_per_mm(absorption_per_mm: np.ndarray, wavelengths_nm: np.ndarray, path_mm: float) -> np.ndarray:
    """Return the coefficients with which a path gets its true colour in daylight (D65).

    No three coefficients follow a spectrum over all paths: a thicker piece changes its hue, three exponentials
    do so differently. Here each agrees with the spectrum at one path: the one given, or, for a channel that passes
    less than `FAINTEST` there, the shorter one at which it passes so much.

    Parameters
    ----------
    absorption_per_mm, wavelengths_nm : array (n,)
        At those of `glassworkbench.colour.WAVELENGTHS_NM` at which it is known.
    path_mm : float

    Returns
    -------
    array (3,)
        Napierian, 1/mm, for linear R, G, B.
    """

    def passed(paths_mm: np.ndarray) -> np.ndarray:
        """Return what each channel passes, in linear sRGB, over its own path."""
        spectra = np.exp(-absorption_per_mm * paths_mm[:, None])
        channels = linear_srgb(tristimulus(spectra, wavelengths_nm=wavelengths_nm))
        return np.diagonal(channels) / linear_srgb(white(wavelengths_nm=wavelengths_nm))

    paths = np.full(3, path_mm)
    faint = passed(paths) < FAINTEST
    shortest, longest = np.zeros(3), paths
    for _ in range(60):
        middle = 0.5 * (shortest + longest)
        enough = passed(middle) >= FAINTEST
        shortest, longest = np.where(enough, middle, shortest), np.where(enough, longest, middle)
    paths = np.where(faint, longest, path_mm)
    # More than everything is what colours beyond sRGB seem to pass in a channel that they hardly absorb.
    return -np.log(np.minimum(passed(paths), 1.0)) / paths + 0.0
