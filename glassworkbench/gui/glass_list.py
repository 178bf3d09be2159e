"""The catalogue of glasses as a list of names, each with its colour against the wall thickness."""

from __future__ import annotations

import numpy as np

from glassworkbench.glass import Glass, catalogue
from glassworkbench.glass.swatch import wedge
from glassworkbench.gui.qt import QtCore, QtGui, QtWidgets

WIDTH, HEIGHT = 64, 20
"""Pixels of a swatch."""

THICKEST_MM = 12.0
"""The thick end of the wedge that a swatch shows: a heavy base, or two strong walls."""


class GlassList(QtWidgets.QListWidget):
    """A list to choose a glass from; `currentTextChanged` tells the choice."""

    def __init__(self, chosen: str) -> None:
        super().__init__()
        self.setObjectName("glass")
        self.setIconSize(QtCore.QSize(WIDTH, HEIGHT))
        self.fill()
        self.choose(chosen)

    def fill(self) -> None:
        """List the catalogue as it is now."""
        self.clear()
        for name, glass in catalogue().items():
            item = QtWidgets.QListWidgetItem(_swatch(glass), name)
            item.setToolTip(f"{glass.description}; the swatch goes from 0 to {THICKEST_MM:g} mm of glass")
            self.addItem(item)

    def choose(self, name: str) -> None:
        """Select a glass by its name."""
        for item in self.findItems(name, QtCore.Qt.MatchExactly):
            self.setCurrentItem(item)

    def chosen(self) -> str:
        """Return the name of the selected glass."""
        return self.currentItem().text()


def _swatch(glass: Glass) -> QtGui.QIcon:
    colours = wedge(glass, THICKEST_MM, WIDTH)
    pixels = np.broadcast_to(colours, (HEIGHT, WIDTH, 3)).copy()
    # Without a frame, colourless glass could not be told from the paper.
    pixels[[0, -1]] = pixels[:, [0, -1]] = 0xB0
    image = QtGui.QImage(pixels.tobytes(), WIDTH, HEIGHT, 3 * WIDTH, QtGui.QImage.Format_RGB888)
    picture = QtGui.QPixmap.fromImage(image)
    icon = QtGui.QIcon(picture)
    # Else Qt tints it where it is selected, and the colour is not the glass's any more.
    icon.addPixmap(picture, QtGui.QIcon.Selected)
    return icon
