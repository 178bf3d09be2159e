"""A homogeneous material: what it does to light of each wavelength, its density, and where the numbers come from."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from glassworkbench.colour import WAVELENGTHS_NM, tristimulus
from glassworkbench.errors import InputError
from glassworkbench.glass.absorption import Absorption, AbsorptionSum, Recipe, ThreeBands
from glassworkbench.glass.checks import above_zero
from glassworkbench.glass.chromophores import Chromophore
from glassworkbench.glass.dispersion import Dispersion
from glassworkbench.glass.rgb import fitted_per_mm

HELIUM_D_NM = 587.5618
"""The line at which glassmakers tell the refractive index."""

HYDROGEN_F_NM, HYDROGEN_C_NM = 486.1327, 656.2725


@dataclass(frozen=True, eq=False)
class _Material:
    name: str
    dispersion: Dispersion
    absorption: Absorption
    density_g_per_cm3: float
    description: str = ""
    source: str = ""
    assumed: str = ""

    usual_path_mm = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "density_g_per_cm3", above_zero(self.density_g_per_cm3, "density_g_per_cm3"))

    @property
    def range_nm(self) -> tuple[float, float]:
        """Shortest and longest wavelength at which both index and absorption are known."""
        (low, high), (first, last) = self.dispersion.range_nm, self.absorption.range_nm
        return max(low, first), min(high, last)

    def refractive_index(self, wavelengths_nm: np.ndarray | float) -> np.ndarray:
        """Return the refractive index against air at wavelengths in nm.

        Raises
        ------
        InputError
            For a wavelength at which the formula does not hold.
        """
        return self._named(self.dispersion.refractive_index, wavelengths_nm)

    @cached_property
    def refractive_index_d(self) -> float:
        """The refractive index at the helium d line, 587.6 nm."""
        return float(self.refractive_index(HELIUM_D_NM))

    @cached_property
    def abbe_number(self) -> float:
        """(n_d − 1) / (n_F − n_C), large where colours part little; infinite for a constant index."""
        blue, red = self.refractive_index(np.array([HYDROGEN_F_NM, HYDROGEN_C_NM]))
        return float(np.divide(self.refractive_index_d - 1.0, blue - red)) if blue != red else np.inf

    def absorption_per_mm(self, wavelengths_nm: np.ndarray | float) -> np.ndarray:
        """Return the Napierian absorption coefficient (1/mm) at wavelengths in nm.

        Raises
        ------
        InputError
            For a wavelength at which it is not known.
        """
        return self._named(self.absorption.per_mm, wavelengths_nm)

    def transmittance(self, wavelengths_nm: np.ndarray | float, path_mm: float) -> np.ndarray:
        """Return what of the light is left after a path inside (Beer-Lambert), without the faces' reflections."""
        return np.exp(-self.absorption_per_mm(wavelengths_nm) * path_mm)

    def plate_transmittance(self, wavelengths_nm: np.ndarray | float, thickness_mm: float) -> np.ndarray:
        """Return what a plate in air passes at normal incidence, all reflections between its faces counted."""
        index = self.refractive_index(wavelengths_nm)
        reflected = ((index - 1.0) / (index + 1.0)) ** 2
        inside = self.transmittance(wavelengths_nm, thickness_mm)
        return (1.0 - reflected) ** 2 * inside / (1.0 - (reflected * inside) ** 2)

    def colour(self, path_mm: float, light: str = "D65") -> np.ndarray:
        """Return X, Y, Z (3,) of what is left of an illuminant after a path inside; Y = 1 is everything."""
        return tristimulus(self.transmittance(WAVELENGTHS_NM, path_mm), light)

    def rgb_absorption_per_mm(self) -> np.ndarray:
        """Return one absorption coefficient (1/mm) each for linear R, G, B, (3,).

        They are those with which the usual path, two walls or the width of a bottle, gets its true colour: see
        `glassworkbench.glass.rgb.fitted_per_mm`. Coefficients that were given for R, G and B are returned as they are.
        """
        return self._rgb_per_mm.copy()

    def rgb_transmittance(self, path_mm: float) -> np.ndarray:
        """Return what of linear R, G, B is left after a path inside, by `rgb_absorption_per_mm`, (3,)."""
        return np.exp(-self._rgb_per_mm * path_mm)

    @cached_property
    def _rgb_per_mm(self) -> np.ndarray:
        if isinstance(self.absorption, ThreeBands):
            return self.absorption.red_green_blue_per_mm
        return fitted_per_mm(self.absorption_per_mm(WAVELENGTHS_NM), self.usual_path_mm)

    def with_recipe(
        self, known: tuple[Chromophore, ...], amounts: dict[str, float], redox: float | None = None
    ) -> _Material:
        """Return the material with other amounts of colourants, or another redox state.

        Parameters
        ----------
        known : tuple of Chromophore
            Those that may be named.
        amounts : dict of str to float
            What is to be changed, by colourant.
        redox : float, optional

        Raises
        ------
        InputError
            If a colourant is not known, or the material has no recipe.
        """
        parts = self.absorption.parts if isinstance(self.absorption, AbsorptionSum) else (self.absorption,)
        if not any(isinstance(part, Recipe) for part in parts):
            raise InputError(f"{self.name}: its absorption was measured as a whole, so there is no recipe to change")
        changed = tuple(part.changed(amounts, redox, known) if isinstance(part, Recipe) else part for part in parts)
        told = " ".join(
            f"{key}={value:g}" for key, value in (amounts | ({} if redox is None else {"redox": redox})).items()
        )
        absorption = AbsorptionSum(changed) if isinstance(self.absorption, AbsorptionSum) else changed[0]
        return replace(self, name=f"{self.name} {told}", absorption=absorption)

    def _named(self, formula: object, wavelengths_nm: np.ndarray | float) -> np.ndarray:
        try:
            return formula(np.asarray(wavelengths_nm, dtype=np.float64))
        except InputError as error:
            raise InputError(f"{self.name}: {error}") from error


class Glass(_Material):
    """What a container is made of.

    Parameters
    ----------
    name : str
    dispersion : Dispersion
        The refractive index over the wavelength.
    absorption : Absorption
        The absorption coefficient over the wavelength.
    density_g_per_cm3 : float
    description, source, assumed : str
        For the user; where the numbers come from, and which of them are assumed.

    Raises
    ------
    InputError
        If the density is not above 0.
    """

    usual_path_mm = 6.0


class Filling(_Material):
    """A liquid in the container; parameters as for `Glass`."""

    usual_path_mm = 60.0
