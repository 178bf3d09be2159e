"""The sub-windows of FreeCAD's main window that show images, one per render object."""

from __future__ import annotations

from typing import Any

import FreeCAD
import FreeCADGui

from glassworkbench.document.render import is_render, scene
from glassworkbench.errors import InputError
from glassworkbench.gui.feedback import busy, translate
from glassworkbench.gui.image_view import ImageView
from glassworkbench.gui.qt import QtCore, QtWidgets
from glassworkbench.scene import Scene


def show_render(obj: Any) -> ImageView:
    """Trace a render object in its sub-window, which is made if there is none yet, and return the view."""
    area = FreeCADGui.getMainWindow().findChild(QtWidgets.QMdiArea)
    name = f"{obj.Document.Name}/{obj.Name}"
    view = area.findChild(ImageView, name)
    if view is None:
        view = ImageView(_Snapshot(obj.Document.Name, obj.Name))
        view.setObjectName(name)
        view.setAttribute(QtCore.Qt.WA_DeleteOnClose)
        window = area.addSubWindow(view)
        window.setAttribute(QtCore.Qt.WA_DeleteOnClose)
        view.show()
    view.setWindowTitle(obj.Label)
    area.setActiveSubWindow(view.parentWidget())
    view.start()
    return view


class _Snapshot:
    """Takes the scene of a render object out of its document, by name: the document may be closed meanwhile."""

    def __init__(self, document: str, name: str) -> None:
        self._document = document
        self._name = name

    def __call__(self) -> tuple[Scene, float]:
        documents = FreeCAD.listDocuments()
        obj = documents[self._document].getObject(self._name) if self._document in documents else None
        if obj is None or not is_render(obj):
            raise InputError("This picture's render object is no longer open; open its document, or render anew.")
        with busy(translate("Glass_Render", "Preparing the container for rendering…")):
            return scene(obj), obj.Tolerance
