"""The stations by name; each reads its numbers from resources/stations/NAME.toml."""

from __future__ import annotations

from functools import cache
from types import MappingProxyType

from glassworkbench.errors import InputError
from glassworkbench.glass import Glass, find_glass
from glassworkbench.scene import ContainerGeometry, Scene
from glassworkbench.settings import RESOURCES, read_toml, unknown_name
from glassworkbench.staging.contents import Fill, bodies, media, parse_fill
from glassworkbench.staging.sidewall import sidewall
from glassworkbench.staging.studio import studio

_VIEWS = MappingProxyType({"studio": studio, "sidewall": sidewall})


def stations() -> dict[str, str]:
    """Return what each station is, by its name."""
    return {name: _settings(name)["description"] for name in _VIEWS}


def check_station(name: str) -> None:
    """Check that there is such a station, before the long work starts.

    Raises
    ------
    InputError
        With the nearest name.
    """
    if name not in _VIEWS:
        raise unknown_name("station", name, _VIEWS)


def station(
    name: str,
    geometry: ContainerGeometry,
    glass: Glass | str,
    fill: Fill | str | None = None,
    size: tuple[int, int] = (480, 640),
) -> Scene:
    """Return the scene of a container at a station.

    Parameters
    ----------
    name : str
        One of `stations()`.
    geometry : ContainerGeometry
        Upright, axis on z, lowest point at z = 0.
    glass : Glass or str
        A glass, or its name in the catalogue.
    fill : Fill or str, optional
        What it holds, like ``"water"`` or ``"water:120"`` (level in mm).
    size : (int, int)
        Width and height of the image in pixels; the view is framed to fit the container into it.

    Raises
    ------
    InputError
        If a name is not known, the level lies outside the container, or the size is impossible.
    """
    check_station(name)
    if not isinstance(geometry, ContainerGeometry):
        raise InputError(f"container: {geometry!r} is none; give the geometry() of what hollow returns")
    if min(size) < 1:
        raise InputError(f"image size: {size[0]}x{size[1]} pixels is impossible; each side is at least 1")
    glass = find_glass(glass) if isinstance(glass, str) else glass
    fill = parse_fill(fill) if isinstance(fill, str) else fill
    lights, camera = _VIEWS[name](geometry, size, **_settings(name)["parameters"])
    return Scene(
        bodies=bodies(geometry, fill),
        media=media(geometry, glass, fill),
        lights=lights,
        camera=camera,
        size=size,
        metadata=_told(name, geometry, glass, fill),
    )


def _told(name: str, geometry: ContainerGeometry, glass: Glass, fill: Fill | None) -> dict[str, str]:
    told = {"glass": glass.name, "station": name}
    if fill:
        told["fill"] = str(fill)
    if geometry.notes:
        told["notes"] = "; ".join(geometry.notes)
    return told


@cache
def _settings(name: str) -> MappingProxyType:
    return MappingProxyType(read_toml(RESOURCES / "stations" / f"{name}.toml"))
