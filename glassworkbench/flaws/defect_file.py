"""Defects in a file (TOML)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path

from glassworkbench.errors import InputError
from glassworkbench.flaws.defect import Defect
from glassworkbench.flaws.kinds import KINDS
from glassworkbench.settings import check_keys, read_toml, unknown_name


def read_defects(path: str | Path) -> tuple[Defect, ...]:
    """Return the defects that a TOML file lists: a table ``[[defect]]`` with its ``kind`` for each.

    Raises
    ------
    InputError
        If the file cannot be read, or a table has an unknown key or an impossible value; the message counts the tables.
    """
    tables = read_toml(path)
    check_keys(tables, (), ("defect",), str(path))
    entries = tables.get("defect", [])
    if not isinstance(entries, list):
        raise InputError(f"{path}: defect: write [[defect]] with two brackets, one such table for each defect")
    if not entries:
        raise InputError(f"{path}: it lists no defect; write a table [[defect]] for each")
    defects = []
    for number, table in enumerate(entries, start=1):
        try:
            defects.append(make_defect(table))
        except InputError as error:
            raise InputError(f"{path}: defect {number}: {error}") from error
    return tuple(defects)


def make_defect(table: Mapping) -> Defect:
    """Return the defect that a table of keys describes; its ``class`` is the dataclass's `severity`.

    Raises
    ------
    InputError
        If it lacks a key or has an unknown one, or a value is impossible.
    """
    if not isinstance(table, Mapping):
        raise InputError(f"expected a table of keys, got {table!r}")
    name = table.get("kind")
    if name not in KINDS:
        raise unknown_name("kind", name, KINDS)
    needed = {field.name for field in fields(KINDS[name]) if field.default is MISSING}
    optional = {field.name for field in fields(KINDS[name])} - needed - {"severity"} | {"class"}
    check_keys(table, {"kind"} | needed, optional, name)
    values = {key: value for key, value in table.items() if key not in ("kind", "class")}
    return KINDS[name](**values, severity=table.get("class", ""))
