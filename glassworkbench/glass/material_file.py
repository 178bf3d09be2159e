"""Files of materials (TOML): glasses, fillings, and the dispersions and chromophores that they name."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.glass.absorption import Absorption, AbsorptionSum, AbsorptionTable, Recipe, ThreeBands
from glassworkbench.glass.checks import above_zero, numbers, rising_nm, text
from glassworkbench.glass.chromophores import Band, Chromophore, Tail
from glassworkbench.glass.dispersion import (
    ConstantIndex,
    Dispersion,
    IndexTable,
    PowerSum,
    ScaledDispersion,
    Sellmeier,
)
from glassworkbench.glass.material import Filling, Glass
from glassworkbench.settings import check_keys, read_toml, unknown_name

Material = TypeVar("Material", Glass, Filling)

KINDS = {"glass": Glass, "filling": Filling}
_TABLES = (*KINDS, "dispersion", "chromophore")

_INDEX_KEYS = ("dispersion", "refractive_index")
_ABSORPTION_KEYS = ("absorption", "absorption_per_mm")
_MATERIAL_KEYS = (
    "like",
    "density_g_per_cm3",
    *_INDEX_KEYS,
    *_ABSORPTION_KEYS,
    "colourants",
    "redox",
    "description",
    "source",
    "assumed",
    "refused",
)


@dataclass(frozen=True, eq=False)
class Library:
    """What one or several files hold.

    Parameters
    ----------
    dispersions : dict of str to Dispersion
    chromophores : tuple of Chromophore
    glasses, fillings : dict
        Materials by name.
    refused : dict of str to str
        Why a material that has a name is none that can be traced.
    entries : dict of str to dict
        The materials' tables as they were written, by kind and name, for others that are `like` them.
    """

    dispersions: Mapping[str, Dispersion] = field(default_factory=dict)
    chromophores: tuple[Chromophore, ...] = ()
    glasses: Mapping[str, Glass] = field(default_factory=dict)
    fillings: Mapping[str, Filling] = field(default_factory=dict)
    refused: Mapping[str, str] = field(default_factory=dict)
    entries: Mapping[str, Mapping] = field(default_factory=lambda: {kind: {} for kind in KINDS})

    def materials(self, kind: type[Material]) -> Mapping[str, Material]:
        """Return the glasses or the fillings by name."""
        return self.glasses if kind is Glass else self.fillings


def read_library(paths: Iterable[Path], known: Library | None = None) -> Library:
    """Return what files of materials hold; each may name what is in another, or in what is `known`.

    Raises
    ------
    InputError
        Naming the file, the table and the field.
    """
    known = known or Library()
    files = [(path, read_toml(path)) for path in paths]
    dispersions, chromophores = dict(known.dispersions), list(known.chromophores)
    entries = {kind: dict(known.entries[kind]) for kind in KINDS}
    for path, tables in files:
        check_keys(tables, (), _TABLES, str(path))
        # Scaled dispersions stand below those that they scale.
        for name, table in _entries(path, tables, "dispersion"):
            with _named(f"{path}: [dispersion.{name}]"):
                dispersions[name] = _dispersion(table, dispersions)
        for name, table in _entries(path, tables, "chromophore"):
            with _named(f"{path}: [chromophore.{name}]"):
                chromophores.append(_chromophore(name, table))
        for kind in KINDS:
            entries[kind] |= dict(_entries(path, tables, kind))
    made, refused = {kind: {} for kind in KINDS}, {}
    for path, tables in files:
        for kind in KINDS:
            for name, table in _entries(path, tables, kind):
                with _named(f"{path}: [{kind}.{name}]"):
                    check_keys(table, (), _MATERIAL_KEYS, "table")
                    if "refused" in table:
                        refused[name] = str(table["refused"])
                    else:
                        whole = _with_what_it_is_like(table, kind, entries[kind])
                        made[kind][name] = _material(KINDS[kind], name, whole, dispersions, tuple(chromophores))
    return Library(dispersions, tuple(chromophores), made["glass"], made["filling"], refused, entries)


@contextmanager
def _named(where: str) -> Iterator[None]:
    try:
        yield
    except InputError as error:
        raise InputError(f"{where} {str(error).removeprefix('table: ')}") from error


def _entries(path: Path, tables: Mapping, kind: str) -> Iterator[tuple[str, Mapping]]:
    entries = tables.get(kind, {})
    if not isinstance(entries, Mapping) or not all(isinstance(entry, Mapping) for entry in entries.values()):
        raise InputError(f"{path}: [{kind}] must hold tables, as [{kind}.NAME]")
    yield from entries.items()


def _with_what_it_is_like(table: Mapping, kind: str, entries: Mapping) -> Mapping:
    """Return a material's table with what it leaves to another material."""
    if "like" not in table:
        return table
    name = text(table["like"], "like")
    if name not in entries:
        raise unknown_name("like:", name, entries)
    if entries[name] is table or "like" in entries[name] or "refused" in entries[name]:
        raise InputError(f"like: {name!r} is no glass with numbers of its own; name the one that it is like itself")
    other = dict(entries[name])
    for keys in (_INDEX_KEYS, _ABSORPTION_KEYS):
        if any(key in table for key in keys):
            other = {key: value for key, value in other.items() if key not in keys}
    if any(key in table for key in _ABSORPTION_KEYS):
        other = {key: value for key, value in other.items() if key not in ("colourants", "redox")}
    elif isinstance(table.get("colourants"), Mapping):
        table = {**table, "colourants": {**other.get("colourants", {}), **table["colourants"]}}
    return {**other, "source": f"like {name}: {other.get('source', '')}", **table}


def _material(
    kind: type[Material],
    name: str,
    table: Mapping,
    dispersions: Mapping[str, Dispersion],
    chromophores: tuple[Chromophore, ...],
) -> Material:
    check_keys(table, ("density_g_per_cm3",), _MATERIAL_KEYS, "table")
    density = above_zero(table["density_g_per_cm3"], "density_g_per_cm3")
    words = {key: str(table.get(key, "")) for key in ("description", "source", "assumed")}
    return kind(name, _index(table, dispersions), _absorption(table, density, chromophores), density, **words)


def _index(table: Mapping, dispersions: Mapping[str, Dispersion]) -> Dispersion:
    if sum(key in table for key in _INDEX_KEYS) != 1:
        given = "both are given" if all(key in table for key in _INDEX_KEYS) else "neither is"
        raise InputError(f"refractive_index, dispersion: {given}; give one, a number or the name of a dispersion")
    if "refractive_index" in table:
        return ConstantIndex(table["refractive_index"])
    asked = table["dispersion"]
    if isinstance(asked, Mapping):
        return _dispersion(asked, dispersions)
    text(asked, "dispersion")
    if asked not in dispersions:
        raise unknown_name("dispersion:", asked, dispersions)
    return dispersions[asked]


def _dispersion(table: Mapping, dispersions: Mapping[str, Dispersion]) -> Dispersion:
    if "formula" not in table:
        raise InputError(f"dispersion: formula is missing; there is {', '.join(_FORMULAS)}")
    formula = text(table["formula"], "dispersion: formula")
    if formula not in _FORMULAS:
        raise unknown_name("dispersion: formula", formula, _FORMULAS)
    keys, make = _FORMULAS[formula]
    check_keys(table, ("formula", *keys), ("source",), f"dispersion by {formula}")
    return make({"source": "", **table}, dispersions)


def _scaled(table: Mapping, dispersions: Mapping[str, Dispersion]) -> ScaledDispersion:
    if text(table["of"], "of") not in dispersions:
        raise unknown_name("of:", table["of"], dispersions)
    source = f"{table['source']}; scaled from {dispersions[table['of']].source}"
    return ScaledDispersion(dispersions[table["of"]], table["wavelength_nm"], table["refractive_index"], source)


_FORMULAS: Mapping[str, tuple[tuple[str, ...], Callable[[Mapping, Mapping], Dispersion]]] = {
    "sellmeier": (("coefficients", "range_nm"), lambda t, _: Sellmeier(t["coefficients"], t["range_nm"], t["source"])),
    "powers": (("coefficients", "range_nm"), lambda t, _: PowerSum(t["coefficients"], t["range_nm"], t["source"])),
    "table": (
        ("wavelengths_nm", "refractive_index"),
        lambda t, _: IndexTable(t["wavelengths_nm"], numbers(t["refractive_index"], "refractive_index"), t["source"]),
    ),
    "scaled": (("of", "wavelength_nm", "refractive_index"), _scaled),
}


def _chromophore(name: str, table: Mapping) -> Chromophore:
    optional = ("bands", "tails", "molar_mass_g_per_mol", "share", "source", "assumed", "description")
    check_keys(table, ("colourant", "range_nm"), optional, "table")
    parts = []
    for key, kind, keys in (
        ("bands", Band, ("centre_nm", "width_per_cm", "strength")),
        ("tails", Tail, ("at_nm", "decay_nm", "strength")),
    ):
        rows = table.get(key, [])
        if not isinstance(rows, list):
            raise InputError(f"{key}: must be a list of tables, as [{{ {keys[0]} = …, {keys[1]} = …, strength = … }}]")
        for row in rows:
            check_keys(row, keys, (), key)
            parts.append(kind(**row))
    told = {key: str(table.get(key, "")) for key in ("source", "assumed")}
    return Chromophore(
        name.replace("_", " "),
        table["colourant"],
        tuple(parts),
        table["range_nm"],
        table.get("molar_mass_g_per_mol"),
        table.get("share"),
        **told,
    )


def _absorption(table: Mapping, density: float, chromophores: tuple[Chromophore, ...]) -> Absorption:
    if "redox" in table and "colourants" not in table:
        raise InputError("redox: is for colourants, and none are given; give them, or leave redox out")
    if "absorption_per_mm" in table:
        if "absorption" in table or "colourants" in table:
            raise InputError("absorption_per_mm: absorption or colourants are given, too; leave one of them out")
        return ThreeBands(table["absorption_per_mm"])
    parts = []
    if "absorption" in table:
        parts.append(_absorption_table(table["absorption"]))
    if "colourants" in table:
        amounts = table["colourants"]
        if not isinstance(amounts, Mapping):
            raise InputError(f"colourants: must be a table of amounts, as {{ Fe2O3 = 0.3 }}, got {amounts!r}")
        parts.append(Recipe(dict(amounts), chromophores, density, table.get("redox")))
    if not parts:
        raise InputError(
            "absorption: is missing; give colourants, a table of absorption, or absorption_per_mm for R, G and B"
        )
    return parts[0] if len(parts) == 1 else AbsorptionSum(tuple(parts))


def _absorption_table(table: Mapping) -> AbsorptionTable:
    forms = ("per_mm", "extinction_coefficient", "internal_transmittance")
    check_keys(table, ("wavelengths_nm",), (*forms, "thickness_mm"), "absorption")
    given = [form for form in forms if form in table]
    if len(given) != 1:
        raise InputError(f"absorption: expected one of {', '.join(forms)}, got {' and '.join(given) or 'none'}")
    form = given[0]
    if ("thickness_mm" in table) != (form == "internal_transmittance"):
        raise InputError("absorption: thickness_mm belongs to internal_transmittance; give both, or neither")
    wavelengths = rising_nm(table["wavelengths_nm"], "absorption: wavelengths_nm")
    values = numbers(table[form], f"absorption: {form}")
    if form == "extinction_coefficient":
        if len(values) == len(wavelengths):
            values = 4.0 * np.pi * values / (1e-6 * wavelengths)
    elif form == "internal_transmittance":
        if np.any((values <= 0.0) | (values > 1.0)):
            raise InputError("absorption: internal_transmittance must lie above 0 and at most be 1")
        values = -np.log(values) / above_zero(table["thickness_mm"], "absorption: thickness_mm")
    return AbsorptionTable(wavelengths, values)
