"""The task panel that asks for the wall and the glass of a container."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import FreeCADGui

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
    regions : str
        Thickness by region, overrules `thickness_mm` when not empty.
    method, glass : str
    """

    thickness_mm: float
    regions: str
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
        self._regions = QtWidgets.QLineEdit(settings.regions)
        self._regions.setObjectName("regions")
        self._regions.setPlaceholderText("finish=2.5 neck=3 body=2 base=5")
        self._regions.setToolTip(
            translate("Glass", "Thickness in mm by region: finish, neck, shoulder, body, heel, base; empty: the same")
        )
        self._method = QtWidgets.QComboBox()
        self._method.setObjectName("method")
        self._method.addItems(list(METHODS))
        self._method.setCurrentText(settings.method)
        self._glass = GlassList(settings.glass)

        self.form = QtWidgets.QWidget()
        self.form.setWindowTitle(title)
        rows = QtWidgets.QFormLayout(self.form, rowWrapPolicy=QtWidgets.QFormLayout.WrapAllRows)
        rows.addRow(translate("Glass", "Wall thickness"), self._thickness)
        rows.addRow(translate("Glass", "By region"), self._regions)
        rows.addRow(translate("Glass", "Method"), self._method)
        rows.addRow(translate("Glass", "Glass"), self._glass)

    def accept(self) -> bool:
        """Apply the settings and close; FreeCAD calls it on OK."""
        settings = ContainerSettings(
            thickness_mm=float(self._thickness.property("rawValue")),
            regions=self._regions.text().strip(),
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
