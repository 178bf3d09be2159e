"""The render object: which container, seen in which station, how accurately."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from glassworkbench.document.container import is_container, wall_text
from glassworkbench.document.properties import HIDDEN, OUTPUT, READ_ONLY, Property, add_properties, set_choices
from glassworkbench.errors import InputError
from glassworkbench.flaws import parse_defects, with_defects
from glassworkbench.freecad import FreeCAD
from glassworkbench.images import Image
from glassworkbench.scene import Scene
from glassworkbench.staging import check_station, parse_fill, stations
from glassworkbench.staging import station as place_in_station
from glassworkbench.tracer import render

SCHEMA_VERSION = 1
# Nothing is recomputed when they change: a picture is traced when the user asks for it.
PROPERTIES = (
    Property("App::PropertyLink", "Container", "Render", "What is seen", OUTPUT),
    Property("App::PropertyEnumeration", "Station", "Render", "Camera and light", OUTPUT),
    Property("App::PropertyString", "Fill", "Render", "What it holds, like water or water:120 (level in mm)", OUTPUT),
    Property(
        "App::PropertyString",
        "Defects",
        "Render",
        "What is wrong with the glass: a file that lists it, or a population and a seed, like seedy:1",
        OUTPUT,
    ),
    Property("App::PropertyInteger", "Width", "Render", "Of the image in pixels", OUTPUT, 480),
    Property("App::PropertyInteger", "Height", "Render", "Of the image in pixels", OUTPUT, 640),
    Property("App::PropertyPrecision", "Tolerance", "Render", "Accepted error, a fraction of white", OUTPUT, 0.02),
    Property("App::PropertyInteger", "SchemaVersion", "Base", "Of the saved properties", READ_ONLY | OUTPUT | HIDDEN),
)


def make_render(
    container: Any,
    station: str = "studio",
    tolerance: float = 0.02,
    size: tuple[int, int] = (480, 640),
    fill: str = "",
    document: Any = None,
) -> Any:
    """Add a render object to a document: a picture of a container; `render_image` traces it.

    Parameters
    ----------
    container : document object
        Made by `make_container`.
    station : str
        Name of the station, camera and light.
    tolerance : float
        Accepted error, as a fraction of white.
    size : (int, int)
        Width and height in pixels.
    fill : str
        What the container holds, like ``"water"`` or ``"water:120"`` (level in mm); empty for nothing.
    document : optional
        That of `container` if not given.

    Raises
    ------
    InputError
        If `container` is none, station or liquid is not known, or the size is impossible; the document is as before.
    """
    if not is_container(container):
        raise InputError(f"{container.Label}: not a container; make one of it first")
    check_station(station)
    if fill:
        parse_fill(fill)
    if min(size) < 1:
        raise InputError(f"size: {size[0]}x{size[1]} pixels is impossible; each side is at least 1")
    document = document or container.Document
    obj = document.addObject("App::FeaturePython", "Render")
    RenderFeature(obj)
    if FreeCAD.GuiUp:
        from glassworkbench.document.views import RenderView

        RenderView(obj.ViewObject)
    obj.Container = container
    obj.Station = station
    obj.Tolerance = tolerance
    obj.Width, obj.Height = size
    obj.Fill = fill
    obj.Label = f"{container.Label} {station}"
    obj.purgeTouched()
    return obj


def render_image(obj: Any, **options: Any) -> Image:
    """Return the image of a render object.

    Parameters
    ----------
    obj : document object
        Made by `make_render`.
    **options
        As for `glassworkbench.tracer.render`, like ``seconds=10``.

    Raises
    ------
    GlassWorkbenchError
        If the container has a fault, or tracing fails.
    """
    return render(scene(obj), **{"tolerance": obj.Tolerance} | options)


def scene(obj: Any) -> Scene:
    """Return what a render object shows as plain arrays that hold nothing of FreeCAD.

    Raises
    ------
    GlassWorkbenchError
        If the container is missing or has a fault.
    """
    container = _linked_container(obj)
    geometry = container.Proxy.geometry(container)
    seen = place_in_station(obj.Station, geometry, container.Glass, obj.Fill or None, (obj.Width, obj.Height))
    if obj.Defects:
        defects = parse_defects(obj.Defects)
        if defects.of_wall:
            raise InputError(
                f"{obj.Label}: {defects.of_wall[0]}: it is made with the wall; hollow it on the command line"
            )
        seen = with_defects(seen, geometry, defects.on(geometry))
    told = {"mold": container.Source.Label, "wall": wall_text(container)}
    return dataclasses.replace(seen, metadata={**seen.metadata, **told})


def placement(obj: Any) -> np.ndarray:
    """Return the matrix (4, 4) that takes a render object's scene to the coordinates of its document.

    Raises
    ------
    GlassWorkbenchError
        If the container is missing or has a fault.
    """
    container = _linked_container(obj)
    return container.Proxy.container(container).mold.placement


def is_render(obj: Any) -> bool:
    """Return whether a document object is a render object."""
    return isinstance(getattr(obj, "Proxy", None), RenderFeature)


class RenderFeature:
    """Proxy of an ``App::FeaturePython``: its hooks are called by FreeCAD."""

    def __init__(self, obj: Any) -> None:
        obj.Proxy = self
        self._complete(obj)

    def execute(self, obj: Any) -> None:
        """Do nothing: a picture takes too long for a recompute."""

    def onDocumentRestored(self, obj: Any) -> None:  # noqa: N802 (FreeCAD's name)
        """Give an object of an older version what it lacks."""
        self._complete(obj)

    def dumps(self) -> None:
        """Return what is saved besides the properties: nothing."""

    def loads(self, state: None) -> None:
        """Accept what `dumps` returned."""

    # FreeCAD 0.20 asks for the pickle protocol's names.
    __getstate__ = dumps
    __setstate__ = loads

    @staticmethod
    def _complete(obj: Any) -> None:
        add_properties(obj, PROPERTIES)
        set_choices(obj, "Station", stations())
        obj.SchemaVersion = SCHEMA_VERSION


def _linked_container(obj: Any) -> Any:
    if obj.Container is None:
        raise InputError(f"{obj.Label}: no container is linked; choose one in Container")
    return obj.Container
