"""The task panel that asks for the wall and the glass of a container."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import FreeCADGui

from glassworkbench.document.container import MOLD_KINDS
from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.gui.feedback import show_error, translate
from glassworkbench.gui.glass_list import GlassList
from glassworkbench.gui.qt import QtWidgets
from glassworkbench.wall import METHODS


@dataclass(frozen=True)
class ContainerSettings:
    """What the panel asks for.

    Parameters
    ----------
    thickness_mm : float
    wall : str
        The wall as text, overrules `thickness_mm` when not empty.
    mold_kind, method, glass : str
    """

    thickness_mm: float
    wall: str
    mold_kind: str
    method: str
    glass: str


class ContainerPanel:
    """Asks for the settings; `apply` does what they are for, and the panel stays open if that fails."""

    def __init__(self, title: str, settings: ContainerSettings, apply: Callable[[ContainerSettings], None]) -> None:
        self._apply = apply
        self._thickness = FreeCADGui.UiLoader().createWidget("Gui::QuantitySpinBox")
        self._thickness.setObjectName("thickness")
        self._thickness.setProperty("unit", "mm")
        self._thickness.setProperty("minimum", 0.0)
        self._thickness.setProperty("rawValue", settings.thickness_mm)
        self._wall = QtWidgets.QLineEdit(settings.wall)
        self._wall.setObjectName("wall")
        self._wall.setPlaceholderText("finish=2.5 neck=3 body=2 base=5")
        self._wall.setToolTip(
            translate(
                "Glass",
                "In mm by region (finish, neck, shoulder, body, heel, base), or over height as 0:5 40:2 300:3, or from "
                "a table as @walls.csv, or by face as Face12=4 else=2; bore=18.5 may be added. Empty: uniform",
            )
        )
        self._mold_kind = QtWidgets.QComboBox()
        self._mold_kind.setObjectName("mold_kind")
        self._mold_kind.addItems(list(MOLD_KINDS))
        self._mold_kind.setCurrentText(settings.mold_kind)
        self._method = QtWidgets.QComboBox()
        self._method.setObjectName("method")
        self._method.addItems(list(METHODS))
        self._method.setCurrentText(settings.method)
        self._glass = GlassList(settings.glass)

        self.form = QtWidgets.QWidget()
        self.form.setWindowTitle(title)
        rows = QtWidgets.QFormLayout(self.form, rowWrapPolicy=QtWidgets.QFormLayout.WrapAllRows)
        rows.addRow(translate("Glass", "The selected solid is"), self._mold_kind)
        rows.addRow(translate("Glass", "Wall thickness"), self._thickness)
        rows.addRow(translate("Glass", "Wall that varies"), self._wall)
        rows.addRow(translate("Glass", "Method"), self._method)
        rows.addRow(translate("Glass", "Glass"), self._glass)

    def accept(self) -> bool:
        """Apply the settings and close; FreeCAD calls it on OK."""
        settings = ContainerSettings(
            thickness_mm=float(self._thickness.property("rawValue")),
            wall=self._wall.text().strip(),
            mold_kind=self._mold_kind.currentText(),
            method=self._method.currentText(),
            glass=self._glass.chosen(),
        )
        try:
            self._apply(settings)
        except GlassWorkbenchError as error:
            show_error(error)
            return False
        FreeCADGui.Control.closeDialog()
        return True

    def reject(self) -> bool:
        """Close; FreeCAD calls it on Cancel."""
        FreeCADGui.Control.closeDialog()
        return True
