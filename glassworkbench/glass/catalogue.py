"""The catalogue of glasses and fillings: TOML files of the installation, and the user's own."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

from glassworkbench.errors import InputError
from glassworkbench.glass.material import Filling, Glass
from glassworkbench.settings import RESOURCES, check_keys, read_toml, unknown_name

Material = TypeVar("Material", Glass, Filling)

_TABLES = {Glass: "glass", Filling: "filling"}


def catalogue() -> dict[str, Glass]:
    """Return the installation's glasses by name."""
    return dict(_installed(Glass))


def fillings() -> dict[str, Filling]:
    """Return the installation's fillings by name."""
    return dict(_installed(Filling))


def find_glass(name: str) -> Glass:
    """Return a glass by its name, or from the user's own file.

    Parameters
    ----------
    name : str
        Like ``emerald``; or ``mine.toml`` (a file with one glass), or ``mine.toml:ruby``.

    Raises
    ------
    InputError
        If it is not known (the nearest name is suggested) or the file is faulty.
    """
    return _find(Glass, name)


def find_filling(name: str) -> Filling:
    """Return a filling by its name or from the user's own file, as `find_glass` does."""
    return _find(Filling, name)


@cache
def _installed(kind: type[Material]) -> MappingProxyType[str, Material]:
    files = sorted((RESOURCES / "glasses").glob("*.toml"))
    return MappingProxyType({name: found for path in files for name, found in _read(kind, path).items()})


def _find(kind: type[Material], name: str) -> Material:
    if not isinstance(name, str):
        raise InputError(f"{_TABLES[kind]}: {name!r} is no name; give one of the catalogue, or a file of your own")
    file, colon, entry = name.rpartition(":")
    if name.endswith(".toml"):
        file, colon, entry = name, "", ""
    if not file.endswith(".toml"):
        known = _installed(kind)
        if name not in known:
            raise unknown_name(_TABLES[kind], name, known)
        return known[name]
    known = _read(kind, Path(file))
    if not colon:
        if len(known) != 1:
            raise InputError(f"{file}: holds {len(known)} tables [{_TABLES[kind]}.NAME]; name one, as {file}:NAME")
        return next(iter(known.values()))
    if entry not in known:
        raise unknown_name(f"{file}: {_TABLES[kind]}", entry, known)
    return known[entry]


def _read(kind: type[Material], path: Path) -> dict[str, Material]:
    tables = read_toml(path)
    check_keys(tables, (), _TABLES.values(), str(path))
    entries = tables.get(_TABLES[kind], {})
    materials = {}
    for name, entry in entries.items():
        where = f"{path}: [{_TABLES[kind]}.{name}]"
        check_keys(
            entry,
            ("refractive_index", "absorption_per_mm", "density_g_per_cm3"),
            ("description", "source"),
            where,
        )
        try:
            materials[name] = kind(name=name, **entry)
        except InputError as error:
            raise InputError(f"{path}: {error}") from error
    return materials
