"""Qt as FreeCAD brings it, PySide2 or PySide6, through FreeCAD's own shim."""

from PySide import QtCore, QtGui

try:
    from PySide import QtWidgets
except ImportError:  # FreeCAD 0.20 keeps the widgets in QtGui
    QtWidgets = QtGui

__all__ = ["QtCore", "QtGui", "QtWidgets"]
