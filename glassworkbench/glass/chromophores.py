"""What colours a glass or a liquid: ions and molecules with their absorption bands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.glass.checks import above_zero, not_negative, range_nm, text, within

STRONGEST = 1e6
"""No molecule absorbs more, in L/(mol cm)."""

SHARES = ("oxidised", "reduced")
"""Which part of its element a chromophore is, where the redox state decides."""


@dataclass(frozen=True)
class Band:
    """A band of Gaussian shape over the wavenumber.

    Parameters
    ----------
    centre_nm : float
    width_per_cm : float
        Full width at half the maximum, in wavenumbers (1/cm).
    strength : float
        At the centre; the chromophore tells its unit.
    """

    centre_nm: float
    width_per_cm: float
    strength: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre_nm", above_zero(self.centre_nm, "centre_nm"))
        object.__setattr__(self, "width_per_cm", above_zero(self.width_per_cm, "width_per_cm"))
        object.__setattr__(self, "strength", _strength(self.strength))

    def at(self, wavelengths_nm: np.ndarray) -> np.ndarray:
        """Return the band's strength at wavelengths in nm."""
        widths_off = (1e7 / wavelengths_nm - 1e7 / self.centre_nm) / self.width_per_cm
        return self.strength * np.exp(-4.0 * np.log(2.0) * widths_off**2)


@dataclass(frozen=True)
class Tail:
    """An absorption that falls exponentially with the wavelength, as that of browned sugar and malt.

    Parameters
    ----------
    at_nm : float
    decay_nm : float
        The wavelength over which it falls to 1/e.
    strength : float
        At `at_nm`; the chromophore tells its unit.
    """

    at_nm: float
    decay_nm: float
    strength: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "at_nm", above_zero(self.at_nm, "at_nm"))
        object.__setattr__(self, "decay_nm", above_zero(self.decay_nm, "decay_nm"))
        object.__setattr__(self, "strength", _strength(self.strength))

    def at(self, wavelengths_nm: np.ndarray) -> np.ndarray:
        """Return the strength at wavelengths in nm."""
        return self.strength * np.exp((self.at_nm - wavelengths_nm) / self.decay_nm)


@dataclass(frozen=True)
class Chromophore:
    """An absorbing ion or molecule: the sum of its bands and tails, times how much of it there is.

    Parameters
    ----------
    name : str
    colourant : str
        What a material's recipe calls the amount by, like ``Fe2O3``.
    parts : tuple of Band and Tail
        Their strengths are decadic: L/(mol cm) where there is a molar mass, else 1/cm for each unit of the colourant.
    range_nm : (float, float)
        Where the sum holds.
    molar_mass_g_per_mol : float, optional
        Of the colourant per mole of the absorber: the recipe's amount is a percentage by weight then.
    share : str, optional
        One of `SHARES`, where only this part of the colourant absorbs so.
    source, assumed : str
    """

    name: str
    colourant: str
    parts: tuple[Band | Tail, ...]
    range_nm: tuple[float, float]
    molar_mass_g_per_mol: float | None = None
    share: str | None = None
    source: str = ""
    assumed: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "range_nm", range_nm(self.range_nm, "range_nm"))
        text(self.colourant, "colourant")
        if not self.parts:
            raise InputError("bands, tails: a chromophore needs one of them at least")
        if self.molar_mass_g_per_mol is not None:
            mass = above_zero(self.molar_mass_g_per_mol, "molar_mass_g_per_mol")
            if mass < 1.0:
                raise InputError(f"molar_mass_g_per_mol: no colourant is lighter than hydrogen, got {mass:g}")
            object.__setattr__(self, "molar_mass_g_per_mol", mass)
        if self.share not in (None, *SHARES):
            raise InputError(f"share: must be {' or '.join(SHARES)}, got {self.share!r}")

    @property
    def most(self) -> float:
        """The largest amount that a recipe can ask: all of the weight, or a number beyond what anyone measures."""
        return 1e6 if self.molar_mass_g_per_mol is None else 100.0

    def per_mm(self, wavelengths_nm: np.ndarray, amount: float, density_g_per_cm3: float) -> np.ndarray:
        """Return the Napierian absorption coefficient (1/mm) of an amount of the chromophore itself.

        Parameters
        ----------
        wavelengths_nm : array
        amount : float
            A percentage by weight where there is a molar mass, else in units of the colourant.
        density_g_per_cm3 : float
            Of the whole material.

        Raises
        ------
        InputError
            For a wavelength outside `range_nm`.
        """
        wavelengths = within(wavelengths_nm, self.range_nm, f"absorption by {self.name}")
        # A percentage by weight of g/cm³ is 10 g/L.
        molar = 1.0 if self.molar_mass_g_per_mol is None else 10.0 * density_g_per_cm3 / self.molar_mass_g_per_mol
        decadic_per_cm = amount * molar * sum(part.at(wavelengths) for part in self.parts)
        return np.log(10.0) / 10.0 * decadic_per_cm


def _strength(value: float) -> float:
    strength = not_negative(value, "strength")
    if strength > STRONGEST:
        raise InputError(f"strength: must be at most {STRONGEST:g}, got {strength:g}")
    return strength
