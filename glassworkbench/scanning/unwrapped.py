"""The image of a line camera before which a container turns once: angle from left to right, height upwards."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.glass import Glass
from glassworkbench.images import Image
from glassworkbench.scene import ContainerGeometry, Revolved, Scene
from glassworkbench.scene.image_scale import ImageScale
from glassworkbench.staging import Fill, Pose, station
from glassworkbench.tracer import render

USUAL_STATION = "unwrapped"
SCALE_KEYS = tuple(ImageScale.__dataclass_fields__)


def unwrapped(
    geometry: ContainerGeometry,
    glass: Glass | str,
    fill: Fill | str | None = None,
    *,
    name: str = USUAL_STATION,
    lines: int,
    rows: int | None = None,
    **options: object,
) -> Image:
    """Render what a line camera sees of a container that turns once.

    The column k of n shows the container's angle a + 360 (k + 1/2) / n, a being where the camera stands. A body of
    revolution looks the same at every angle: one column is traced.

    Parameters
    ----------
    geometry, glass, fill
        As `glassworkbench.staging.station` takes them.
    name : str
        A station whose camera is of the kind ``line``.
    lines : int
        Columns of the image, for one turn.
    rows : int, optional
        Pixels of the camera; as the station has it where not given.
    **options
        As `glassworkbench.tracer.render` takes them, for each column: tolerance, threads, effects, cancel, progress.

    Raises
    ------
    InputError
        If the station has no line camera, there are no lines, or as `station` and `render`.
    """
    if not isinstance(lines, int) or lines < 1:
        raise InputError(f"lines: expected a whole number above 0, got {lines!r}")
    size = None if rows is None else (1, rows)
    first = station(name, geometry, glass, fill, size)
    if first.size[0] != 1:
        raise InputError(f"station {name}: its camera sees an area; take a station with a camera of kind line")
    if _is_round(first):
        return _joined([render(first, **options)] * lines, first.metadata)
    pose = Pose()
    columns = []
    for line in range(lines):
        turned = dataclasses.replace(pose, rotation_deg=-360.0 * (line + 0.5) / lines)
        columns.append(render(station(name, geometry, glass, fill, size, turned), **options))
    return _joined(columns, first.metadata)


def _is_round(scene: Scene) -> bool:
    """Tell whether all bodies turn about the axis of the container."""
    return all(
        isinstance(body.surface, Revolved)
        and np.allclose(body.surface.axis[:2], 0.0, atol=1e-12)
        and np.allclose(body.surface.base_mm[:2], 0.0, atol=1e-12)
        for body in scene.bodies
    )


def _joined(columns: list[Image], metadata: Mapping[str, str]) -> Image:
    """Return the image whose columns these are; the report is that of the first, with all their seconds."""
    distinct = {id(column): column for column in columns}.values()
    report = dict(columns[0].report)
    report["seconds"] = sum(column.report["seconds"] for column in distinct)
    report["size"] = [len(columns), len(columns[0].pixels)]
    return Image(
        np.concatenate([column.pixels for column in columns], axis=1),
        np.concatenate([column.certificate for column in columns], axis=1),
        np.concatenate([column.depth_mm for column in columns], axis=1),
        # Pixels to a millimetre are those of an image from the side.
        {key: value for key, value in metadata.items() if key not in SCALE_KEYS},
        report,
    )
