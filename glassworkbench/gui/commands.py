"""The workbench's commands, as its menu and toolbar offer them."""

from __future__ import annotations

from typing import Any

import FreeCAD
import FreeCADGui
from PySide.QtCore import QT_TRANSLATE_NOOP

from glassworkbench.document.container import is_container, make_container, set_glass, set_wall
from glassworkbench.document.render import is_render, make_render
from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.gui import preferences
from glassworkbench.gui.container_panel import ContainerPanel, ContainerSettings
from glassworkbench.gui.feedback import busy, one_step, show_error, translate
from glassworkbench.gui.glass_panel import GlassPanel
from glassworkbench.gui.image_windows import WindowCloser, show_render
from glassworkbench.gui.render_panel import RenderPanel
from glassworkbench.settings import RESOURCES


def register() -> list[str]:
    """Make the commands known to FreeCAD and return their names in the order of menu and toolbar."""
    preferences.use_glass_folder()
    FreeCAD.addDocumentObserver(WindowCloser())
    commands = {
        "Glass_MakeContainer": MakeContainer(),
        "Glass_EditContainer": EditContainer(),
        "Glass_SetGlass": SetGlass(),
        "Glass_ShowWall": ShowWall(),
        "Glass_Render": Render(),
    }
    for name, command in commands.items():
        FreeCADGui.addCommand(name, command)
    return list(commands)


class _Command:
    """A command for the one object that is selected."""

    icon: str
    menu_text: str
    tool_tip: str

    def GetResources(self) -> dict[str, str]:  # noqa: N802 (FreeCAD's name)
        """Return what menu and toolbar show."""
        icon = RESOURCES / "icons" / self.icon
        return {"MenuText": self.menu_text, "ToolTip": self.tool_tip, "Pixmap": str(icon)}

    def IsActive(self) -> bool:  # noqa: N802 (FreeCAD's name)
        """Return whether the command can do something with the selection."""
        selected = FreeCADGui.Selection.getSelection()
        return len(selected) == 1 and self.accepts(selected[0]) and not FreeCADGui.Control.activeDialog()

    def Activated(self) -> None:  # noqa: N802 (FreeCAD's name)
        """Run; FreeCAD calls it when the user asks."""
        try:
            self.run(FreeCADGui.Selection.getSelection()[0])
        except GlassWorkbenchError as error:
            show_error(error)

    def accepts(self, obj: Any) -> bool:
        """Return whether the command is for such an object."""
        raise NotImplementedError

    def run(self, obj: Any) -> None:
        """Do the work."""
        raise NotImplementedError


class MakeContainer(_Command):
    """Asks for the wall and makes a container of a solid."""

    icon = "Glass_MakeContainer.svg"
    menu_text = QT_TRANSLATE_NOOP("Glass_MakeContainer", "Make container…")
    tool_tip = QT_TRANSLATE_NOOP(
        "Glass_MakeContainer",
        "Hollow the selected solid, the outside of a container, to the wall thickness you ask for",
    )

    def accepts(self, obj: Any) -> bool:
        """Return whether the object holds a solid to hollow, or those of a mold block."""
        return obj.isDerivedFrom("Part::Feature") and not is_container(obj) and bool(obj.Shape.Solids)

    def run(self, obj: Any) -> None:
        """Open the panel."""
        settings = ContainerSettings(
            preferences.number("WallThickness", 3.0),
            preferences.text("Wall", ""),
            "Outer shape" if len(obj.Shape.Solids) == 1 else "Mold block",
            "auto",
            preferences.text("Glass", "flint"),
        )
        title = translate("Glass_MakeContainer", "Container from {}").format(obj.Label)
        FreeCADGui.Control.showDialog(ContainerPanel(title, settings, lambda chosen: self._make(obj, chosen)))

    def _make(self, obj: Any, chosen: ContainerSettings) -> None:
        with one_step(obj.Document, translate("Glass_MakeContainer", "Make container")), _hollowing():
            container = make_container(
                obj,
                chosen.wall or chosen.thickness_mm,
                chosen.glass,
                chosen.method,
                mold_kind=chosen.mold_kind,
            )
        preferences.remember_number("WallThickness", chosen.thickness_mm)
        preferences.remember_text("Wall", chosen.wall)
        preferences.remember_text("Glass", chosen.glass)
        _select(container)


class EditContainer(_Command):
    """Changes wall and glass of a container; a double-click in the tree runs it too."""

    icon = "Container.svg"
    menu_text = QT_TRANSLATE_NOOP("Glass_EditContainer", "Edit container…")
    tool_tip = QT_TRANSLATE_NOOP("Glass_EditContainer", "Change the wall and the glass of the selected container")

    def accepts(self, obj: Any) -> bool:
        """Return whether the object is a container."""
        return is_container(obj)

    def run(self, obj: Any) -> None:
        """Open the panel."""
        settings = ContainerSettings(obj.WallThickness.Value, obj.Wall, obj.MoldKind, obj.Method, obj.Glass)
        FreeCADGui.Control.showDialog(ContainerPanel(obj.Label, settings, lambda chosen: self._change(obj, chosen)))

    def _change(self, obj: Any, chosen: ContainerSettings) -> None:
        with one_step(obj.Document, translate("Glass_EditContainer", "Edit container")), _hollowing():
            set_wall(obj, chosen.thickness_mm)
            if chosen.wall:
                set_wall(obj, chosen.wall)
            obj.MoldKind, obj.Method = chosen.mold_kind, chosen.method
            set_glass(obj, chosen.glass)
            obj.Document.recompute()
            if obj.Fault:
                raise GlassWorkbenchError(obj.Fault)


class SetGlass(_Command):
    """Chooses the glass of a container."""

    icon = "Glass_SetGlass.svg"
    menu_text = QT_TRANSLATE_NOOP("Glass_SetGlass", "Glass…")
    tool_tip = QT_TRANSLATE_NOOP("Glass_SetGlass", "Choose the glass that the selected container is made of")

    def accepts(self, obj: Any) -> bool:
        """Return whether the object is a container."""
        return is_container(obj)

    def run(self, obj: Any) -> None:
        """Open the panel."""
        FreeCADGui.Control.showDialog(GlassPanel(obj))


class ShowWall(_Command):
    """Colours a container by the thickness of its wall, or shows it as before."""

    icon = "Glass_ShowWall.svg"
    menu_text = QT_TRANSLATE_NOOP("Glass_ShowWall", "Show wall")
    tool_tip = QT_TRANSLATE_NOOP(
        "Glass_ShowWall", "Colour the selected container by the thickness of its wall, or show it as before"
    )

    def accepts(self, obj: Any) -> bool:
        """Return whether the object is a container."""
        return is_container(obj)

    def run(self, obj: Any) -> None:
        """Switch the display mode."""
        with busy(translate("Glass_ShowWall", "Measuring the wall…")):
            obj.ViewObject.Proxy.toggle_wall()


class Render(_Command):
    """Shows a container, or a render object again, as light shows it."""

    icon = "Glass_Render.svg"
    menu_text = QT_TRANSLATE_NOOP("Glass_Render", "Render…")
    tool_tip = QT_TRANSLATE_NOOP(
        "Glass_Render", "Show the selected container as light shows it, in a window beside the 3D view"
    )

    def accepts(self, obj: Any) -> bool:
        """Return whether the object is a container or a render object."""
        return is_container(obj) or is_render(obj)

    def run(self, obj: Any) -> None:
        """Open the panel for a container; trace a render object at once, as its properties say."""
        if is_render(obj):
            show_render(obj)
            return
        title = translate("Glass_Render", "Picture of {}").format(obj.Label)
        FreeCADGui.Control.showDialog(RenderPanel(title, lambda **chosen: self._make(obj, chosen)))

    def _make(self, container: Any, chosen: dict[str, Any]) -> None:
        with one_step(container.Document, translate("Glass_Render", "Render")):
            obj = make_render(container, **chosen)
        show_render(obj)


def _hollowing() -> Any:
    return busy(translate("Glass_MakeContainer", "Hollowing the container…"))


def _select(obj: Any) -> None:
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(obj)
