"""The task panel that sets the glass of a container, shown in the 3D view while the user chooses."""

from __future__ import annotations

from typing import Any

import FreeCADGui

from glassworkbench.document.container import set_glass
from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.glass import catalogue
from glassworkbench.glass.own_glasses import keep
from glassworkbench.gui.feedback import show_error, translate
from glassworkbench.gui.glass_list import GlassList
from glassworkbench.gui.qt import QtWidgets
from glassworkbench.gui.transmission_view import TransmissionView


class GlassPanel:
    """Changes the glass at once, in one open step of undo that OK commits and Cancel takes back."""

    def __init__(self, container: Any) -> None:
        self._container = container
        self._document = container.Document
        self._document.openTransaction(translate("Glass_SetGlass", "Set glass"))
        self._description = QtWidgets.QLabel(wordWrap=True)
        self._transmission = TransmissionView()
        self._list = GlassList(container.Glass)
        self._describe(container.Glass)
        self._list.currentTextChanged.connect(self._choose)
        add = QtWidgets.QPushButton(translate("Glass_SetGlass", "Add glasses from a file…"))
        add.setObjectName("add_glasses")
        add.setToolTip(
            translate(
                "Glass_SetGlass",
                "A file of glasses (.toml), or a material card (.FCMat); it joins the catalogue for good",
            )
        )
        add.clicked.connect(self._ask_for_file)

        self.form = QtWidgets.QWidget()
        self.form.setWindowTitle(translate("Glass_SetGlass", "Glass of {}").format(container.Label))
        layout = QtWidgets.QVBoxLayout(self.form)
        layout.addWidget(self._list)
        layout.addWidget(self._description)
        layout.addWidget(self._transmission)
        layout.addWidget(add)

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

    def add_glasses(self, path: str) -> None:
        """Put a file's glasses into the catalogue, and choose the first of them."""
        try:
            names = keep(path)
        except GlassWorkbenchError as error:
            show_error(error)
            return
        self._list.blockSignals(True)
        self._list.fill()
        self._list.choose(self._container.Glass)
        self._list.blockSignals(False)
        self._list.choose(names[0])

    def _ask_for_file(self) -> None:
        title = translate("Glass_SetGlass", "Add glasses")
        path, _ = QtWidgets.QFileDialog.getOpenFileName(self.form, title, "", "(*.toml *.FCMat)")
        if path:
            self.add_glasses(path)

    def _choose(self, name: str) -> None:
        set_glass(self._container, name)
        self._describe(name)

    def _describe(self, name: str) -> None:
        glass = catalogue().get(name)
        if glass is None:
            # A document may come from where the catalogue held more.
            self._description.setText(translate("Glass_SetGlass", "{} is not in the catalogue").format(name))
            return
        facts = f"{glass.description}. n = {glass.refractive_index_d:.4g}, {glass.density_g_per_cm3:.3g} g/cm³"
        assumed = translate("Glass_SetGlass", "Assumed: {}").format(glass.assumed) if glass.assumed else ""
        self._description.setText(facts)
        self._description.setToolTip("\n".join(filter(None, (glass.source, assumed))))
        self._transmission.show_glass(glass)
