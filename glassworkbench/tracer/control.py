"""What a caller and a running trace share: the wish to stop, and how far it is."""

from __future__ import annotations

import ctypes

from glassworkbench.errors import Cancelled


class Control(ctypes.Structure):
    """The native core's ``glass_control``: both sides may touch it while a call runs."""

    _fields_ = (("cancel", ctypes.c_int32), ("reserved", ctypes.c_int32), ("done", ctypes.c_int64))


class Cancel:
    """A flag that any thread may set; the tracer polls it in its innermost loop over pixels."""

    def __init__(self) -> None:
        self.control = Control()

    def set(self) -> None:
        """Ask the trace to stop."""
        self.control.cancel = 1

    def is_set(self) -> bool:
        """Tell whether the trace was asked to stop."""
        return self.control.cancel != 0

    def check(self) -> None:
        """Raise Cancelled if the trace was asked to stop."""
        if self.is_set():
            raise Cancelled("cancelled")
