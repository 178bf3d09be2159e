"""The refractive index over the wavelength, by the formulas in which it is published.

Wavelengths are those in air; inside the formulas they are in micrometres, as publications have them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.glass.checks import number, range_nm, rising_nm, within

DENSEST = 5.0
"""No transparent material has a higher refractive index than this."""


class Dispersion(Protocol):
    """What every formula offers."""

    range_nm: tuple[float, float]
    source: str

    def refractive_index(self, wavelengths_nm: np.ndarray) -> np.ndarray:
        """Return the index at wavelengths; InputError outside `range_nm`."""


@dataclass(frozen=True)
class Sellmeier:
    """n² = 1 + Σ B λ² / (λ² − C).

    Parameters
    ----------
    terms : tuple of (B, C)
        C in µm².
    range_nm : (float, float)
        Where the formula holds.
    source : str
    """

    terms: tuple[tuple[float, float], ...]
    range_nm: tuple[float, float]
    source: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "terms", _pairs(self.terms))
        object.__setattr__(self, "range_nm", range_nm(self.range_nm, "range_nm"))
        _check(self)

    def refractive_index(self, wavelengths_nm: np.ndarray) -> np.ndarray:
        """Return the index at wavelengths; InputError outside `range_nm`."""
        square = (1e-3 * within(wavelengths_nm, self.range_nm, "refractive index")) ** 2
        return np.sqrt(1.0 + sum(b * square / (square - c) for b, c in self.terms))


@dataclass(frozen=True)
class PowerSum:
    """n = Σ a λ^p: Cauchy's formula (p = 0, −2, −4, …), and Rubin's for soda-lime glass (p = 0, 2, −2).

    Parameters
    ----------
    terms : tuple of (p, a)
    range_nm : (float, float)
        Where the formula holds.
    source : str
    """

    terms: tuple[tuple[float, float], ...]
    range_nm: tuple[float, float]
    source: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "terms", _pairs(self.terms))
        object.__setattr__(self, "range_nm", range_nm(self.range_nm, "range_nm"))
        _check(self)

    def refractive_index(self, wavelengths_nm: np.ndarray) -> np.ndarray:
        """Return the index at wavelengths; InputError outside `range_nm`."""
        micrometres = 1e-3 * within(wavelengths_nm, self.range_nm, "refractive index")
        return sum((a * micrometres**p for p, a in self.terms), np.zeros_like(micrometres))


@dataclass(frozen=True, eq=False)
class IndexTable:
    """Measured values, linear in between.

    Parameters
    ----------
    wavelengths_nm, values : array (n,)
        Wavelengths rise; values are at least 1.
    source : str
    """

    wavelengths_nm: np.ndarray
    values: np.ndarray
    source: str = ""

    def __post_init__(self) -> None:
        wavelengths = rising_nm(self.wavelengths_nm, "wavelengths_nm")
        values = np.array([number(value, "refractive_index") for value in self.values])
        if len(values) != len(wavelengths):
            raise InputError(f"refractive_index: {len(values)} values for {len(wavelengths)} wavelengths_nm")
        object.__setattr__(self, "wavelengths_nm", wavelengths)
        object.__setattr__(self, "values", values)
        _check(self)

    @property
    def range_nm(self) -> tuple[float, float]:
        """The first and the last wavelength."""
        return float(self.wavelengths_nm[0]), float(self.wavelengths_nm[-1])

    def refractive_index(self, wavelengths_nm: np.ndarray) -> np.ndarray:
        """Return the index at wavelengths; InputError outside `range_nm`."""
        return np.interp(within(wavelengths_nm, self.range_nm, "refractive index"), self.wavelengths_nm, self.values)


@dataclass(frozen=True)
class ConstantIndex:
    """One index for all wavelengths, where the dispersion is not known.

    Parameters
    ----------
    value : float
    range_nm : (float, float)
    source : str
    """

    value: float
    range_nm: tuple[float, float] = (300.0, 2500.0)
    source: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", number(self.value, "refractive_index"))
        _check(self)

    def refractive_index(self, wavelengths_nm: np.ndarray) -> np.ndarray:
        """Return the index at wavelengths; InputError outside `range_nm`."""
        return np.full_like(within(wavelengths_nm, self.range_nm, "refractive index"), self.value)


@dataclass(frozen=True)
class ScaledDispersion:
    """The dispersion of a material that is alike, n − 1 scaled so that the index comes out where it was measured.

    For mixtures of which one index is known: wine and beer are nearly water.

    Parameters
    ----------
    of : Dispersion
    wavelength_nm, value : float
        Where the index was measured, and what it is there.
    source : str
    """

    of: Dispersion
    wavelength_nm: float
    value: float
    source: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "wavelength_nm", number(self.wavelength_nm, "wavelength_nm"))
        object.__setattr__(self, "value", number(self.value, "refractive_index"))
        _check(self)

    @property
    def range_nm(self) -> tuple[float, float]:
        """That of the material that is alike."""
        return self.of.range_nm

    def refractive_index(self, wavelengths_nm: np.ndarray) -> np.ndarray:
        """Return the index at wavelengths; InputError outside `range_nm`."""
        there = self.of.refractive_index(np.array(self.wavelength_nm))
        return 1.0 + (self.of.refractive_index(wavelengths_nm) - 1.0) * (self.value - 1.0) / (there - 1.0)


def _pairs(terms: object) -> tuple[tuple[float, float], ...]:
    try:
        pairs = tuple((first, second) for first, second in terms)
    except (TypeError, ValueError) as error:
        raise InputError(f"coefficients: must be pairs of numbers, as [[1.04, 0.006], …], got {terms!r}") from error
    if not pairs:
        raise InputError("coefficients: must be pairs of numbers, as [[1.04, 0.006], …], got none")
    return tuple((number(first, "coefficients"), number(second, "coefficients")) for first, second in pairs)


def _check(dispersion: Dispersion) -> None:
    """Raise InputError unless the index is one of a transparent material all over the range."""
    wavelengths = np.geomspace(*dispersion.range_nm, 500)[1:-1]
    with np.errstate(invalid="ignore", divide="ignore"):
        index = dispersion.refractive_index(wavelengths)
    wrong = ~((index >= 1.0) & (index <= DENSEST))
    if np.any(wrong):
        raise InputError(
            f"refractive_index: must lie between 1 and {DENSEST:g}, but is {index[wrong][0]:.4g} at "
            f"{wavelengths[wrong][0]:.4g} nm"
        )
