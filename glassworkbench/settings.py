"""TOML files read strictly: a misspelt key or name is an error that suggests the right one."""

from __future__ import annotations

import difflib
import os
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path

from glassworkbench.errors import InputError

RESOURCES = Path(__file__).resolve().parent.parent / "resources"
"""The installation's folder of glasses, stations and icons."""

USER_GLASSES = "GLASSWORKBENCH_GLASSES"
"""The environment variable that names the folder of the user's own glasses."""


def user_folder(kind: str) -> Path:
    """Return the folder of the user's own ``"glasses"`` or ``"stations"``, which need not exist.

    The environment variable GLASSWORKBENCH_KIND names it, in capitals; else it lies where the system keeps such files.
    """
    named = os.environ.get(f"GLASSWORKBENCH_{kind.upper()}")
    if named:
        return Path(named)
    data = os.environ.get("APPDATA") or os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(data) / "glassworkbench" / kind


def user_glasses() -> Path:
    """Return the folder of the user's own glasses, which need not exist."""
    return user_folder("glasses")


def read_toml(path: str | Path) -> dict:
    """Return the tables of a TOML file.

    Raises
    ------
    InputError
        If the file cannot be read or is not TOML.
    """
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError(f"{path}: there is no such file; check the path") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not valid TOML ({error})") from error


def unknown_name(kind: str, name: str, known: Iterable[str]) -> InputError:
    """Return the error for a `name` that is not among the `known` ones: it suggests the nearest, or lists all.

    They are listed in the order in which they are given; those of a set, which has none, by the alphabet.
    """
    known = sorted(known) if isinstance(known, (set, frozenset)) else list(known)
    close = nearest_name(name, known)
    hint = f"there is {', '.join(known)}" if close is None else f"did you mean {close!r}?"
    return InputError(f"{kind} {name!r} is not known; {hint}")


def nearest_name(name: str, known: Iterable[str]) -> str | None:
    """Return which of the `known` names was probably meant, None if none is like it."""
    lowered = {candidate.lower(): candidate for candidate in known}
    close = difflib.get_close_matches(str(name).lower(), lowered, n=1, cutoff=0.5)
    return lowered[close[0]] if close else None


def check_keys(table: Mapping, required: Iterable[str], optional: Iterable[str], where: str) -> None:
    """Check that `table` has every required key and no other than those named.

    Raises
    ------
    InputError
        Naming `where`, the key, and the nearest known one.
    """
    required, optional = set(required), set(optional)
    if not isinstance(table, Mapping):
        raise InputError(f"{where}: expected a table of keys, got {table!r}")
    for key in table:
        if key not in required | optional:
            raise unknown_name(f"{where}: key", key, required | optional)
    for key in sorted(required - set(table)):
        raise InputError(f"{where}: the key {key!r} is missing")
