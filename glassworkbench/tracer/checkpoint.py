"""A rendering on its way, in a file: a later run goes on from there, and its image is the same to the last byte."""

from __future__ import annotations

import json
import time
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.output import check_writable, written_aside
from glassworkbench.scene.validate import file_path
from glassworkbench.tracer.film import Film

INTERVAL_SECONDS = 30.0
"""Between two checkpoints."""

LARGEST_SHARE = 0.05
"""Of the time goes into checkpoints, at most: those of large images take seconds each."""


@dataclass(frozen=True, eq=False)
class Place:
    """How far a rendering is.

    Parameters
    ----------
    number : int
        Of the pass, from 0.
    step : int
        In the pass: 0 for all pixels, then for those of which too much was left out.
    wanted : uint8 array (h, w), optional
        Pixels of the step; None where it has not begun.
    tiles : int
        How many of the step's are done.
    """

    number: int = 0
    step: int = 0
    wanted: np.ndarray | None = None
    tiles: int = 0


@dataclass(frozen=True, eq=False)
class Stopped:
    """What a checkpoint holds besides the film."""

    place: Place
    share: float
    seconds: float


class Checkpoint:
    """The file beside a rendering.

    Parameters
    ----------
    path : path
    asked : mapping of str to str
        What the image depends on, by what a user calls it; a rendering that was asked for something else cannot go on.

    Raises
    ------
    InputError
        If nothing can be written there.
    """

    def __init__(self, path: str | Path, asked: Mapping[str, str]) -> None:
        self.path = check_writable(file_path(path))
        self._asked = dict(asked)
        self._due = time.monotonic() + INTERVAL_SECONDS

    def is_due(self) -> bool:
        """Tell whether it is time to write."""
        return time.monotonic() >= self._due

    def write(self, film: Film, stopped: Stopped) -> None:
        """Write the state of a rendering, in place of what the file held before.

        Raises
        ------
        GlassWorkbenchError
            If the system refuses.
        """
        began = time.monotonic()
        place = stopped.place
        header = {
            "asked": self._asked,
            "number": place.number,
            "step": place.step,
            "tiles": place.tiles,
            "share": stopped.share,
            "seconds": stopped.seconds,
        }
        wanted = np.zeros((0, 0), dtype=bool) if place.wanted is None else place.wanted != 0
        with written_aside(self.path) as aside, aside.open("wb") as file:
            np.savez(
                file, header=np.array(json.dumps(header)), wanted=np.packbits(wanted, axis=None), **film.to_arrays()
            )
        now = time.monotonic()
        self._due = now + max(INTERVAL_SECONDS, (now - began) / LARGEST_SHARE)

    def read(self, film: Film) -> Stopped:
        """Fill a film with what the file holds.

        Raises
        ------
        InputError
            If there is no such file, it is no checkpoint, or it belongs to another rendering.
        """
        if not self.path.is_file():
            raise InputError(f"{self.path}: there is no such checkpoint; leave it out to start anew")
        try:
            with np.load(self.path, allow_pickle=False) as arrays:
                header = json.loads(str(arrays["header"]))
                self._check(header["asked"])
                film.fill({name: arrays[name] for name in film.to_arrays()})
                pixels = film.width * film.height
                wanted = np.unpackbits(arrays["wanted"])[:pixels]
            place = Place(
                header["number"],
                header["step"],
                wanted.reshape(film.height, film.width) if wanted.size else None,
                header["tiles"],
            )
            return Stopped(place, header["share"], header["seconds"])
        except (OSError, ValueError, TypeError, KeyError, EOFError, zipfile.BadZipFile) as error:
            raise InputError(f"{self.path}: not a checkpoint, or damaged; leave it out to start anew") from error

    def _check(self, asked: Mapping[str, str]) -> None:
        for name, value in self._asked.items():
            if asked.get(name) != value:
                raise InputError(
                    f"{self.path}: it belongs to another {name}, so the rendering cannot go on from it; "
                    "leave it out to start anew"
                )

    def remove(self) -> None:
        """Remove the file, if there is one."""
        self.path.unlink(missing_ok=True)
