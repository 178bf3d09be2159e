"""The defects of a manufacturing day: how many, of what kind, how large and where, drawn from stated distributions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from types import MappingProxyType

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.flaws.defect import Defect, InWall
from glassworkbench.flaws.distributions import Choice, Distribution, drawn_from
from glassworkbench.flaws.fitting import fit
from glassworkbench.flaws.glass_wall import GlassWall
from glassworkbench.flaws.kinds import IN_GLASS, KINDS
from glassworkbench.scene import ContainerGeometry
from glassworkbench.scene.validate import finite
from glassworkbench.settings import RESOURCES, check_keys, read_toml, unknown_name

FOLDER = RESOURCES / "defects"

ROUNDS = 200
"""So often a defect that does not fit where it was drawn, or overlaps with another, is drawn anew."""

MOST_DEFECTS = 20_000


@dataclass(frozen=True)
class Family:
    """How defects of one kind come.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    per_container : float
        How many a container has on average; the number is Poisson's.
    height_share, depth_share : Distribution or Choice
        Of the container's height, and of the wall where it lies. The angle is uniform.
    values : mapping of str to Distribution or Choice
        Of the other fields.
    severity : str
    """

    kind: str
    per_container: float
    height_share: Distribution | Choice
    depth_share: Distribution | Choice
    values: Mapping[str, Distribution | Choice]
    severity: str = ""


@dataclass(frozen=True)
class Population:
    """What a day's containers have of defects.

    Parameters
    ----------
    name, description : str
    families : tuple of Family
    """

    name: str
    description: str
    families: tuple[Family, ...]


def populations() -> dict[str, str]:
    """Return what each population is, by its name."""
    return {path.stem: read_population(path).description for path in sorted(FOLDER.glob("*.toml"))}


def find_population(name: str) -> Population:
    """Return a population by its name, or from a TOML file.

    Raises
    ------
    InputError
        With the nearest name, or what is wrong with the file.
    """
    if str(name).lower().endswith(".toml"):
        return read_population(Path(name))
    known = populations()
    if name not in known:
        raise unknown_name("population", name, known)
    return read_population(FOLDER / f"{name}.toml")


def read_population(path: Path) -> Population:
    """Return the population that a TOML file describes; `docs/defects.md` lists its keys.

    Raises
    ------
    InputError
        If the file cannot be read, or a key is unknown, missing or impossible.
    """
    tables = read_toml(path)
    check_keys(tables, ("description", "defect"), ("source",), str(path))
    if not isinstance(tables["defect"], list):
        raise InputError(f"{path}: defect: write [[defect]] with two brackets, one such table for each kind")
    families = []
    for number, table in enumerate(tables["defect"], start=1):
        try:
            families.append(_family(table))
        except InputError as error:
            raise InputError(f"{path}: defect {number}: {error}") from error
    return Population(path.stem, str(tables["description"]), tuple(families))


def _family(table: Mapping) -> Family:
    name = table.get("kind")
    if name not in KINDS:
        raise unknown_name("kind", name, KINDS)
    if KINDS[name] not in IN_GLASS:
        raise InputError(f"{name}: it is made with the wall, so it cannot be drawn for a container; list it in a file")
    own = {field.name for field in fields(KINDS[name])} - {"height_mm", "angle_deg", "depth_mm", "severity"}
    depth = {"depth_share"} if issubclass(KINDS[name], InWall) else set()
    check_keys(table, ("kind", "per_container", "height_share"), own | depth | {"class"}, name)
    mean = finite(table["per_container"], f"{name}: per_container")
    if not 0.0 <= mean <= MOST_DEFECTS:
        raise InputError(f"{name}: per_container: must lie between 0 and {MOST_DEFECTS}, got {mean:g}")
    values = {key: drawn_from(table[key], f"{name}: {key}") for key in table if key in own}
    return Family(
        name,
        mean,
        drawn_from(table["height_share"], f"{name}: height_share"),
        drawn_from(table.get("depth_share", 0.5), f"{name}: depth_share"),
        MappingProxyType(values),
        table.get("class", ""),
    )


def sample(population: Population | str, seed: int | Sequence[int], geometry: ContainerGeometry) -> tuple[Defect, ...]:
    """Return the defects of one container, the same for the same seed.

    Parameters
    ----------
    population : Population or str
        Or its name, or the name of its file.
    seed : int or sequence of int
        Not below 0.
    geometry : ContainerGeometry

    Raises
    ------
    InputError
        If the population is not known, or the seed is none.
    GlassWorkbenchError
        If the wall has no room for what was drawn.
    """
    population = population if isinstance(population, Population) else find_population(population)
    try:
        rng = np.random.default_rng(seed)
    except (TypeError, ValueError) as error:
        raise InputError(f"{population.name}: seed: expected a whole number not below 0, got {seed!r}") from error
    families = [family for family in population.families for _ in range(rng.poisson(family.per_container))]
    wall = GlassWall(geometry)
    drawn: list[Defect | None] = [None] * len(families)
    waiting = list(range(len(families)))
    for _ in range(ROUNDS):
        for k, defect in zip(waiting, _draw([families[k] for k in waiting], rng, wall, geometry), strict=True):
            drawn[k] = defect
        placed = [k for k, defect in enumerate(drawn) if defect is not None]
        faults = fit(geometry, [drawn[k] for k in placed]).faults
        waiting = sorted({k for k, defect in enumerate(drawn) if defect is None} | {placed[k] for k in faults})
        if not waiting:
            return tuple(drawn)
    raise GlassWorkbenchError(
        f"{population.name}: {len(waiting)} of {len(families)} defects find no place in the wall, the first a "
        f"{families[waiting[0]].kind}; make them fewer or smaller, or the wall thicker"
    )


def day(
    population: Population | str, seed: int, geometry: ContainerGeometry, containers: int
) -> Iterator[tuple[Defect, ...]]:
    """Yield the defects of one container of a day after the other; each depends on the seed and its number alone."""
    for number in range(containers):
        yield sample(population, (seed, number), geometry)


def _draw(
    families: Sequence[Family], rng: np.random.Generator, wall: GlassWall, geometry: ContainerGeometry
) -> list[Defect | None]:
    """Return a defect of each family; None where there is no wall at the place that was drawn."""
    heights = np.array([family.height_share.draw(rng) for family in families]) * geometry.finish_height_mm
    angles = rng.uniform(0.0, 360.0, len(families))
    defects: list[Defect | None] = []
    for family, height, angle, site in zip(families, heights, angles, wall.sites(heights, angles), strict=True):
        values = {key: value.draw(rng) for key, value in family.values.items()}
        depth = family.depth_share.draw(rng)
        if site is None:
            defects.append(None)
            continue
        kind = KINDS[family.kind]
        if issubclass(kind, InWall):
            values["depth_mm"] = depth * site.wall_mm
        defects.append(kind(height_mm=height, angle_deg=angle, severity=family.severity, **values))
    return defects
