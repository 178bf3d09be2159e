"""What each wavelength passes, as a curve in a panel."""

from __future__ import annotations

import numpy as np

from glassworkbench.glass import Glass
from glassworkbench.glass.pictures import GLASS_PLATE_MM
from glassworkbench.glass.swatch import shown_colour
from glassworkbench.gui.qt import QtCore, QtGui, QtWidgets

SHORTEST_NM, LONGEST_NM = 300.0, 800.0
LABELLED_NM = (400, 550, 700)
LEFT, BOTTOM, MARGIN = 42, 18, 6
"""Pixels for the labels."""


class TransmissionView(QtWidgets.QWidget):
    """The curve of a plate of glass in air, filled with its colour."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("transmission")
        self.setMinimumHeight(120)
        self._wavelengths = self._passed = np.zeros(0)
        self._colour = "#ffffff"

    def show_glass(self, glass: Glass) -> None:
        """Draw another glass."""
        low, high = max(SHORTEST_NM, glass.range_nm[0]), min(LONGEST_NM, glass.range_nm[1])
        self._wavelengths = np.linspace(low, high, 251)
        self._passed = glass.plate_transmittance(self._wavelengths, GLASS_PLATE_MM)
        self._colour = shown_colour(glass, GLASS_PLATE_MM)
        self.setToolTip(f"{glass.name}, {GLASS_PLATE_MM:g} mm")
        self.update()

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw axes, filled curve and line."""
        painter = QtGui.QPainter(self)
        painter.setRenderHint(QtGui.QPainter.Antialiasing)
        place = QtCore.QRectF(self.rect()).adjusted(LEFT, MARGIN, -MARGIN, -BOTTOM)
        painter.fillRect(place, QtGui.QColor("white"))
        if len(self._wavelengths):
            self._draw_curve(painter, place)
        painter.setPen(self.palette().color(QtGui.QPalette.WindowText))
        painter.drawRect(place)
        for nm in LABELLED_NM:
            centre = place.left() + (nm - SHORTEST_NM) / (LONGEST_NM - SHORTEST_NM) * place.width()
            label = QtCore.QRectF(centre - 30.0, place.bottom() + 2.0, 60.0, BOTTOM)
            painter.drawText(label, QtCore.Qt.AlignHCenter | QtCore.Qt.AlignTop, f"{nm} nm")
        for percent in (0, 50, 100):
            middle = place.bottom() - percent / 100.0 * place.height()
            label = QtCore.QRectF(0.0, middle - 10.0, LEFT - 4.0, 20.0)
            label.moveTop(min(max(label.top(), 0.0), self.height() - 20.0))
            painter.drawText(label, QtCore.Qt.AlignRight | QtCore.Qt.AlignVCenter, f"{percent}%")
        painter.end()

    def _draw_curve(self, painter: QtGui.QPainter, place: QtCore.QRectF) -> None:
        across = place.left() + (self._wavelengths - SHORTEST_NM) / (LONGEST_NM - SHORTEST_NM) * place.width()
        down = place.bottom() - self._passed * place.height()
        curve = [QtCore.QPointF(x, y) for x, y in zip(across.tolist(), down.tolist(), strict=True)]
        feet = [QtCore.QPointF(curve[-1].x(), place.bottom()), QtCore.QPointF(curve[0].x(), place.bottom())]
        painter.setPen(QtCore.Qt.NoPen)
        painter.setBrush(QtGui.QColor(self._colour))
        painter.drawPolygon(QtGui.QPolygonF([*curve, *feet]))
        painter.setBrush(QtCore.Qt.NoBrush)
        painter.setPen(QtGui.QPen(QtGui.QColor("#303030"), 1.3))
        painter.drawPolyline(QtGui.QPolygonF(curve))
