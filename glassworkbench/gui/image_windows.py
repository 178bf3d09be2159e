"""The sub-windows of FreeCAD's main window that show images, one per render object."""

from __future__ import annotations

from typing import Any

import FreeCADGui

from glassworkbench.document.render import placement, scene
from glassworkbench.gui.feedback import busy, translate
from glassworkbench.gui.image_view import ImageView
from glassworkbench.gui.qt import QtCore, QtGui, QtWidgets
from glassworkbench.scene import Scene
from glassworkbench.settings import RESOURCES
from glassworkbench.tracer.path import RayPath


def show_render(obj: Any) -> ImageView:
    """Trace a render object in its sub-window, which is made if there is none yet, and return the view."""
    view = _find_view(obj) or _new_view(obj)
    view.setWindowTitle(obj.Label)
    _area().setActiveSubWindow(view.parentWidget())
    view.start()
    return view


class WindowCloser:
    """A document observer: the window of a picture goes with its render object, as 3D views go with their document."""

    def slotDeletedObject(self, obj: Any) -> None:  # noqa: N802 (FreeCAD's name)
        """Close the window of a deleted render object."""
        view = _find_view(obj)
        if view is not None:
            view.parentWidget().close()

    def slotDeletedDocument(self, document: Any) -> None:  # noqa: N802 (FreeCAD's name)
        """Close the windows of a document that is closed."""
        for obj in document.Objects:
            self.slotDeletedObject(obj)


def _new_view(obj: Any) -> ImageView:
    def snapshot() -> tuple[Scene, float]:
        with busy(translate("Glass_Render", "Preparing the container for rendering…")):
            return scene(obj), obj.Tolerance

    def show_ray(path: RayPath) -> None:
        obj.ViewObject.Proxy.show_ray(path, placement(obj))

    view = ImageView(snapshot, show_ray)
    view.setObjectName(_window_name(obj))
    window = _area().addSubWindow(view)
    window.setWindowIcon(QtGui.QIcon(str(RESOURCES / "icons" / "Glass_Render.svg")))
    window.setAttribute(QtCore.Qt.WA_DeleteOnClose)
    view.show()
    return view


def _find_view(obj: Any) -> ImageView | None:
    return _area().findChild(ImageView, _window_name(obj))


def _window_name(obj: Any) -> str:
    return f"{obj.Document.Name}/{obj.Name}"


def _area() -> QtWidgets.QMdiArea:
    return FreeCADGui.getMainWindow().findChild(QtWidgets.QMdiArea)
