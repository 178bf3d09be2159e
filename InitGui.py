"""FreeCAD runs this at the start of its window: it makes the workbench known, and imports nothing else."""

import FreeCADGui


class GlassWorkbench(FreeCADGui.Workbench):
    """Containers of glass: from the mold to the picture."""

    def __init__(self) -> None:
        # FreeCAD runs this file inside a function and without __file__: methods import what they need, and the place
        # of the package, found without importing it, tells where the resources are.
        from importlib.util import find_spec
        from pathlib import Path

        from FreeCAD import Qt

        resources = Path(find_spec("glassworkbench").origin).resolve().parent.parent / "resources"
        FreeCADGui.addLanguagePath(str(resources / "translations"))
        workbench = self.__class__
        workbench.Icon = str(resources / "icons" / "GlassWorkbench.svg")
        workbench.MenuText = Qt.translate("Workbench", "Glass")
        workbench.ToolTip = Qt.translate("Workbench", "Hollow glass containers and see them in the light")

    def Initialize(self) -> None:  # noqa: N802 (FreeCAD's name)
        """Load the commands; FreeCAD calls it when the workbench is first chosen."""
        from FreeCAD import Qt

        from glassworkbench.gui.commands import register

        commands = register()
        self.appendMenu(Qt.translate("Workbench", "&Glass"), commands)
        self.appendToolbar(Qt.translate("Workbench", "Glass"), commands)

    def GetClassName(self) -> str:  # noqa: N802 (FreeCAD's name)
        """Return the C++ class behind a workbench written in Python."""
        return "Gui::PythonWorkbench"


FreeCADGui.addWorkbench(GlassWorkbench())
