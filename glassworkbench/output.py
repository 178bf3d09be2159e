"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from glassworkbench.errors import GlassWorkbenchError, InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DRAWING_ENDINGS = (".png", ".svg", ".pdf")
"""What matplotlib writes."""


def check_writable(path: str | Path, endings: Sequence[str] = ()) -> Path:
    """Return `path` as a Path if a file can be written there; ask before the long work, not after it.

    Parameters
    ----------
    path : str or Path
    endings : sequence of str
        The endings that are understood, like ``(".png", ".exr")``; any if empty.

    Raises
    ------
    InputError
        If the ending is not understood, the folder is missing, or nothing can be written into it.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError(f"{path}: it is a folder; name a file in it")
    if endings and path.suffix.lower() not in endings:
        ending = f"the ending {path.suffix!r} is not known" if path.suffix else "it has no ending"
        raise InputError(f"{path}: {ending}; use {', '.join(endings[:-1])} or {endings[-1]}")
    folder = path.parent
    if not folder.is_dir():
        raise InputError(f"{path}: there is no folder {str(folder)!r}; create it first")
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(f"{path}: nothing can be written into {str(folder)!r} ({error.strerror})") from error
    return path


def check_drawing(path: str | Path, what: str) -> Path:
    """Return the path of a picture that matplotlib can draw; `what` it is, like ``a map of the wall``, for the error.

    Raises
    ------
    InputError
        As `check_writable`, or if matplotlib is missing.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise InputError(
            f"{what} needs matplotlib, which this Python lacks; install it (Debian: python3-matplotlib), or do without"
        ) from error
    return check_writable(path, DRAWING_ENDINGS)


@contextmanager
def written_aside(path: str | Path) -> Iterator[Path]:
    """Give a neighbouring path to write to; it becomes `path` when the block ends well, and vanishes otherwise.

    The neighbour keeps the ending, by which writers choose the format.

    Raises
    ------
    GlassWorkbenchError
        If the system refuses to write or rename.
    """
    path = Path(path)
    aside = path.with_name(f".{path.stem}.{os.getpid()}.partial{path.suffix}")
    try:
        yield aside
        aside.replace(path)
    except OSError as error:
        raise GlassWorkbenchError(f"{path}: could not be written ({error.strerror or error})") from error
    finally:
        aside.unlink(missing_ok=True)


def new_figure(width: float, height: float) -> Figure:
    """Return an empty white matplotlib figure (inches) that needs no window."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure in the format of the path's ending; raises as `written_aside`."""
    with written_aside(path) as aside:
        figure.savefig(aside, dpi=110, format=path.suffix[1:].lower())
