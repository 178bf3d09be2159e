"""The container object: hollows the solid it is linked to, again whenever mold or wall change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from glassworkbench.document.properties import HIDDEN, OUTPUT, READ_ONLY, Property, add_properties, set_choices
from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import FreeCAD
from glassworkbench.glass import catalogue, find_glass
from glassworkbench.mold import mold_from_shape
from glassworkbench.scene import ContainerGeometry
from glassworkbench.settings import unknown_name, user_glasses
from glassworkbench.wall import METHODS, Container, hollow
from glassworkbench.wall.asking.thickness_text import parse_thickness

SCHEMA_VERSION = 1

MOLD_KINDS = {
    "Outer shape": {},
    "Hollow container": {"outer_shell": True},
    "Mold block": {"block": True},
}
"""What a source may be: full inside; hollow already, so that its outside is the mold; the solids of a mold block."""

OPTIONS = {"outer_shell=True": "Mold Kind: Hollow container", "block=True": "Mold Kind: Mold block"}
"""What the mold's room calls by its name in Python, and how it is called here."""

RESULT = READ_ONLY | OUTPUT
PROPERTIES = (
    Property("App::PropertyLink", "Source", "Mold", "The solid whose outside is the container's outside"),
    Property(
        "App::PropertyEnumeration",
        "MoldKind",
        "Mold",
        "What the source is: a container's outer shape, a container whose outside is hollowed anew, or a mold block",
    ),
    Property("App::PropertyLength", "WallThickness", "Wall", "Wall thickness, the same everywhere", 0, 3.0),
    Property(
        "App::PropertyString",
        "Wall",
        "Wall",
        "Wall that varies, in mm, like finish=2.5 neck=3 body=2 base=5, or 0:5 40:2 300:3, or @wall.csv; "
        "overrules Wall Thickness when not empty",
    ),
    Property("App::PropertyEnumeration", "Method", "Wall", "How the cavity is found; auto takes the first that fits"),
    Property(
        "App::PropertyLength", "Tolerance", "Wall", "Accepted deviation from the wall asked for; 0 chooses by itself"
    ),
    Property("App::PropertyFloat", "TimeLimit", "Wall", "Seconds after which hollowing gives up", 0, 120.0),
    Property("App::PropertyEnumeration", "Glass", "Glass", "What the container is made of", OUTPUT),
    Property("App::PropertyString", "Fault", "Result", "Why the shape is not up to date; empty if it is", RESULT),
    Property("App::PropertyStringList", "Notes", "Result", "What you should know about the wall besides", RESULT),
    Property("App::PropertyString", "MethodUsed", "Result", "The method that made the cavity", RESULT),
    Property("App::PropertyFloat", "WeightGrams", "Result", "Weight of the empty container in g", RESULT),
    Property("App::PropertyVolume", "BrimfulCapacity", "Result", "What it holds, filled to the brim", RESULT),
    Property("App::PropertyVolume", "GlassVolume", "Result", "Volume of the glass", RESULT),
    Property("App::PropertyLength", "MinimumWall", "Result", "The thinnest place of the wall", RESULT),
    Property("App::PropertyPosition", "MinimumWallAt", "Result", "Where the wall is thinnest", RESULT),
    Property(
        "App::PropertyLength", "LargestDeviation", "Result", "From the wall asked for, at the worst place", RESULT
    ),
    Property("App::PropertyLength", "TypicalDeviation", "Result", "From the wall asked for, root mean square", RESULT),
    Property("App::PropertyPosition", "CentreOfGravity", "Result", "Of the empty container", RESULT),
    Property("App::PropertyInteger", "SchemaVersion", "Base", "Of the saved properties", RESULT | HIDDEN),
)


def make_container(
    source: Any,
    wall: float | str = 3.0,
    glass: str = "flint",
    method: str = "auto",
    document: Any = None,
    mold_kind: str = "Outer shape",
) -> Any:
    """Add a container to a document: the hollow form of a solid.

    Parameters
    ----------
    source : document object
        With a shape that holds one solid, the container's outside.
    wall : float or str
        Thickness in mm, or by region, like ``"finish=2.5 body=2 base=5"``.
    glass : str
        Name in the catalogue.
    method : str
        How the cavity is found, one of `glassworkbench.wall.METHODS`.
    document : optional
        That of `source` if not given.
    mold_kind : str
        What the source is, one of `MOLD_KINDS`.

    Returns
    -------
    document object
        Its ``Fault`` is empty.

    Raises
    ------
    InputError
        If the wall, the glass, the method or the source cannot be used; the document is as before.
    GlassWorkbenchError
        If no method finds the cavity; the document is as before.
    """
    parse_thickness(str(wall))
    _check_glass(glass)
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    if mold_kind not in MOLD_KINDS:
        raise unknown_name("mold_kind", mold_kind, tuple(MOLD_KINDS))
    document = document or source.Document
    obj = document.addObject("Part::FeaturePython", "Container")
    ContainerFeature(obj)
    if FreeCAD.GuiUp:
        from glassworkbench.document.views import ContainerView

        ContainerView(obj.ViewObject)
    obj.Source = source
    set_wall(obj, wall)
    set_glass(obj, glass)
    obj.Method = method
    obj.MoldKind = mold_kind
    obj.recompute()
    if obj.Fault:
        fault = obj.Fault
        document.removeObject(obj.Name)
        raise GlassWorkbenchError(fault)
    # Recomputed alone, an object stays touched, and the document's next recompute would hollow again.
    obj.purgeTouched()
    source.Visibility = False
    return obj


def set_wall(obj: Any, wall: float | str) -> None:
    """Ask for a wall thickness in mm, or by region; the next recompute makes it.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    parse_thickness(str(wall))
    try:
        obj.WallThickness = float(wall)
        obj.Wall = ""
    except ValueError:
        obj.Wall = wall


def wall_text(obj: Any) -> str:
    """Return the wall thickness that a container asks for, as `parse_thickness` reads it."""
    return obj.Wall or f"{obj.WallThickness.Value:.9g}"


def set_glass(obj: Any, glass: str) -> None:
    """Set what a container is made of, by a name of the catalogue.

    Raises
    ------
    InputError
        If the catalogue has no such glass.
    """
    _check_glass(glass)
    if glass not in obj.getEnumerationsOfProperty("Glass"):
        # It came into the user's folder after the object was made.
        set_choices(obj, "Glass", catalogue())
    obj.Glass = glass


def _check_glass(glass: str) -> None:
    find_glass(glass)
    if glass not in catalogue():
        raise InputError(
            f"glass {glass!r}: in a document it must be one of the catalogue; put its file into {user_glasses()}"
        )


def is_container(obj: Any) -> bool:
    """Return whether a document object is a container."""
    return isinstance(getattr(obj, "Proxy", None), ContainerFeature)


class ContainerFeature:
    """Proxy of a ``Part::FeaturePython``: its hooks are called by FreeCAD."""

    _made: _Made | None = None

    def __init__(self, obj: Any) -> None:
        obj.Proxy = self
        self._complete(obj)
        obj.SchemaVersion = SCHEMA_VERSION

    def execute(self, obj: Any) -> None:
        """Hollow the source; on failure keep the shape and say why in `Fault`."""
        try:
            # Undo, redo and a touched source ask for a recompute, too, without anything to do.
            if self._made is None or not self._made.is_what_is_asked(obj):
                self._made = _make(obj)
        except (GlassWorkbenchError, RuntimeError, ValueError) as error:
            # Raised on, FreeCAD would show the user a traceback; OCC's failures are RuntimeErrors.
            obj.Fault = str(error)
            FreeCAD.Console.PrintError(f"{obj.Label}: {error}\n")
            return
        obj.Shape = self._made.container.solid
        obj.Fault = ""
        obj.Notes = list(self._made.container.report.notes)
        for note in obj.Notes:
            FreeCAD.Console.PrintWarning(f"{obj.Label}: {note}\n")
        report = self._made.container.report.to_json()
        wall = report["wall"]
        obj.MethodUsed = report["method"]
        obj.GlassVolume = report["glass_volume_mm3"]
        obj.BrimfulCapacity = 1000.0 * report["brimful_ml"]
        obj.MinimumWall = wall["min_mm"]
        obj.MinimumWallAt = FreeCAD.Vector(*wall["min_at_mm"])
        obj.LargestDeviation = wall["deviation_max_mm"]
        obj.TypicalDeviation = wall["deviation_rms_mm"]
        obj.CentreOfGravity = FreeCAD.Vector(*report["centre_of_gravity_mm"])

    def onChanged(self, obj: Any, name: str) -> None:  # noqa: N802 (FreeCAD's name)
        """Keep the weight that of the glass."""
        if name not in ("Glass", "GlassVolume") or obj.Document.Restoring:
            return
        glass = catalogue().get(obj.Glass)
        if glass is not None:
            obj.WeightGrams = obj.GlassVolume.Value / 1000.0 * glass.density_g_per_cm3

    def geometry(self, obj: Any) -> ContainerGeometry:
        """Return the container as the tracer knows it; raises as `container`."""
        return self.container(obj).geometry()

    def container(self, obj: Any) -> Container:
        """Return what was made; hollows again after a reopening or an undo.

        Raises
        ------
        GlassWorkbenchError
            If the container has a fault.
        """
        if obj.Fault:
            raise GlassWorkbenchError(f"{obj.Label}: {obj.Fault}")
        if self._made is None or not obj.Shape.isPartner(self._made.container.solid):
            self._made = _make(obj)
        return self._made.container

    def onDocumentRestored(self, obj: Any) -> None:  # noqa: N802 (FreeCAD's name)
        """Give an object of an older version what it lacks."""
        if obj.SchemaVersion > SCHEMA_VERSION:
            FreeCAD.Console.PrintWarning(
                f"{obj.Label}: saved by a newer GlassWorkbench; update it if something is missing\n"
            )
            return
        self._complete(obj)
        obj.SchemaVersion = SCHEMA_VERSION

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
        set_choices(obj, "Method", METHODS)
        set_choices(obj, "MoldKind", MOLD_KINDS)
        set_choices(obj, "Glass", catalogue())


@dataclass(frozen=True, eq=False)
class _Made:
    """A container and what was asked for when it was made."""

    source: Any
    kind: str
    wall: str
    method: str
    tolerance_mm: float
    container: Container

    def is_what_is_asked(self, obj: Any) -> bool:
        """Return whether hollowing again would give the same."""
        asked = (obj.MoldKind, wall_text(obj), obj.Method, obj.Tolerance.Value)
        return (
            asked == (self.kind, self.wall, self.method, self.tolerance_mm)
            and obj.Source is not None
            and obj.Source.Shape.isSame(self.source)
        )


def _make(obj: Any) -> _Made:
    if obj.Source is None:
        raise InputError("Source: no mold is linked; choose the solid to hollow")
    shape, wall, tolerance_mm = obj.Source.Shape, wall_text(obj), obj.Tolerance.Value
    try:
        mold = mold_from_shape(shape, obj.Source.Label, **MOLD_KINDS[obj.MoldKind])
    except InputError as error:
        told = str(error)
        for option, words in OPTIONS.items():
            told = told.replace(option, words)
        raise InputError(f"{obj.Source.Label}: {told}") from error
    container = hollow(mold, wall, method=obj.Method, tolerance_mm=tolerance_mm or None, seconds=obj.TimeLimit)
    return _Made(shape, obj.MoldKind, wall, obj.Method, tolerance_mm, container)
