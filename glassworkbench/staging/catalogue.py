"""The stations by name, each a file: resources/stations/NAME.toml, one in the user's folder, or one that is named."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from glassworkbench.errors import InputError
from glassworkbench.glass import Glass, find_glass
from glassworkbench.scene import ContainerGeometry, Scene
from glassworkbench.scene.image_scale import image_scale
from glassworkbench.settings import RESOURCES, check_keys, read_toml, unknown_name, user_folder
from glassworkbench.staging.cameras import place_camera
from glassworkbench.staging.contents import Fill, bodies, media, parse_fill
from glassworkbench.staging.lights import place_light
from glassworkbench.staging.pose import Pose
from glassworkbench.staging.sight import check_sight

ENDING = ".toml"


def stations() -> dict[str, str]:
    """Return what each station is, by its name; of a file that cannot be used, why."""
    told = {}
    for name in _files():
        try:
            told[name] = described(name)
        except InputError as error:
            told[name] = f"cannot be used: {error}"
    return told


def described(name: str) -> str:
    """Return what a station is.

    Raises
    ------
    InputError
        If it is not known, or there is something wrong with its file.
    """
    return str(_settings(_file(name))["description"])


def check_station(name: str) -> None:
    """Check that there is such a station, before the long work starts.

    Raises
    ------
    InputError
        With the nearest name, or what is wrong with its file.
    """
    _settings(_file(name))


def station(
    name: str,
    geometry: ContainerGeometry,
    glass: Glass | str,
    fill: Fill | str | None = None,
    size: tuple[int, int] | None = None,
    pose: Pose | None = None,
) -> Scene:
    """Return the scene of a container at a station.

    Parameters
    ----------
    name : str
        One of `stations()`, or the path of a station file that ends in ``.toml``.
    geometry : ContainerGeometry
        Upright, axis on z, lowest point at z = 0.
    glass : Glass or str
        A glass, or its name in the catalogue.
    fill : Fill or str, optional
        What it holds, like ``"water"`` or ``"water:120"`` (level in mm).
    size : (int, int), optional
        Width and height of the image in pixels; those of the station's sensor if not given, or 480 x 640 where the
        station is fitted to the container.
    pose : Pose, optional
        How the container stands; as the station says if not given. Camera and lights do not follow it.

    Raises
    ------
    InputError
        If a name is not known, the level lies outside the container, the size is impossible, or the camera does not
        see the container.
    """
    path = _file(name)
    settings = _settings(path)
    if not isinstance(geometry, ContainerGeometry):
        raise InputError(f"container: {geometry!r} is none; give the geometry() of what hollow returns")
    if size is not None and min(size) < 1:
        raise InputError(f"image size: {size[0]}x{size[1]} pixels is impossible; each side is at least 1")
    glass = find_glass(glass) if isinstance(glass, str) else glass
    fill = parse_fill(fill) if isinstance(fill, str) else fill
    with _named(name):
        pose = _pose(settings.get("container", {})) if pose is None else pose
        seen = place_camera(settings["camera"], geometry, size)
        lights = tuple(
            light
            for table in settings["light"]
            for light in place_light(table, geometry, seen.camera, seen.size, path.parent)
        )
        check_sight(seen.camera, seen.size, geometry, pose, lights)
    told = _told(Path(name).stem, geometry, glass, fill, seen.notes)
    return Scene(
        bodies=bodies(geometry, fill, pose),
        media=media(geometry, glass, fill),
        lights=lights,
        camera=seen.camera,
        size=seen.size,
        metadata=told | image_scale(seen.camera, seen.size).to_metadata(),
    )


def _files() -> dict[str, Path]:
    """Return the files of the catalogue by the stations' names, the studio first; the user's own come last."""
    own = user_folder("stations")
    found = sorted((RESOURCES / "stations").glob(f"*{ENDING}"), key=lambda path: (path.stem != "studio", path.stem))
    return {path.stem: path for path in [*found, *sorted(own.glob(f"*{ENDING}"))]}


def _file(name: str) -> Path:
    if str(name).endswith(ENDING):
        return Path(name)
    files = _files()
    if name not in files:
        raise unknown_name("station", name, files)
    return files[name]


def _settings(path: Path) -> Mapping:
    settings = read_toml(path)
    check_keys(settings, ("description", "camera", "light"), ("container",), f"station {path.stem}")
    if not isinstance(settings["light"], list):
        raise InputError(f"{path}: write [[light]] with two brackets, one such table for each light")
    return settings


@contextmanager
def _named(name: str) -> Iterator[None]:
    """Put the station before the message of an InputError."""
    try:
        yield
    except InputError as error:
        raise InputError(f"station {name}: {error}") from error


def _pose(table: Mapping) -> Pose:
    check_keys(table, (), Pose.__dataclass_fields__, "container")
    return Pose(**table)


def _told(
    name: str, geometry: ContainerGeometry, glass: Glass, fill: Fill | None, notes: tuple[str, ...]
) -> dict[str, str]:
    told = {"glass": glass.name, "station": name}
    if fill:
        told["fill"] = str(fill)
    if geometry.notes or notes:
        told["notes"] = "; ".join([*geometry.notes, *notes])
    return told
