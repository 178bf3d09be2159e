"""The scene file (TOML): any scene without FreeCAD."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.glass import find_filling, find_glass
from glassworkbench.scene.bodies import Body, Ellipsoid, Revolved, Surface
from glassworkbench.scene.cameras import Camera, Pinhole, Telecentric
from glassworkbench.scene.lights import Environment, Light, Panel
from glassworkbench.scene.media import Medium
from glassworkbench.scene.mesh import Mesh
from glassworkbench.scene.meshes import read_mesh
from glassworkbench.scene.placing import placed, rotation
from glassworkbench.scene.scene import Scene
from glassworkbench.scene.validate import file_path, finite, finite_array, unit_vector
from glassworkbench.settings import check_keys, read_toml, unknown_name


def read_scene(path: str | Path, read_step: Callable[[Path], Surface] | None = None) -> Scene:
    """Return the scene that a TOML file describes; `docs/cli.md` lists its keys.

    Parameters
    ----------
    path : str or Path
        Files that the scene names are found relative to this one.
    read_step : callable, optional
        Reads the surface of a body given as ``step = "x.step"``, which takes FreeCAD.

    Raises
    ------
    InputError
        If a file is missing or a key misspelt, absent or impossible; the message names it.
    """
    path = file_path(path)
    tables = read_toml(path)
    check_keys(tables, ("camera", "light"), ("image", "body", "medium", "metadata"), str(path))
    reader = _Reader(path.parent, read_step)
    with _named(path):
        size = tables.get("image", {})
        check_keys(size, (), ("size",), "image")
        metadata = {str(key): str(value) for key, value in tables.get("metadata", {}).items()}
        return Scene(
            bodies=tuple(reader.body(table) for table in _list(tables, "body")),
            media=tuple(_medium(table) for table in _list(tables, "medium")),
            lights=tuple(reader.light(table) for table in _list(tables, "light")),
            camera=_camera(tables["camera"]),
            size=_size(size.get("size", (480, 640))),
            metadata={"scene": path.name} | metadata,
        )


@contextmanager
def _named(what: object) -> Iterator[None]:
    """Put `what` before the message of an InputError."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{what}: {error}") from error


def _list(tables: Mapping, key: str) -> list:
    entries = tables.get(key, [])
    if not isinstance(entries, list):
        raise InputError(f"{key}: write [[{key}]] with two brackets, one such table for each {key}")
    return entries


def _size(value: object) -> tuple[int, int]:
    width, height = finite_array(value, (2,), "image size")
    if width != int(width) or height != int(height):
        raise InputError(f"image size: expected whole numbers of pixels, got {value!r}")
    return int(width), int(height)


def _camera(table: Mapping) -> Camera:
    kinds = {"pinhole": "vertical_fov_deg", "telecentric": "height"}
    kind = table.get("kind")
    if kind not in kinds:
        raise unknown_name("camera: kind", kind, kinds)
    check_keys(table, ("kind", "origin", "target", kinds[kind]), ("up",), "camera")
    up = table.get("up", (0.0, 0.0, 1.0))
    extent = finite(table[kinds[kind]], f"camera {kinds[kind]}")
    if kind == "telecentric":
        return Telecentric(table["origin"], table["target"], extent, up)
    return Pinhole(table["origin"], table["target"], np.radians(extent), up)


def _medium(table: Mapping) -> Medium:
    where = table.get("where", "")
    with _named(f"medium where {where!r}" if where else "medium"):
        if "glass" in table or "filling" in table:
            kind, find = ("glass", find_glass) if "glass" in table else ("filling", find_filling)
            check_keys(table, ("where", kind), (), "medium")
            return Medium.of(where, find(table[kind]))
        check_keys(table, ("where", "refractive_index"), ("absorption_per_mm", "glass", "filling"), "medium")
        return Medium(where, table["refractive_index"], table.get("absorption_per_mm", (0.0, 0.0, 0.0)))


@dataclass(frozen=True)
class _Reader:
    """Makes bodies and lights from their tables, with files found in `folder`."""

    folder: Path
    read_step: Callable[[Path], Surface] | None

    def body(self, table: Mapping) -> Body:
        name = str(table.get("name", ""))
        with _named(f"body {name!r}"):
            shapes = {"meridian": self._meridian, "mesh": self._mesh, "ellipsoid": _ellipsoid, "step": self._step}
            check_keys(table, ("name",), (*shapes, "placement"), "it")
            given = [shape for shape in shapes if shape in table]
            if len(given) != 1:
                raise InputError(f"give it one of {', '.join(shapes)}; it has {' and '.join(given) or 'none'}")
            surface = shapes[given[0]](table[given[0]])
            return Body(name, _placed(surface, table["placement"]) if "placement" in table else surface)

    def light(self, table: Mapping) -> Light:
        kind = table.get("kind")
        if kind == "panel":
            check_keys(table, ("kind", "origin", "u", "v"), ("radiance",), "light panel")
            return Panel(table["origin"], table["u"], table["v"], table.get("radiance", 1.0))
        if kind != "environment":
            raise unknown_name("light: kind", kind, ("panel", "environment"))
        check_keys(table, ("kind",), ("image", "radiance"), "light environment")
        if ("image" in table) == ("radiance" in table):
            raise InputError("light environment: give it either an image or a radiance")
        if "radiance" in table:
            return Environment(table["radiance"])
        # Only a scene with a picture in it needs OpenImageIO.
        from glassworkbench.images import read_image

        return Environment(read_image(self.folder / table["image"]).pixels)

    def _meridian(self, name: str) -> Revolved:
        return Revolved(read_meridian(self.folder / name))

    def _mesh(self, name: str) -> Mesh:
        return read_mesh(self.folder / name)

    def _step(self, name: str) -> Surface:
        if self.read_step is None:
            raise InputError("step: reading it takes FreeCAD; run bin/glassworkbench render")
        return self.read_step(self.folder / name)


def read_meridian(path: str | Path) -> np.ndarray:
    """Return the meridian (n, 4, 3) of a CSV file, as `Revolved` takes it.

    One row a segment: r0,z0,...,r3,z3 in mm, or r0,z0,weight0,...,r3,z3,weight3; lines that start with # are notes.

    Raises
    ------
    InputError
        If the file is missing or a row has not 8 or 12 numbers.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: there is no such file; check the path")
    rows = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            rows.append([float(cell) for cell in line.split(",")])
        except ValueError as error:
            raise InputError(f"{path}: line {number} is not numbers separated by commas") from error
        if len(rows[-1]) not in (8, 12) or len(rows[-1]) != len(rows[0]):
            raise InputError(
                f"{path}: line {number} has {len(rows[-1])} numbers; each needs 8, or each 12 with weights"
            )
    points = np.array(rows).reshape(len(rows), 4, -1) if rows else np.zeros((0, 4, 3))
    return points if points.shape[2] == 3 else np.concatenate([points, np.ones((len(rows), 4, 1))], axis=2)


def _ellipsoid(table: Mapping) -> Ellipsoid:
    check_keys(table, ("centre", "semi_axes"), (), "ellipsoid")
    return Ellipsoid(table["centre"], table["semi_axes"])


def _placed(surface: Surface, table: Mapping) -> Surface:
    """Return the surface turned about an axis through the origin, then moved."""
    check_keys(table, (), ("position", "axis", "angle_deg"), "placement")
    position = finite_array(table.get("position", (0.0, 0.0, 0.0)), (3,), "placement position")
    axis = unit_vector(table.get("axis", (0.0, 0.0, 1.0)), "placement axis")
    turn = rotation(axis, np.radians(finite(table.get("angle_deg", 0.0), "placement angle_deg")))
    return placed(surface, turn, position)
