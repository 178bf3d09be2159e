"""Runs a script in FreeCAD's window: a generator that yields what it waits for, driven by a timer."""

import json
import os
import subprocess
import time
import traceback
from pathlib import Path

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

try:
    from PySide import QtWidgets
except ImportError:
    QtWidgets = QtGui

POLL_MILLISECONDS = 20
PATIENCE_SECONDS = 45.0
FOLDER = Path(os.environ["WINDOW_TEST_FOLDER"])
CHECKOUT = Path(os.environ["WINDOW_TEST_CHECKOUT"])


class Runner(QtCore.QObject):
    """Advances the script whenever the condition it waits for holds, then writes the facts it found and quits."""

    def __init__(self, script):
        super().__init__()
        self.facts = {}
        self._script = script(self.facts)
        self._condition = lambda: True
        self._deadline = 0.0
        self._timer = QtCore.QTimer(self)
        self._timer.timeout.connect(self._tick)
        self._timer.start(POLL_MILLISECONDS)

    def _tick(self):
        self._timer.stop()
        try:
            if self._condition():
                self._condition = next(self._script)
                self._deadline = time.monotonic() + PATIENCE_SECONDS
            elif time.monotonic() > self._deadline:
                self._script.throw(TimeoutError(f"waited {PATIENCE_SECONDS:g} s in vain"))
        except StopIteration:
            self._end()
        except BaseException:
            self.facts["error"] = traceback.format_exc()
            screenshot("error")
            self._end()
        else:
            self._timer.start(POLL_MILLISECONDS)

    def _end(self):
        self.facts["report_view"] = report_view()
        (FOLDER / "facts.json").write_text(json.dumps(self.facts, indent=1, default=str))
        for name in FreeCAD.listDocuments():
            FreeCAD.closeDocument(name)
        later(FreeCADGui.getMainWindow().close)


def later(call):
    """Call from the event loop: what opens a modal dialog must not hold up the script."""
    QtCore.QTimer.singleShot(0, call)


def report_view():
    """Return the text of the Report view."""
    found = FreeCADGui.getMainWindow().findChildren(QtWidgets.QTextEdit)
    return "\n".join(view.toPlainText() for view in found if "report" in view.objectName().lower())


def screenshot(name):
    """Save the whole screen; a widget's own grab leaves the 3D view blank."""
    path = FOLDER / f"{name}.png"
    subprocess.run(["import", "-window", "root", str(path)], check=True, timeout=20)
    return str(path)


def child(parent, name):
    """Return the widget of that object name, or None."""
    return parent.findChild(QtWidgets.QWidget, name)


def on_screen(widget):
    """Return left, top, width, height of a widget on the screen."""
    corner = widget.mapToGlobal(QtCore.QPoint(0, 0))
    return [corner.x(), corner.y(), widget.width(), widget.height()]


def open_dialog():
    """Return the text of the open message box, and close it; None if there is none."""
    dialog = QtWidgets.QApplication.activeModalWidget()
    if dialog is None:
        return None
    text = dialog.text()
    dialog.accept()
    return text


def task_panel_button(kind):
    """Return the task panel's OK or Cancel button."""
    for box in FreeCADGui.getMainWindow().findChildren(QtWidgets.QDialogButtonBox):
        button = box.button(getattr(QtWidgets.QDialogButtonBox.StandardButton, kind))
        if button is not None and button.isVisible():
            return button
    return None
