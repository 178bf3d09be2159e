"""The catalogue of glasses and fillings: those of the installation, of the user's folder, and of single files."""

from __future__ import annotations

import re
import warnings
from functools import cache
from pathlib import Path

from glassworkbench.errors import InputError
from glassworkbench.glass.material import Filling, Glass
from glassworkbench.glass.material_card import CARD_ENDING, read_card
from glassworkbench.glass.material_file import KINDS, Library, Material, read_library
from glassworkbench.settings import RESOURCES, unknown_name, user_glasses

FILE_ENDINGS = (".toml", CARD_ENDING)
"""Of files of the user's own."""

_NAMES = {kind: name for name, kind in KINDS.items()}
_CHANGE = re.compile(r"\s+([A-Za-z]\w*)=(\S+)$")


def catalogue() -> dict[str, Glass]:
    """Return the glasses of the installation and of the user's folder by name."""
    return _all(Glass)


def fillings() -> dict[str, Filling]:
    """Return the fillings of the installation and of the user's folder by name."""
    return _all(Filling)


def refused() -> dict[str, str]:
    """Return why what has a name, but cannot be traced, is not in the catalogue."""
    return dict(_installed().refused)


def find_glass(name: str) -> Glass:
    """Return a glass by its name, or from the user's own file.

    Parameters
    ----------
    name : str
        Like ``emerald``; or ``mine.toml`` (a file with one glass), or ``mine.toml:ruby``; or ``mine.FCMat``, a material
        card of FreeCAD. Amounts of a recipe may follow, as ``emerald Cr2O3=0.1 redox=0.4``.

    Raises
    ------
    InputError
        If it is not known (the nearest name is suggested) or the file is faulty.
    """
    return _find(Glass, name)


def find_filling(name: str) -> Filling:
    """Return a filling by its name or from the user's own file, as `find_glass` does."""
    return _find(Filling, name)


def read_file(path: Path) -> Library:
    """Return what a file of the user's own holds, of materials or a material card; InputError where it is faulty."""
    if path.suffix.lower() == CARD_ENDING:
        glass = read_card(path, _installed().glasses)
        return Library(glasses={glass.name: glass})
    return read_library([path], _installed())


def _all(kind: type[Material]) -> dict[str, Material]:
    return dict(_installed().materials(kind)) | _of_the_user(kind)


@cache
def _installed() -> Library:
    return read_library(sorted((RESOURCES / "glasses").glob("*.toml")))


def _of_the_user(kind: type[Material]) -> dict[str, Material]:
    """Return what is in the user's folder; a faulty file is told, and left out, so that the others are there."""
    found: dict[str, Material] = {}
    folder = user_glasses()
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        if path.suffix.lower() not in FILE_ENDINGS or path.name.startswith("."):
            continue
        try:
            found |= read_file(path).materials(kind)
        except InputError as error:
            warnings.warn(f"{error}; the file is left out of the catalogue", stacklevel=2)
    return found


def _find(kind: type[Material], asked: str) -> Material:
    table = _NAMES[kind]
    if not isinstance(asked, str):
        raise InputError(f"{table}: {asked!r} is no name; give one of the catalogue, or a file of your own")
    name, changes = _changes(asked, table)
    found = _find_unchanged(kind, name)
    if not changes:
        return found
    redox = changes.pop("redox", None)
    try:
        return found.with_recipe(_installed().chromophores, changes, redox)
    except InputError as error:
        raise InputError(f"{table} {asked!r}: {error}") from error


def _changes(asked: str, table: str) -> tuple[str, dict[str, float]]:
    """Return the name, and the amounts that follow it."""
    name, changes = asked.strip(), {}
    while match := _CHANGE.search(name):
        try:
            changes[match[1]] = float(match[2])
        except ValueError as error:
            raise InputError(f"{table} {asked!r}: {match[1]} must be a number, got {match[2]!r}") from error
        name = name[: match.start()]
    return name, changes


def _find_unchanged(kind: type[Material], name: str) -> Material:
    table = _NAMES[kind]
    file, colon, entry = name.rpartition(":")
    if Path(name).suffix.lower() in FILE_ENDINGS:
        file, colon, entry = name, "", ""
    if Path(file).suffix.lower() not in FILE_ENDINGS:
        known = _all(kind)
        if name in refused() and name not in known:
            raise InputError(f"{table} {name!r}: {refused()[name]}")
        if name not in known:
            raise unknown_name(table, name, known)
        return known[name]
    known = read_file(Path(file)).materials(kind)
    if not colon:
        if len(known) != 1:
            raise InputError(f"{file}: holds {len(known)} tables [{table}.NAME]; name one, as {file}:NAME")
        return next(iter(known.values()))
    if entry not in known:
        raise unknown_name(f"{file}: {table}", entry, known)
    return known[entry]
