"""The place where a picture is painted: it tells where the user clicks, and what rectangle he drags out."""

from __future__ import annotations

import numpy as np

from glassworkbench.gui.qt import QtCore, QtGui, QtWidgets

SHORTEST_DRAG_PIXELS = 4
"""A shorter one is a click by an unsteady hand."""


class Canvas(QtWidgets.QWidget):
    """Paints a picture as large as fits, its proportions kept.

    Signals
    -------
    clicked : float, float
        Column and row of the picture, in its pixels.
    dragged : int, int, int, int
        Left, top, width, height of a rectangle of its pixels.
    """

    clicked = QtCore.Signal(float, float)
    dragged = QtCore.Signal(int, int, int, int)

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("canvas")
        self.setMinimumSize(120, 160)
        self.setCursor(QtCore.Qt.CrossCursor)
        self._picture: QtGui.QImage | None = None
        self._pressed: QtCore.QPoint | None = None
        self._frame = QtWidgets.QRubberBand(QtWidgets.QRubberBand.Rectangle, self)

    def show_pixels(self, pixels: np.ndarray) -> None:
        """Show uint8 sRGB `pixels` (h, w, 3)."""
        height, width = pixels.shape[:2]
        picture = QtGui.QImage(pixels.tobytes(), width, height, 3 * width, QtGui.QImage.Format_RGB888)
        # The copy owns its memory; the array's ends with this call.
        self._picture = picture.copy()
        self.update()

    def place(self) -> QtCore.QRect:
        """Return where the picture is painted."""
        place = QtCore.QRect(QtCore.QPoint(0, 0), self._picture.size().scaled(self.size(), QtCore.Qt.KeepAspectRatio))
        place.moveCenter(self.rect().center())
        return place

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Paint."""
        painter = QtGui.QPainter(self)
        painter.fillRect(self.rect(), QtGui.QColor(48, 48, 48))
        if self._picture is not None:
            painter.setRenderHint(QtGui.QPainter.SmoothPixmapTransform)
            painter.drawImage(self.place(), self._picture)
        painter.end()

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Remember where a click or a drag begins."""
        if self._picture is not None and event.button() == QtCore.Qt.LeftButton:
            self._pressed = event.pos()

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Show the rectangle so far."""
        if self._pressed is not None:
            self._frame.setGeometry(QtCore.QRect(self._pressed, event.pos()).normalized())
            self._frame.show()

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Tell of the click or the rectangle."""
        if self._pressed is None or event.button() != QtCore.Qt.LeftButton:
            return
        start, self._pressed = self._pressed, None
        self._frame.hide()
        (left, top), (right, bottom) = self._in_picture(start), self._in_picture(event.pos())
        width, height = self._picture.width(), self._picture.height()
        if (event.pos() - start).manhattanLength() < SHORTEST_DRAG_PIXELS:
            if 0.0 <= left < width and 0.0 <= top < height:
                self.clicked.emit(left, top)
            return
        columns = np.clip(np.sort([left, right]), 0.0, width)
        rows = np.clip(np.sort([top, bottom]), 0.0, height)
        first_column, first_row = int(columns[0]), int(rows[0])
        size = int(np.ceil(columns[1])) - first_column, int(np.ceil(rows[1])) - first_row
        if min(size) > 0:
            self.dragged.emit(first_column, first_row, *size)

    def _in_picture(self, point: QtCore.QPoint) -> tuple[float, float]:
        """Return column and row of the picture under the middle of a pixel of the widget."""
        place = self.place()
        return (
            (point.x() + 0.5 - place.x()) / place.width() * self._picture.width(),
            (point.y() + 0.5 - place.y()) / place.height() * self._picture.height(),
        )
