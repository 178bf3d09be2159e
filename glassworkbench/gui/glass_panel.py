"""The task panel that sets the glass of a container, shown in the 3D view while the user chooses."""

from __future__ import annotations

from typing import Any

import FreeCADGui

from glassworkbench.document.container import set_glass
from glassworkbench.glass import catalogue
from glassworkbench.gui.feedback import translate
from glassworkbench.gui.glass_list import GlassList
from glassworkbench.gui.qt import QtWidgets


class GlassPanel:
    """Changes the glass at once, in one open step of undo that OK commits and Cancel takes back."""

    def __init__(self, container: Any) -> None:
        self._document = container.Document
        self._document.openTransaction(translate("Glass_SetGlass", "Set glass"))
        self._description = QtWidgets.QLabel(wordWrap=True)
        self._list = GlassList(container.Glass)
        self._describe(container.Glass)
        self._list.currentTextChanged.connect(lambda name: self._choose(container, name))

        self.form = QtWidgets.QWidget()
        self.form.setWindowTitle(translate("Glass_SetGlass", "Glass of {}").format(container.Label))
        layout = QtWidgets.QVBoxLayout(self.form)
        layout.addWidget(self._list)
        layout.addWidget(self._description)

    def accept(self) -> bool:
        """Keep the choice and close; FreeCAD calls it on OK."""
        self._document.commitTransaction()
        FreeCADGui.Control.closeDialog()
        return True

    def reject(self) -> bool:
        """Take the choice back and close; FreeCAD calls it on Cancel."""
        self._document.abortTransaction()
        FreeCADGui.Control.closeDialog()
        return True

    def _choose(self, container: Any, name: str) -> None:
        set_glass(container, name)
        self._describe(name)

    def _describe(self, name: str) -> None:
        glass = catalogue()[name]
        self._description.setText(
            f"{glass.description}. n = {glass.refractive_index_d:.4g}, {glass.density_g_per_cm3:.3g} g/cm³"
        )
