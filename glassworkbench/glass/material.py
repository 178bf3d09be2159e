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

DENSEST_G_PER_CM3 = 10.0
"""More than the heaviest lead glass."""


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
        object.__setattr__(self, "density_g_per_cm3", _density(self.density_g_per_cm3))

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

    @cached_property
    def visible_nm(self) -> np.ndarray:
        """The wavelengths of `glassworkbench.colour.WAVELENGTHS_NM` at which colours are taken: all that are known.

        Raises
        ------
        InputError
            If the absorption is not known from 400 to 700 nm at least: a colour cannot be told from less.
        """
        low, high = self.absorption.range_nm
        if low > 400.0 or high < 700.0:
            raise InputError(
                f"{self.name}: absorption is known from {low:g} to {high:g} nm; a colour needs 400 to 700 nm"
            )
        return WAVELENGTHS_NM[(low <= WAVELENGTHS_NM) & (high >= WAVELENGTHS_NM)]

    def colour(self, path_mm: float | np.ndarray, light: str = "D65") -> np.ndarray:
        """Return X, Y, Z of what is left of an illuminant after a path inside; Y = 1 is everything.

        Parameters
        ----------
        path_mm : float or array (n,)
        light : str
            One of `glassworkbench.colour.ILLUMINANTS`.

        Returns
        -------
        array (3,) or (n, 3)
        """
        paths = np.asarray(path_mm, dtype=np.float64)[..., None]
        return tristimulus(self.transmittance(self.visible_nm, paths), light, self.visible_nm)

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
        return fitted_per_mm(self.absorption_per_mm(self.visible_nm), self.visible_nm, self.usual_path_mm)

    @property
    def recipes(self) -> tuple[Recipe, ...]:
        """The recipes of the absorption; none where it was measured as a whole."""
        return tuple(part for part in self._parts if isinstance(part, Recipe))

    @property
    def _parts(self) -> tuple[Absorption, ...]:
        return self.absorption.parts if isinstance(self.absorption, AbsorptionSum) else (self.absorption,)

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
        if not self.recipes:
            raise InputError(f"{self.name}: its absorption was measured as a whole, so there is no recipe to change")
        parts = [part.changed(amounts, redox, known) if isinstance(part, Recipe) else part for part in self._parts]
        absorption = parts[0] if len(parts) == 1 else AbsorptionSum(tuple(parts))
        told = amounts if redox is None else amounts | {"redox": redox}
        name = " ".join((self.name, *(f"{key}={value:g}" for key, value in told.items())))
        return replace(self, name=name, absorption=absorption)

    def _named(self, formula: object, wavelengths_nm: np.ndarray | float) -> np.ndarray:
        try:
            return formula(np.asarray(wavelengths_nm, dtype=np.float64))
        except InputError as error:
            raise InputError(f"{self.name}: {error}") from error


def _density(value: float) -> float:
    density = above_zero(value, "density_g_per_cm3")
    if density > DENSEST_G_PER_CM3:
        raise InputError(f"density_g_per_cm3: no glass has {density:g} g/cm3; is it in kg/m3? divide it by 1000 then")
    return density


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
