"""Random numbers by the distributions that a population's file names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene.validate import finite_array
from glassworkbench.settings import check_keys

TRIES = 1000
"""So often is drawn anew what lies beyond the limits of a distribution."""


def _uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(rng.uniform(low, high))


def _normal(rng: np.random.Generator, mean: float, deviation: float) -> float:
    return float(rng.normal(mean, deviation))


def _lognormal(rng: np.random.Generator, median: float, deviation: float) -> float:
    return float(median * np.exp(rng.normal(0.0, deviation)))


FORMS: Mapping[str, Callable] = {"uniform": _uniform, "normal": _normal, "lognormal": _lognormal}
"""From low to high; mean and standard deviation; median and standard deviation of the natural logarithm."""


@dataclass(frozen=True)
class Distribution:
    """A distribution within limits.

    Parameters
    ----------
    form : str
        One of `FORMS`.
    first, second : float
        What the form says.
    least, most : float
        What lies beyond is drawn anew.
    """

    form: str
    first: float
    second: float
    least: float = -np.inf
    most: float = np.inf

    @classmethod
    def of(cls, table: Mapping, field: str) -> Distribution:
        """Return the distribution that a table like ``{ uniform = [0, 1], most = 0.5 }`` describes.

        Raises
        ------
        InputError
            If it names none or several, or numbers that are none.
        """
        check_keys(table, (), (*FORMS, "least", "most"), field)
        named = [form for form in FORMS if form in table]
        if len(named) != 1:
            raise InputError(
                f"{field}: name one distribution of {', '.join(FORMS)}; got {' and '.join(table) or 'none'}"
            )
        first, second = finite_array(table[named[0]], (2,), f"{field}: {named[0]}")
        limits = [table.get("least", -np.inf), table.get("most", np.inf)]
        if not all(isinstance(limit, int | float) for limit in limits) or not limits[0] <= limits[1]:
            raise InputError(f"{field}: least and most must be numbers, least the smaller one")
        if second < (first if named[0] == "uniform" else 0.0):
            raise InputError(f"{field}: {named[0]}: the second number, {second:g}, is too small")
        return cls(named[0], float(first), float(second), *map(float, limits))

    def draw(self, rng: np.random.Generator) -> float:
        """Return a number.

        Raises
        ------
        InputError
            If nothing lies within the limits.
        """
        for _ in range(TRIES):
            value = FORMS[self.form](rng, self.first, self.second)
            if self.least <= value <= self.most:
                return value
        raise InputError(
            f"{self.form} {self.first:g}, {self.second:g}: nothing lies within {self.least:g} to {self.most:g}"
        )


@dataclass(frozen=True)
class Choice:
    """One of some values, each as likely."""

    values: tuple

    def draw(self, rng: np.random.Generator) -> object:
        """Return one of them."""
        return self.values[int(rng.integers(len(self.values)))]


def drawn_from(value: object, field: str) -> Distribution | Choice:
    """Return what a population's file says of a value: a distribution, ``{ choice = [...] }``, or the value itself.

    Raises
    ------
    InputError
        If a table is neither.
    """
    if not isinstance(value, Mapping):
        return Choice((value,))
    if "choice" in value:
        check_keys(value, ("choice",), (), field)
        if not isinstance(value["choice"], list) or not value["choice"]:
            raise InputError(f"{field}: choice: list the values to choose from, got {value['choice']!r}")
        return Choice(tuple(value["choice"]))
    return Distribution.of(value, field)
