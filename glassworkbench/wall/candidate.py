"""What a method hands over: a cavity, and the solid that it leaves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import Part
from glassworkbench.mold import Mold
from glassworkbench.scene import Mesh, Surface
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.measuring.outside import Outside


@dataclass(frozen=True, eq=False)
class Candidate:
    """A container that is not measured yet; all is upright.

    Parameters
    ----------
    solid : Part.Shape or None
        The glass, one closed solid; None where there are only meshes.
    cavity : Surface or Part.Shape
        What the tracer takes away from the outside; it reaches past the mouth.
    inside : Mesh
        The cavity closed level at the finish plane: what is measured, and what the capacity is taken from.
    notes : tuple of str
        Sentences that the user should read, like where the wall cannot be as thick as asked.
    meridian : array (n, 4, 3) or None
        The turned inside as a rational cubic Bezier chain, closed at the finish plane, for exact volumes.
    details : tuple of str
        What the method tried on the way, and how that ended, one line each.
    facets_off_mm : float
        How far flat facets of the solid's inside may be off `inside`, which is smooth; 0 where it has none.
    limit : str
        Why the method comes no nearer to the wall asked, and what helps; empty where it has no such limit.
    """

    solid: Part.Shape | None
    cavity: Surface | Part.Shape
    inside: Mesh
    notes: tuple[str, ...] = ()
    meridian: np.ndarray | None = None
    details: tuple[str, ...] = ()
    facets_off_mm: float = 0.0
    limit: str = ""


class Method(Protocol):
    """A method of hollowing, as each file of `methods` has one; what is special to it stands there."""

    def __call__(self, mold: Mold, asked: AskedThickness, wall: Outside, seconds: float) -> Candidate:
        """Return a container, not measured yet.

        Parameters
        ----------
        mold : Mold
        asked : AskedThickness
        wall : Outside
            The mold's outside with the thickness asked.
        seconds : float
            What the method may take. The quick ones do not look at it.

        Raises
        ------
        InputError
            If the wall cannot be: the message says where, and how much is possible.
        GlassWorkbenchError
            If the method cannot make it, which another may.
        """


class HopelessError(InputError):
    """Whatever the method, there is no such container: no other need try."""


class NoCandidateError(GlassWorkbenchError):
    """A method that tries several ways came to the end of them, or of its time.

    `details` tells how each fared, one line each.
    """

    def __init__(self, message: str, details: tuple[str, ...] = (), out_of_time: bool = False) -> None:
        super().__init__(message)
        self.details = details
        self.out_of_time = out_of_time
