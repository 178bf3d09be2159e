"""The view of an image: gets better while it is traced, and can be cancelled, brightened and saved."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.gui import preferences
from glassworkbench.gui.feedback import show_error, translate
from glassworkbench.gui.qt import QtCore, QtGui, QtWidgets
from glassworkbench.gui.render_thread import RenderThread
from glassworkbench.images import IMAGE_ENDINGS, Image
from glassworkbench.scene import Scene
from glassworkbench.tracer import native

PROGRESS_STEPS = 1000
STOP_MILLISECONDS = 10000
"""The longest wait for a cancelled thread when the window closes."""


class ImageView(QtWidgets.QWidget):
    """Traces scenes and shows their images.

    Parameters
    ----------
    make_scene : callable returning (Scene, float)
        What to trace and its tolerance; called in the window's thread whenever the user asks for a new picture.
    """

    def __init__(self, make_scene: Callable[[], tuple[Scene, float]]) -> None:
        super().__init__()
        self._make_scene = make_scene
        self._thread: RenderThread | None = None
        self.image: Image | None = None

        self._canvas = _Canvas()
        self._status = QtWidgets.QLabel(objectName="status", wordWrap=True)
        self._progress = QtWidgets.QProgressBar(objectName="progress", maximum=PROGRESS_STEPS)
        self._cancel = QtWidgets.QPushButton(translate("Glass_Render", "Cancel"), objectName="cancel")
        self._cancel.clicked.connect(self.cancel)
        self._again = QtWidgets.QPushButton(translate("Glass_Render", "Render again"), objectName="again")
        self._again.clicked.connect(self.start)
        self._exposure = QtWidgets.QDoubleSpinBox(
            objectName="exposure", minimum=-10.0, maximum=10.0, singleStep=0.25, suffix=" EV"
        )
        self._exposure.setToolTip(translate("Glass_Render", "Brightness in stops; does not change EXR files"))
        self._exposure.valueChanged.connect(self._show)
        self._save = QtWidgets.QPushButton(translate("Glass_Render", "Save image…"), objectName="save", enabled=False)
        self._save.clicked.connect(self._ask_and_save)

        buttons = QtWidgets.QHBoxLayout()
        buttons.addWidget(self._progress, 1)
        buttons.addStretch()
        for widget in (self._cancel, self._again, self._exposure, self._save):
            buttons.addWidget(widget)
        layout = QtWidgets.QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 4)
        layout.addWidget(self._canvas, 1)
        layout.addWidget(self._status)
        layout.addLayout(buttons)
        self._set_running(False)
        QtCore.QCoreApplication.instance().aboutToQuit.connect(self._stop)

    def start(self) -> None:
        """Trace a new picture; the one before stays until the first pass of the new one is there."""
        self._stop()
        try:
            scene, tolerance = self._make_scene()
        except GlassWorkbenchError as error:
            show_error(error)
            return
        self._thread = RenderThread(scene, tolerance)
        self._thread.progressed.connect(self._on_progress, QtCore.Qt.QueuedConnection)
        self._thread.improved.connect(self._on_image, QtCore.Qt.QueuedConnection)
        self._thread.completed.connect(self._on_completed, QtCore.Qt.QueuedConnection)
        self._thread.cancelled.connect(self._on_cancelled, QtCore.Qt.QueuedConnection)
        self._thread.failed.connect(self._on_failed, QtCore.Qt.QueuedConnection)
        self._thread.ended.connect(self._on_ended, QtCore.Qt.QueuedConnection)
        self._progress.setValue(0)
        if native.available():
            self._status.setText(translate("Glass_Render", "Rendering…"))
        else:
            self._status.setText(translate("Glass_Render", "Rendering slowly: the native tracer is not built…"))
        self._set_running(True)
        self._thread.start()

    def cancel(self) -> None:
        """Stop the running picture; what is there stays."""
        if self._thread is not None:
            self._thread.cancel()
            self._status.setText(translate("Glass_Render", "Cancelling…"))

    def running(self) -> bool:
        """Return whether a picture is being traced."""
        return self._thread is not None

    def save(self, path: str | Path) -> None:
        """Write the image as shown; the ending decides the format.

        Raises
        ------
        GlassWorkbenchError
            If it cannot be written.
        """
        self.image.save(path, self._exposure.value())

    def closeEvent(self, event: QtGui.QCloseEvent) -> None:  # noqa: N802 (Qt's name)
        """Leave no thread behind."""
        self._stop()
        super().closeEvent(event)

    def _stop(self) -> None:
        if self._thread is None:
            return
        thread, self._thread = self._thread, None
        thread.disconnect(self)
        thread.cancel()
        thread.wait(STOP_MILLISECONDS)
        self._set_running(False)

    def _on_progress(self, fraction: float) -> None:
        self._progress.setValue(round(PROGRESS_STEPS * fraction))

    def _on_image(self, image: Image) -> None:
        self.image = image
        self._save.setEnabled(True)
        self._show()

    def _on_completed(self, image: Image) -> None:
        self._on_image(image)
        self._status.setText(_summary(image))

    def _on_cancelled(self) -> None:
        self._status.setText(translate("Glass_Render", "Cancelled"))

    def _on_failed(self, why: str) -> None:
        self._status.setText(translate("Glass_Render", "Failed"))
        show_error(GlassWorkbenchError(why))

    def _on_ended(self) -> None:
        self._thread.wait()
        self._thread = None
        self._set_running(False)

    def _set_running(self, running: bool) -> None:
        for widget in (self._progress, self._cancel):
            widget.setVisible(running)
        self._again.setVisible(not running)

    def _show(self) -> None:
        if self.image is not None:
            self._canvas.show_pixels(self.image.display(self._exposure.value()))

    def _ask_and_save(self) -> None:
        folder = Path(preferences.text("Folder", str(Path.home())))
        patterns = " ".join(f"*{ending}" for ending in IMAGE_ENDINGS)
        path, _ = QtWidgets.QFileDialog.getSaveFileName(
            self, translate("Glass_Render", "Save image"), str(folder / f"{self.windowTitle()}.png"), patterns
        )
        if not path:
            return
        try:
            self.save(path)
        except GlassWorkbenchError as error:
            show_error(error)
            return
        preferences.remember_text("Folder", str(Path(path).parent))


class _Canvas(QtWidgets.QWidget):
    """Paints a picture as large as fits, its proportions kept."""

    def __init__(self) -> None:
        super().__init__()
        self.setMinimumSize(120, 160)
        self._picture: QtGui.QImage | None = None

    def show_pixels(self, pixels: np.ndarray) -> None:
        """Show uint8 sRGB `pixels` (h, w, 3)."""
        height, width = pixels.shape[:2]
        picture = QtGui.QImage(pixels.tobytes(), width, height, 3 * width, QtGui.QImage.Format_RGB888)
        # The copy owns its memory; the array's ends with this call.
        self._picture = picture.copy()
        self.update()

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Paint."""
        painter = QtGui.QPainter(self)
        painter.fillRect(self.rect(), QtGui.QColor(48, 48, 48))
        if self._picture is not None:
            size = self._picture.size().scaled(self.size(), QtCore.Qt.KeepAspectRatio)
            place = QtCore.QRect(QtCore.QPoint(0, 0), size)
            place.moveCenter(self.rect().center())
            painter.setRenderHint(QtGui.QPainter.SmoothPixmapTransform)
            painter.drawImage(place, self._picture)
        painter.end()


def _summary(image: Image) -> str:
    """Return what the picture cost and how wrong it may be."""
    seconds = image.report.get("seconds", float("nan"))
    median, nearly_all = 100.0 * np.nanpercentile(image.certificate, [50.0, 99.0])
    return translate(
        "Glass_Render", "{:.1f} s; error below {:.2g} % of white (median), {:.2g} % (99 % of the pixels)"
    ).format(seconds, median, nearly_all)
