"""The task panel that asks how a container shall be seen."""

from __future__ import annotations

from collections.abc import Callable

import FreeCADGui

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.gui import preferences
from glassworkbench.gui.feedback import show_error, translate
from glassworkbench.gui.qt import QtWidgets
from glassworkbench.staging import stations

LARGEST_SIDE_PIXELS = 8192


class RenderPanel:
    """Asks for station, filling, size and tolerance, and remembers them; `apply` takes them as keywords."""

    def __init__(self, title: str, apply: Callable[..., None]) -> None:
        self._apply = apply
        self._station = QtWidgets.QComboBox()
        self._station.setObjectName("station")
        for name, description in stations().items():
            self._station.addItem(name)
            self._station.setItemData(self._station.count() - 1, description, 3)
        self._station.setCurrentText(preferences.text("Station", "studio"))
        self._fill = QtWidgets.QLineEdit(preferences.text("Fill", ""))
        self._fill.setObjectName("fill")
        self._fill.setPlaceholderText("water:120")
        self._width = _side("width", preferences.number("Width", 480))
        self._height = _side("height", preferences.number("Height", 640))
        self._tolerance = QtWidgets.QDoubleSpinBox(suffix=" %", decimals=2, minimum=0.01, maximum=50.0, singleStep=0.5)
        self._tolerance.setObjectName("tolerance")
        self._tolerance.setValue(100.0 * preferences.number("Tolerance", 0.02))
        self._tolerance.setToolTip(translate("Glass_Render", "Accepted error, as a part of white: less takes longer"))

        self.form = QtWidgets.QWidget()
        self.form.setWindowTitle(title)
        rows = QtWidgets.QFormLayout(self.form)
        rows.addRow(translate("Glass_Render", "Station"), self._station)
        rows.addRow(translate("Glass_Render", "Filling"), self._fill)
        rows.addRow(translate("Glass_Render", "Width"), self._width)
        rows.addRow(translate("Glass_Render", "Height"), self._height)
        rows.addRow(translate("Glass_Render", "Tolerance"), self._tolerance)

    def accept(self) -> bool:
        """Remember the choices, apply them and close; FreeCAD calls it on OK."""
        station, fill = self._station.currentText(), self._fill.text().strip()
        tolerance = self._tolerance.value() / 100.0
        width, height = self._width.value(), self._height.value()
        try:
            self._apply(station=station, fill=fill, tolerance=tolerance, size=(width, height))
        except GlassWorkbenchError as error:
            show_error(error)
            return False
        preferences.remember_text("Station", station)
        preferences.remember_text("Fill", fill)
        preferences.remember_number("Tolerance", tolerance)
        preferences.remember_number("Width", width)
        preferences.remember_number("Height", height)
        FreeCADGui.Control.closeDialog()
        return True

    def reject(self) -> bool:
        """Close; FreeCAD calls it on Cancel."""
        FreeCADGui.Control.closeDialog()
        return True


def _side(name: str, pixels: float) -> QtWidgets.QSpinBox:
    box = QtWidgets.QSpinBox(suffix=" px", minimum=16, maximum=LARGEST_SIDE_PIXELS)
    box.setObjectName(name)
    box.setValue(int(pixels))
    return box
