"""From which size on a finding is minor, major or critical, and what is rejected."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from glassworkbench.errors import InputError
from glassworkbench.scene.validate import positive
from glassworkbench.settings import RESOURCES, check_keys, read_toml, unknown_name

CLASSES = ("minor", "major", "critical")
USUAL_FILE = RESOURCES / "judging" / "limits.toml"


@dataclass(frozen=True)
class Limits:
    """What sizes mean.

    Parameters
    ----------
    zones : mapping of str to mapping of str to float
        For each zone the size (mm) from which a finding is minor, major, critical; ``default`` for those not named.
    reject : tuple of str
        Classes for which a zone is rejected.
    most_minor : int
        More minor findings than these in a zone reject it, too.
    """

    zones: Mapping[str, Mapping[str, float]]
    reject: tuple[str, ...] = ("critical", "major")
    most_minor: int = 3

    def __post_init__(self) -> None:
        if "default" not in self.zones:
            raise InputError("limits: the zone 'default' is missing; it holds for zones that are not named")
        for zone, sizes in self.zones.items():
            check_keys(sizes, CLASSES, (), f"limits of zone {zone}")
            ordered = [positive(sizes[name], f"limits of zone {zone}: {name}") for name in CLASSES]
            if ordered != sorted(ordered):
                raise InputError(f"limits of zone {zone}: sizes must grow from minor over major to critical")
        for name in self.reject:
            if name not in CLASSES:
                raise unknown_name("limits: class", name, CLASSES)
        if not isinstance(self.most_minor, int) or self.most_minor < 0:
            raise InputError(f"limits: most_minor: expected a whole number from 0 on, got {self.most_minor!r}")

    def class_of(self, zone: str, size_mm: float) -> str | None:
        """Return the class of a finding, None if it is too small for any."""
        sizes = self.zones.get(zone, self.zones["default"])
        return next((name for name in reversed(CLASSES) if size_mm >= sizes[name]), None)


def read_limits(path: str | Path | None = None) -> Limits:
    """Return the limits in a TOML file, or the usual ones.

    Raises
    ------
    InputError
        If the file cannot be read, or a key is not known, absent or impossible.
    """
    path = USUAL_FILE if path is None else Path(path)
    table = read_toml(path)
    check_keys(table, ("zone",), ("reject", "most_minor"), str(path))
    options = {name: table[name] for name in ("reject", "most_minor") if name in table}
    if "reject" in options:
        options["reject"] = tuple(options["reject"])
    try:
        return Limits(table["zone"], **options)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
