"""Hollows a mold by the first method whose result, measured, is what was asked."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from glassworkbench.errors import GlassWorkbenchError, InputError, OutOfTimeError
from glassworkbench.mold import Mold
from glassworkbench.mold.mold import moved
from glassworkbench.scene.validate import positive
from glassworkbench.settings import unknown_name
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.asking.shortened import shortened
from glassworkbench.wall.asking.thickness import REGIONS, Thickness, UniformThickness
from glassworkbench.wall.asking.thickness_text import parse_thickness
from glassworkbench.wall.attempt import MAKERS, Attempted, attempt
from glassworkbench.wall.candidate import HopelessError, NoCandidateError
from glassworkbench.wall.container import Attempt, Container, WallReport
from glassworkbench.wall.levels.narrow import no_room
from glassworkbench.wall.measuring.contents import centre_of_gravity, weight_g
from glassworkbench.wall.measuring.outside import outside
from glassworkbench.wall.turning.inner_meridian import offset_meridian
from glassworkbench.wall.turning.profile import wall_meridian
from glassworkbench.wall.worker import run_in_worker

METHODS = ("auto", *MAKERS)

TOLERANCE_SHARE, TOLERANCE_MM = 0.02, 0.02
"""Unless told otherwise, 99 % of the wall must come out within this share of the thinnest wall, or this."""


@dataclass(frozen=True)
class Rung:
    """A method of the ladder, and the share of the time left that it may use."""

    method: str
    share: float


SHORTEST_MESHING_SECONDS = 15.0
"""A level set of a wall that is hard to loft takes longer than this; time below it is better used for the loft."""

SHORTEST_SECONDS = 1.0
"""No method makes and measures anything in less."""

ROUND = (Rung("revolved", 0.4), Rung("lofted", 0.5), Rung("thick_solid", 0.4), Rung("inner_mesh", 1.0))
UNIFORM = (Rung("thick_solid", 0.15), Rung("lofted", 0.5), Rung("inner_mesh", 1.0))
VARYING = (Rung("lofted", 0.5), Rung("inner_mesh", 1.0))
STEPPED = (Rung("thick_solid", 0.3), *VARYING)
MESHED = (Rung("lofted", 0.4), Rung("inner_mesh", 1.0))
"""The ladders: for (nearly) round molds, for others with a wall that is the same everywhere, varies, or steps from face
to face across sharp edges, for meshes."""


class HollowingError(GlassWorkbenchError):
    """No method gave the wall asked; `tried` (of Attempt) tells how each fared."""

    def __init__(self, tried: tuple[Attempt, ...], message: str) -> None:
        super().__init__(message)
        self.tried = tried


def hollow(
    mold: Mold,
    thickness: Thickness | str | float,
    *,
    method: str = "auto",
    tolerance_mm: float | None = None,
    seconds: float = 120.0,
    accept_best: bool = False,
) -> Container:
    """Return the container that a mold makes with a given wall.

    Parameters
    ----------
    mold : Mold
    thickness : Thickness, str or float
        A wall specification as `parse_thickness` reads it, or mm.
    method : str
        One of `METHODS`. Auto goes down a ladder of methods and takes the first whose result is good.
    tolerance_mm : float, optional
        What 99 % of the inner surface may deviate from the wall asked; 2 % of the thinnest wall, at least 0.02 mm,
        if not given.
    seconds : float
        Time for all methods together. Each runs in a process of its own, which is stopped when its share is over.
    accept_best : bool
        Where no result is good enough, return the one with the smallest deviation; the report's notes say so.

    Raises
    ------
    InputError
        If the wall cannot be, or does not fit into the mold, or the method is unknown.
    HollowingError
        If no method's result is good enough; the message says what was tried.
    """
    start = time.monotonic()
    if not isinstance(mold, Mold):
        raise InputError(f"mold: {mold!r} is no mold; give what read_mold returns")
    thickness = as_thickness(thickness, tuple(reversed(mold.anatomy.regions)))
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    asked = thickness.on(mold)
    _check_fits(mold, asked)
    tolerance = (
        max(TOLERANCE_SHARE * asked.minimum_mm, TOLERANCE_MM)
        if tolerance_mm is None
        else positive(tolerance_mm, "tolerance_mm")
    )
    limit = positive(seconds, "seconds")
    attempts: list[Attempt] = []
    impossible: list[InputError] = []
    rejected: list[tuple[str, Attempted]] = []
    out_of_time = False
    for rung in ladder(mold, asked) if method == "auto" else (Rung(method, 1.0),):
        begin = time.monotonic()
        left = limit - (begin - start)
        if attempts and left < SHORTEST_SECONDS:
            break
        share = granted(rung, left)
        attempted, details = None, ()
        try:
            attempted = run_in_worker(attempt, (mold, thickness, rung.method, tolerance, share), {}, share)
            outcome, why = ("rejected", attempted.fault) if attempted.fault else ("accepted", "")
            details = attempted.candidate.details
            rejected.append((rung.method, attempted))
        except InputError as error:
            outcome, why = "impossible", str(error)
            impossible.append(error)
        except GlassWorkbenchError as error:
            outcome, why = "failed", str(error)
            details = error.details if isinstance(error, NoCandidateError) else ()
            out_of_time |= isinstance(error, OutOfTimeError) or getattr(error, "out_of_time", False)
        attempts.append(Attempt(rung.method, outcome, why, time.monotonic() - begin, details))
        if outcome == "accepted":
            return _container(mold, thickness, rung.method, attempted, attempts, tolerance, time.monotonic() - start)
        if outcome == "impossible" and (rung.method == "revolved" or isinstance(impossible[-1], HopelessError)):
            break
    if rejected and accept_best:
        name, best = min(rejected, key=lambda made: made[1].wall.deviation_p99_mm)
        return _container(mold, thickness, name, best, attempts, tolerance, time.monotonic() - start)
    if impossible:
        raise impossible[-1]
    story = "; ".join(f"{made.method}: {made.why.removeprefix(f'{made.method}: ')}" for made in attempts)
    remedies = [
        "another wall",
        *(["method auto"] if method != "auto" else []),
        *(["a larger tolerance"] if rejected else []),
        # A mesh is the finer, the more time there is.
        *(["more time"] if out_of_time or "inner_mesh" in dict(rejected) else []),
    ]
    best = ", or take the best there is (accept_best=True)" if rejected else ""
    raise HollowingError(
        tuple(attempts),
        f"{mold.name}: no method gives the wall {_named(thickness)} within {tolerance:.3g} mm ({story}); "
        f"ask for {' or '.join([', '.join(remedies[:-1]), remedies[-1]] if len(remedies) > 1 else remedies)}{best}",
    )


def granted(rung: Rung, left_seconds: float) -> float:
    """Return how long a rung may take: its share, but all there is where nothing useful would be left for a mesh."""
    share = rung.share * left_seconds
    useless = rung.method == "lofted" and left_seconds - share < SHORTEST_MESHING_SECONDS
    return left_seconds if useless else share


def _named(thickness: Thickness) -> str:
    return f"{shortened(thickness)} mm" if isinstance(thickness, UniformThickness) else shortened(thickness)


def ladder(mold: Mold, asked: AskedThickness) -> tuple[Rung, ...]:
    """Return the methods that may do for a mold and a wall, the likeliest first."""
    if mold.upright is None:
        return MESHED
    round_outside = mold.anatomy.is_revolved or mold.is_nearly_round
    if round_outside and asked.over_height is not None:
        return ROUND
    if asked.by_face is not None and not asked.by_face.blends:
        return STEPPED
    uniform = asked.over_height is not None and asked.over_height.uniform_mm is not None
    return UNIFORM if uniform and mold.anatomy.stem_top_mm == 0.0 else VARYING


def as_thickness(value: Thickness | str | float, regions: Sequence[str] = REGIONS) -> Thickness:
    """Return a thickness as data, whether it is given so, as text about the mold's regions, or as a number of mm."""
    if isinstance(value, str):
        return parse_thickness(value, regions)
    if isinstance(value, Thickness):
        return value
    if isinstance(value, (int, float, np.number)) and not isinstance(value, bool):
        return UniformThickness(float(value))
    raise InputError(f"wall: {value!r} is no thickness; give mm as a number, or text like 'body=2 base=5'")


def _check_fits(mold: Mold, asked: AskedThickness) -> None:
    """Refuse a wall that no method needs to try, with the limit that the methods would find."""
    anatomy = mold.anatomy
    closed = asked.minimum_mm >= 0.5 * min(anatomy.smallest_width_mm, anatomy.height_mm)
    if asked.over_height is not None and asked.bore_radius_mm is None:
        closed |= float(asked.over_height.at(anatomy.finish_height_mm)) >= anatomy.finish_outer_radius_mm
    if not closed:
        return
    if mold.core is not None and asked.over_height is not None:
        # The method for round molds measures along the axis, exactly.
        offset_meridian(wall_meridian(mold.core, anatomy, asked.over_height), asked.over_height)
    raise no_room(outside(mold, asked.at), asked.maximum_mm)


def _container(
    mold: Mold,
    thickness: Thickness,
    method: str,
    attempted: Attempted,
    attempts: list[Attempt],
    tolerance_mm: float,
    seconds: float,
) -> Container:
    candidate = attempted.candidate
    solid = None if candidate.solid is None else moved(candidate.solid, mold.placement)
    report = WallReport(
        method=method,
        tried=tuple(attempts),
        asked=str(thickness),
        wall=replace(attempted.wall, minimum_at_mm=_in_cad(mold, attempted.wall.minimum_at_mm)),
        tolerance_mm=tolerance_mm,
        solid=attempted.solid,
        glass_volume_mm3=attempted.glass.volume_mm3,
        weight_g=weight_g(attempted.glass.volume_mm3),
        brimful_ml=1e-3 * attempted.capacity.volume_mm3,
        centre_of_gravity_mm=_in_cad(mold, attempted.glass.centroid_mm),
        centre_of_gravity_filled_mm=_in_cad(mold, centre_of_gravity(attempted.glass, attempted.capacity)),
        area_outside_mm2=attempted.area_outside_mm2,
        area_inside_mm2=attempted.area_inside_mm2,
        seconds=seconds,
        notes=(
            *mold.repairs,
            *candidate.notes,
            *([f"not as asked: {attempted.fault}"] if attempted.fault else []),
        ),
    )
    return Container(
        mold,
        thickness,
        method,
        solid,
        candidate.cavity,
        candidate.inside,
        attempted.outer,
        attempted.outer_faces,
        report,
    )


def _in_cad(mold: Mold, point_mm: np.ndarray) -> np.ndarray:
    return mold.placement[:3, :3] @ point_mm + mold.placement[:3, 3]
