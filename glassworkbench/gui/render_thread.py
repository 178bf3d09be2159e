"""A picture traced beside FreeCAD's window: the thread gets plain arrays and tells its progress by signals."""

from __future__ import annotations

import logging

from glassworkbench.errors import Cancelled, GlassWorkbenchError
from glassworkbench.gui.qt import QtCore
from glassworkbench.images import Image
from glassworkbench.scene import Scene
from glassworkbench.tracer import Cancel, render


class RenderThread(QtCore.QThread):
    """Traces one scene, or a crop of its image.

    The receivers of its signals live in the window's thread, so Qt queues them.

    Signals
    -------
    progressed : float
        From 0 to 1.
    improved : Image
        A better picture than the one before.
    completed : Image
    cancelled
    failed : str
        Why, in one sentence.
    ended
        Last of all, whatever happened.
    """

    progressed = QtCore.Signal(float)
    improved = QtCore.Signal(object)
    completed = QtCore.Signal(object)
    cancelled = QtCore.Signal()
    failed = QtCore.Signal(str)
    ended = QtCore.Signal()

    def __init__(self, scene: Scene, tolerance: float, crop: tuple[int, int, int, int] | None = None) -> None:
        super().__init__()
        self.scene = scene
        self.tolerance = tolerance
        self.crop = crop
        self._cancel = Cancel()

    def run(self) -> None:
        """Trace; Qt calls it in the new thread."""
        try:
            self.completed.emit(self._trace())
        except Cancelled:
            self.cancelled.emit()
        except GlassWorkbenchError as error:
            self.failed.emit(str(error))
        except Exception as error:
            logging.getLogger(__name__).exception("rendering failed")
            self.failed.emit(f"Rendering failed unexpectedly ({error}); the report view tells more.")
        finally:
            self.ended.emit()

    def cancel(self) -> None:
        """Ask the tracer to stop soon."""
        self._cancel.set()

    def _trace(self) -> Image:
        return render(
            self.scene,
            tolerance=self.tolerance,
            crop=self.crop,
            cancel=self._cancel,
            progress=self.progressed.emit,
            # A glance at a crop would be worse than what the whole image has there.
            on_pass=self.improved.emit if self.crop is None else None,
        )
