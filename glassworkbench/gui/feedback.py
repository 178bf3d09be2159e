"""How the workbench tells the user what it does and what went wrong, and keeps undo to one step."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import FreeCAD
import FreeCADGui

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.gui.qt import QtCore, QtWidgets

translate = FreeCAD.Qt.translate


def show_error(error: GlassWorkbenchError) -> None:
    """Show an error's one sentence in a dialog."""
    QtWidgets.QMessageBox.warning(FreeCADGui.getMainWindow(), translate("Glass", "Glass"), str(error))


@contextmanager
def one_step(document: Any, name: str) -> Iterator[None]:
    """Make all changes of the block one step of undo; none of them stays if the block raises."""
    document.openTransaction(name)
    try:
        yield
    except BaseException:
        document.abortTransaction()
        raise
    document.commitTransaction()


@contextmanager
def busy(message: str) -> Iterator[None]:
    """Show a message in the status bar and the wait cursor while the block runs."""
    status_bar = FreeCADGui.getMainWindow().statusBar()
    status_bar.showMessage(message)
    QtWidgets.QApplication.setOverrideCursor(QtCore.Qt.WaitCursor)
    QtWidgets.QApplication.processEvents(QtCore.QEventLoop.ExcludeUserInputEvents)
    try:
        yield
    finally:
        QtWidgets.QApplication.restoreOverrideCursor()
        status_bar.clearMessage()
