"""Absorption over the wavelength: a measured table, a recipe of chromophores, both together, or three broad bands."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.glass.checks import coefficients, not_negative, number, rising_nm, within
from glassworkbench.glass.chromophores import Chromophore
from glassworkbench.settings import unknown_name


@dataclass(frozen=True, eq=False)
class AbsorptionTable:
    """Measured Napierian absorption coefficients, linear in between.

    Parameters
    ----------
    wavelengths_nm, values_per_mm : array (n,)
        Wavelengths rise.
    """

    wavelengths_nm: np.ndarray
    values_per_mm: np.ndarray

    def __post_init__(self) -> None:
        wavelengths = rising_nm(self.wavelengths_nm, "wavelengths_nm")
        values = coefficients(self.values_per_mm, "absorption")
        if len(values) != len(wavelengths):
            raise InputError(f"absorption: {len(values)} values for {len(wavelengths)} wavelengths_nm")
        object.__setattr__(self, "wavelengths_nm", wavelengths)
        object.__setattr__(self, "values_per_mm", values)

    @property
    def range_nm(self) -> tuple[float, float]:
        """The first and the last wavelength."""
        return float(self.wavelengths_nm[0]), float(self.wavelengths_nm[-1])

    def per_mm(self, wavelengths_nm: np.ndarray) -> np.ndarray:
        """Return the absorption coefficient (1/mm); InputError outside `range_nm`."""
        return np.interp(within(wavelengths_nm, self.range_nm, "absorption"), self.wavelengths_nm, self.values_per_mm)


@dataclass(frozen=True, eq=False)
class Recipe:
    """The sum over the chromophores that amounts of colourants bring.

    Parameters
    ----------
    amounts : dict of str to float
        By colourant: percentages by weight, or the colourant's own unit.
    chromophores : tuple of Chromophore
        All that are known; the recipe takes those of its colourants.
    density_g_per_cm3 : float
    redox : float, optional
        Share of the element that is reduced (Fe²⁺ of all iron), 0 to 1.
    """

    amounts: dict[str, float]
    chromophores: tuple[Chromophore, ...]
    density_g_per_cm3: float
    redox: float | None = None

    def __post_init__(self) -> None:
        known = dict.fromkeys(chromophore.colourant for chromophore in self.chromophores)
        for colourant in self.amounts:
            if colourant not in known:
                raise unknown_name("colourants:", colourant, known)
        amounts = {name: not_negative(value, f"colourants: {name}") for name, value in self.amounts.items()}
        used = tuple(chromophore for chromophore in self.chromophores if chromophore.colourant in amounts)
        for chromophore in used:
            amount, most = amounts[chromophore.colourant], chromophore.most
            if amount > most:
                raise InputError(f"colourants: {chromophore.colourant}: must be at most {most:g}, got {amount:g}")
        if self.redox is not None and not 0.0 <= number(self.redox, "redox") <= 1.0:
            raise InputError(f"redox: must lie between 0 (all oxidised) and 1 (all reduced), got {self.redox:g}")
        parted = [chromophore.colourant for chromophore in used if chromophore.share]
        if parted and self.redox is None:
            raise InputError(f"redox: is missing, the reduced share of {parted[0]} from 0 to 1, as redox = 0.25")
        object.__setattr__(self, "amounts", amounts)
        object.__setattr__(self, "chromophores", used)

    @property
    def range_nm(self) -> tuple[float, float]:
        """Where all chromophores are known."""
        return _common(*(chromophore.range_nm for chromophore in self.chromophores))

    def per_mm(self, wavelengths_nm: np.ndarray) -> np.ndarray:
        """Return the absorption coefficient (1/mm); InputError outside `range_nm`."""
        wavelengths = within(wavelengths_nm, self.range_nm, "absorption")
        total = np.zeros_like(wavelengths)
        for chromophore in self.chromophores:
            share = {None: 1.0, "reduced": self.redox, "oxidised": 1.0 - (self.redox or 0.0)}[chromophore.share]
            amount = share * self.amounts[chromophore.colourant]
            total = total + chromophore.per_mm(wavelengths, amount, self.density_g_per_cm3)
        return total

    def changed(self, amounts: dict[str, float], redox: float | None, known: tuple[Chromophore, ...]) -> Recipe:
        """Return the recipe with other amounts, or another redox state, by its own and all `known` chromophores."""
        chromophores = tuple(dict.fromkeys((*self.chromophores, *known)))
        redox = self.redox if redox is None else redox
        return replace(self, amounts=self.amounts | amounts, chromophores=chromophores, redox=redox)


@dataclass(frozen=True, eq=False)
class AbsorptionSum:
    """Several of them together.

    Parameters
    ----------
    parts : tuple of AbsorptionTable and Recipe
    """

    parts: tuple[AbsorptionTable | Recipe, ...]

    @property
    def range_nm(self) -> tuple[float, float]:
        """Where all parts are known."""
        return _common(*(part.range_nm for part in self.parts))

    def per_mm(self, wavelengths_nm: np.ndarray) -> np.ndarray:
        """Return the absorption coefficient (1/mm); InputError outside `range_nm`."""
        return sum(part.per_mm(wavelengths_nm) for part in self.parts)


@dataclass(frozen=True, eq=False)
class ThreeBands:
    """One coefficient each for red, green and blue, where no spectrum is known.

    Parameters
    ----------
    red_green_blue_per_mm : array (3,)
        Napierian.
    """

    red_green_blue_per_mm: np.ndarray

    range_nm = (380.0, 780.0)
    EDGES_NM = (490.0, 580.0)
    """Between blue and green, between green and red."""

    def __post_init__(self) -> None:
        values = coefficients(self.red_green_blue_per_mm, "absorption_per_mm")
        if len(values) != 3:
            raise InputError(f"absorption_per_mm: must be three numbers (R, G, B), got {len(values)}")
        object.__setattr__(self, "red_green_blue_per_mm", values)

    def per_mm(self, wavelengths_nm: np.ndarray) -> np.ndarray:
        """Return the absorption coefficient (1/mm); InputError outside `range_nm`."""
        wavelengths = within(wavelengths_nm, self.range_nm, "absorption")
        return self.red_green_blue_per_mm[2 - np.digitize(wavelengths, self.EDGES_NM)]


Absorption = AbsorptionTable | Recipe | AbsorptionSum | ThreeBands


def _common(*ranges: tuple[float, float]) -> tuple[float, float]:
    """Return where all ranges overlap; with none, the whole range where glass is looked at."""
    if not ranges:
        return 290.0, 2500.0
    low, high = max(low for low, _ in ranges), min(high for _, high in ranges)
    if low >= high:
        raise InputError("absorption: its parts are known in ranges of wavelengths that do not overlap")
    return low, high
