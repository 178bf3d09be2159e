"""The CIE 1931 2-degree standard observer under an illuminant, from the tables in resources/colour."""

from __future__ import annotations

from functools import cache

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.settings import RESOURCES, unknown_name

ILLUMINANTS = ("D65", "A", "E")
"""Daylight, incandescent light, and equal energy."""

WAVELENGTHS_NM = np.arange(380.0, 780.1, 5.0)
"""Where spectra are sampled for their colour."""
WAVELENGTHS_NM.setflags(write=False)


def illuminant(name: str) -> np.ndarray:
    """Return the relative spectral power of an illuminant at `WAVELENGTHS_NM`, 100 at 560 nm.

    Raises
    ------
    InputError
        If it is none of `ILLUMINANTS`.
    """
    if name not in ILLUMINANTS:
        raise unknown_name("illuminant", name, ILLUMINANTS)
    if name == "D65":
        return _table()[:, 4]
    if name == "E":
        return np.full(len(WAVELENGTHS_NM), 100.0)
    # CIE 15:2018, equation 4.1: Planck's law at 2848 K with the constant c2 of 1948.
    constant, kelvin = 1.435e7, 2848.0
    planck = np.expm1(constant / (kelvin * 560.0)) / np.expm1(constant / (kelvin * WAVELENGTHS_NM))
    return 100.0 * (560.0 / WAVELENGTHS_NM) ** 5 * planck


def tristimulus(
    transmittance: np.ndarray, light: str = "D65", wavelengths_nm: np.ndarray = WAVELENGTHS_NM
) -> np.ndarray:
    """Return X, Y, Z of light that was transmitted (or reflected).

    Parameters
    ----------
    transmittance : array (..., n)
    light : str
        One of `ILLUMINANTS`.
    wavelengths_nm : array (n,)
        Those of `WAVELENGTHS_NM` at which it is known; the others are left out of the light, too.

    Returns
    -------
    array (..., 3)
        Y is the luminous transmittance, 1 where everything passes.

    Raises
    ------
    InputError
        If the transmittance has another number of wavelengths, or the illuminant is not known.
    """
    transmittance = np.asarray(transmittance, dtype=np.float64)
    if transmittance.shape[-1:] != wavelengths_nm.shape:
        raise InputError(f"transmittance: expected {len(wavelengths_nm)} wavelengths, got {transmittance.shape}")
    weights = (illuminant(light)[:, None] * _table()[:, 1:4])[np.isin(WAVELENGTHS_NM, wavelengths_nm)]
    return transmittance @ (weights / weights[:, 1].sum())


def white(light: str = "D65", wavelengths_nm: np.ndarray = WAVELENGTHS_NM) -> np.ndarray:
    """Return X, Y, Z (3,) of the illuminant itself, of some of its wavelengths, Y = 1."""
    return tristimulus(np.ones(len(wavelengths_nm)), light, wavelengths_nm)


@cache
def _table() -> np.ndarray:
    """Return the wavelength in nm, the colour matching functions, and D65, (81, 5)."""
    table = np.loadtxt(RESOURCES / "colour" / "cie_1931.csv", delimiter=",", skiprows=3)
    table.setflags(write=False)
    return table
