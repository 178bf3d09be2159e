"""How the objects show in FreeCAD's tree and 3D view; double-clicking runs a command of the workbench."""

from __future__ import annotations

from typing import Any

import numpy as np

from glassworkbench.document.appearance import colour, transparency_percent
from glassworkbench.document.ray_view import ray_node
from glassworkbench.document.wall_legend import legend_node
from glassworkbench.document.wall_view import wall_node
from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import FreeCAD
from glassworkbench.glass import catalogue
from glassworkbench.settings import RESOURCES
from glassworkbench.tracer.path import RayPath

ICONS = RESOURCES / "icons"

RAY = "Ray"
"""The display mode of a picture: the path of the ray that was followed in it."""

WALL = "Wall"
"""The display mode that shows a container in the colours of its wall's thickness."""


class _View:
    def __init__(self, view: Any) -> None:
        view.Proxy = self

    def attach(self, view: Any) -> None:
        """Remember the document object; called on creation and on load."""
        self.Object = view.Object

    def dumps(self) -> None:
        """Return what is saved besides the properties: nothing."""

    def loads(self, state: None) -> None:
        """Accept what `dumps` returned."""

    # FreeCAD 0.20 asks for the pickle protocol's names.
    __getstate__ = dumps
    __setstate__ = loads


class ContainerView(_View):
    """A container in the tree with its mold below it, coloured like its glass."""

    def attach(self, view: Any) -> None:
        """Add a way to show it: the colours of its wall."""
        from pivy import coin

        super().attach(view)
        self._wall = coin.SoGroup()
        self._place = 0
        self._shows_wall = False
        self._before_wall = "Flat Lines"
        view.addDisplayMode(self._wall, WALL)

    def getDisplayModes(self, view: Any) -> list[str]:  # noqa: N802 (FreeCAD's name)
        """Return the ways to show it besides those of any shape."""
        return [WALL]

    def setDisplayMode(self, mode: str) -> str:  # noqa: N802 (FreeCAD's name)
        """Draw the wall when it is to be shown."""
        self._shows_wall = mode == WALL and not self.Object.Document.Restoring
        if mode != WALL:
            self._before_wall = mode
            return mode
        if not self._shows_wall:
            # The wall is not in the file, and nobody wants to wait for it while the document opens.
            return self._before_wall
        self._place = self._free_place()
        self._draw_wall()
        return mode

    def toggle_wall(self) -> None:
        """Show the wall, or what was shown before.

        Raises
        ------
        GlassWorkbenchError
            If the container has a fault, so that there is no wall to show.
        """
        view = self.Object.ViewObject
        if self._shows_wall:
            view.DisplayMode = self._before_wall
            return
        if self.Object.Fault:
            raise GlassWorkbenchError(f"{self.Object.Label}: {self.Object.Fault}")
        view.DisplayMode = WALL

    def _free_place(self) -> int:
        """Return the leftmost place for a legend that no other container's takes."""
        proxies = [getattr(obj.ViewObject, "Proxy", None) for obj in self.Object.Document.Objects]
        views = [proxy for proxy in proxies if isinstance(proxy, ContainerView) and proxy is not self]
        taken = {view._place for view in views if view._shows_wall}
        return next(place for place in range(len(taken) + 1) if place not in taken)

    def _draw_wall(self) -> None:
        self._wall.removeAllChildren()
        if self.Object.Fault or self.Object.Shape.isNull():
            return
        try:
            container = self.Object.Proxy.container(self.Object)
        except GlassWorkbenchError as error:
            FreeCAD.Console.PrintError(f"{self.Object.Label}: {error}\n")
            return
        wall = container.map()
        self._wall.addChild(wall_node(wall, container.mold.placement))
        self._wall.addChild(legend_node(*wall.span_mm(), self._place))

    def getIcon(self) -> str:  # noqa: N802 (FreeCAD's name)
        """Return the icon that says whether the shape is up to date."""
        return str(ICONS / ("Container_Fault.svg" if self.Object.Fault else "Container.svg"))

    def claimChildren(self) -> list:  # noqa: N802 (FreeCAD's name)
        """Return what the tree shows below the container."""
        return [self.Object.Source] if self.Object.Source else []

    def updateData(self, obj: Any, name: str) -> None:  # noqa: N802 (FreeCAD's name)
        """Take over the colour of a new glass, and the sign of a fault."""
        if obj.Document.Restoring:
            return
        if name == "Glass" and obj.Glass in catalogue():
            glass = catalogue()[obj.Glass]
            obj.ViewObject.ShapeColor = colour(glass)
            obj.ViewObject.Transparency = transparency_percent(glass)
        elif name == "Fault":
            obj.ViewObject.signalChangeIcon()
        elif name == "MinimumWallAt" and self._shows_wall:
            self._draw_wall()

    def doubleClicked(self, view: Any) -> bool:  # noqa: N802 (FreeCAD's name)
        """Open the panel that changes wall and glass."""
        return _run("Glass_EditContainer", view.Object)


class RenderView(_View):
    """A picture in the tree; the ray that was followed in it, in the 3D view."""

    def attach(self, view: Any) -> None:
        """Add the way to show it: the path of a ray, none at first."""
        from pivy import coin

        super().attach(view)
        self._ray = coin.SoGroup()
        view.addDisplayMode(self._ray, RAY)

    def getDisplayModes(self, view: Any) -> list[str]:  # noqa: N802 (FreeCAD's name)
        """Return the ways to show it."""
        return [RAY]

    def getDefaultDisplayMode(self) -> str:  # noqa: N802 (FreeCAD's name)
        """Return the only one."""
        return RAY

    def setDisplayMode(self, mode: str) -> str:  # noqa: N802 (FreeCAD's name)
        """Return the mode as it is."""
        return mode

    def show_ray(self, path: RayPath, placement: np.ndarray) -> None:
        """Draw the path of a ray in place of the one before; `placement` (4, 4) takes it to the document."""
        self._ray.removeAllChildren()
        self._ray.addChild(ray_node(path, placement))

    def getIcon(self) -> str:  # noqa: N802 (FreeCAD's name)
        """Return the icon's path."""
        return str(ICONS / "Glass_Render.svg")

    def isShow(self) -> bool:  # noqa: N802 (FreeCAD's name)
        """Return True: nothing of it can be hidden in the 3D view, so the tree need not grey it out."""
        return True

    def doubleClicked(self, view: Any) -> bool:  # noqa: N802 (FreeCAD's name)
        """Show the picture."""
        return _run("Glass_Render", view.Object)


def _run(command: str, obj: Any) -> bool:
    import FreeCADGui

    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(obj)
    FreeCADGui.runCommand(command)
    return True
