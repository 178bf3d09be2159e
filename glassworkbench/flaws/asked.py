"""Defects as a user asks for them: a file that lists them, or a population and a seed."""

from __future__ import annotations

from dataclasses import dataclass

from glassworkbench.errors import InputError
from glassworkbench.flaws.defect import Defect
from glassworkbench.flaws.defect_file import read_defects
from glassworkbench.flaws.kinds import IN_WALL
from glassworkbench.flaws.population import Population, find_population, sample
from glassworkbench.scene import ContainerGeometry


@dataclass(frozen=True)
class ListedDefects:
    """Defects that are known one by one."""

    defects: tuple[Defect, ...]

    @property
    def of_wall(self) -> tuple[Defect, ...]:
        """Those that are made with the wall."""
        return tuple(defect for defect in self.defects if isinstance(defect, IN_WALL))

    def on(self, geometry: ContainerGeometry) -> tuple[Defect, ...]:
        """Return them."""
        return self.defects


@dataclass(frozen=True)
class DrawnDefects:
    """Defects that are drawn for a container."""

    population: Population
    seed: int

    of_wall = ()

    def on(self, geometry: ContainerGeometry) -> tuple[Defect, ...]:
        """Return the defects of a container; raises as `population.sample`."""
        return sample(self.population, self.seed, geometry)


def parse_defects(text: str) -> ListedDefects | DrawnDefects:
    """Return the defects that ``FILE.toml`` lists, or those that ``POPULATION:SEED`` draws.

    Raises
    ------
    InputError
        If it is neither, or the file or the population cannot be read.
    """
    name, colon, seed = text.rpartition(":")
    if colon and seed.strip().isdecimal():
        return DrawnDefects(find_population(name), int(seed))
    if text.lower().endswith(".toml"):
        return ListedDefects(read_defects(text))
    population = find_population(name if colon else text).name
    raise InputError(f"defects: give the seed of {population} as a whole number, like {population}:1, got {text!r}")
