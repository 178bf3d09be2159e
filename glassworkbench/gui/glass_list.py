"""The catalogue of glasses as a list of names with their colours."""

from __future__ import annotations

from glassworkbench.document.appearance import colour
from glassworkbench.glass import catalogue
from glassworkbench.gui.qt import QtCore, QtGui, QtWidgets

SWATCH_PIXELS = 20


class GlassList(QtWidgets.QListWidget):
    """A list to choose a glass from; `currentTextChanged` tells the choice."""

    def __init__(self, chosen: str) -> None:
        super().__init__()
        self.setObjectName("glass")
        self.setIconSize(QtCore.QSize(SWATCH_PIXELS, SWATCH_PIXELS))
        for name, glass in catalogue().items():
            swatch = QtGui.QPixmap(SWATCH_PIXELS, SWATCH_PIXELS)
            swatch.fill(QtGui.QColor.fromRgbF(*colour(glass)))
            item = QtWidgets.QListWidgetItem(QtGui.QIcon(swatch), name)
            item.setToolTip(glass.description)
            self.addItem(item)
        self.choose(chosen)

    def choose(self, name: str) -> None:
        """Select a glass by its name."""
        for item in self.findItems(name, QtCore.Qt.MatchExactly):
            self.setCurrentItem(item)

    def chosen(self) -> str:
        """Return the name of the selected glass."""
        return self.currentItem().text()
