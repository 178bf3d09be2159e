"""The view of an image: gets better while it is traced, and can be cancelled, brightened and saved."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.gui import preferences
from glassworkbench.gui.canvas import Canvas
from glassworkbench.gui.feedback import show_error, translate
from glassworkbench.gui.qt import QtCore, QtGui, QtWidgets
from glassworkbench.gui.render_thread import RenderThread
from glassworkbench.images import IMAGE_ENDINGS, Image
from glassworkbench.scene import Scene
from glassworkbench.tracer import native
from glassworkbench.tracer.path import RayPath, ray_path

PROGRESS_STEPS = 1000
REFINEMENT = 0.25
"""What dragging over a part of the picture makes of its error."""

FINEST_TOLERANCE = 1e-4

STOP_MILLISECONDS = 10000
"""The longest wait for a cancelled thread when the window closes."""


class ImageView(QtWidgets.QWidget):
    """Traces scenes and shows their images.

    Parameters
    ----------
    make_scene : callable returning (Scene, float)
        What to trace and its tolerance; called in the window's thread whenever the user asks for a new picture.
    show_ray : callable taking a RayPath
        Called with the ray through the point of the picture that the user clicks at.
    """

    def __init__(self, make_scene: Callable[[], tuple[Scene, float]], show_ray: Callable[[RayPath], None]) -> None:
        super().__init__()
        self._make_scene, self._show_ray = make_scene, show_ray
        self._shown: tuple[Scene, float] | None = None
        self._thread: RenderThread | None = None
        self.image: Image | None = None

        self._canvas = Canvas()
        self._canvas.setToolTip(
            translate("Glass_Render", "Click to follow a ray in the 3D view; drag to refine a part")
        )
        self._canvas.clicked.connect(self.follow)
        self._canvas.dragged.connect(self.refine)
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
        self._run(RenderThread(scene, tolerance))

    def refine(self, left: int, top: int, width: int, height: int) -> None:
        """Trace a part of the finished picture again, to a quarter of its error; no more while one is running."""
        if self.running() or self._shown is None:
            return
        scene, tolerance = self._shown
        worst = float(np.max(self.image.certificate[top : top + height, left : left + width]))
        finer = max(FINEST_TOLERANCE, REFINEMENT * min(worst, tolerance))
        self._run(RenderThread(scene, finer, (left, top, width, height)))

    def follow(self, column: float, row: float) -> None:
        """Show the ray through a point of the picture in the 3D view, and tell where it went."""
        if self._shown is None:
            return
        scene, _ = self._shown
        width, height = scene.size
        origins, directions = scene.camera.rays(
            np.array([(2.0 * column - width) / height]), np.array([1.0 - 2.0 * row / height])
        )
        try:
            path = ray_path(scene, origins[0], directions[0])
            self._show_ray(path)
        except GlassWorkbenchError as error:
            show_error(error)
            return
        if not self.running():
            self._status.setText(_told_of_ray(path))

    def _run(self, thread: RenderThread) -> None:
        self._thread = thread
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
        if self._thread is None:
            # Qt still delivers what a stopped thread sent before.
            return
        if self._thread.crop is None:
            self.image, self._shown = image, (self._thread.scene, self._thread.tolerance)
        else:
            self.image = self.image.with_part(image)
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


def _summary(image: Image) -> str:
    """Return what the picture cost and how wrong it may be."""
    seconds = image.report.get("seconds", float("nan"))
    median, nearly_all = 100.0 * np.nanpercentile(image.certificate, [50.0, 99.0])
    return translate(
        "Glass_Render", "{:.1f} s; error below {:.2g} % of white (median), {:.2g} % (99 % of the pixels)"
    ).format(seconds, median, nearly_all)


def _told_of_ray(path: RayPath) -> str:
    """Return where a ray went."""
    count, total = len(path.crossings), int(np.sum(path.is_reflected()))
    length = float(np.sum(np.linalg.norm(np.diff(path.points_mm, axis=0), axis=1)))
    if path.panel is None:
        return translate("Glass_Render", "The ray meets {} surfaces, {} of them totally reflecting").format(
            count, total
        )
    return translate(
        "Glass_Render", "The ray meets {} surfaces, {} of them totally reflecting, and after {:.0f} mm a luminous panel"
    ).format(count, total, length)
