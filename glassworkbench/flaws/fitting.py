"""Defects put into the wall of a container: the pieces that they are there, and which do not fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.flaws.defect import Defect, Grain, InCavity, InWall, Site, Thread
from glassworkbench.flaws.glass_wall import GlassWall
from glassworkbench.scene import ContainerGeometry
from glassworkbench.scene.touching import touching_pairs


@dataclass(frozen=True, eq=False)
class Fitted:
    """Defects in a wall.

    Parameters
    ----------
    grains : tuple of (int, Grain)
        With the number of the defect that each belongs to, counted from 0.
    threads : tuple of (int, Thread)
    faults : dict of int to str
        Why a defect does not fit, by its number; it has no grains and threads then.
    """

    grains: tuple[tuple[int, Grain], ...]
    threads: tuple[tuple[int, Thread], ...]
    faults: dict[int, str]


def fit(geometry: ContainerGeometry, defects: Sequence[Defect]) -> Fitted:
    """Put defects into the wall of a container.

    Raises
    ------
    InputError
        If a defect is impossible wherever it lies.
    """
    wall = GlassWall(geometry)
    sites = wall.sites(*np.array([(d.height_mm, d.angle_deg) for d in defects]).reshape(-1, 2).T)
    faults = {
        k: f"{defects[k]}: there is no wall at this height; the container reaches to {geometry.high_mm[2]:.4g} mm"
        for k, site in enumerate(sites)
        if site is None
    }
    grains, threads = [], []
    for k, (defect, site) in enumerate(zip(defects, sites, strict=True)):
        if site is None:
            continue
        if isinstance(defect, InWall):
            if defect.depth_mm is not None and defect.depth_mm >= site.wall_mm:
                faults[k] = (
                    f"{defect}: its middle, {defect.depth_mm:.4g} mm deep, lies outside the wall, "
                    f"which is {site.wall_mm:.3g} mm thick there"
                )
            else:
                grains += [(k, grain) for grain in defect.grains(site)]
        elif isinstance(defect, InCavity):
            thread, fault = _thread(wall, defect, site)
            if fault:
                faults[k] = fault
            else:
                threads.append((k, thread))
    inside = [(k, grain) for k, grain in grains if grain.within_wall]
    for (k, _), fits in zip(inside, wall.holds([grain for _, grain in inside]), strict=True):
        if not fits:
            faults[k] = (
                f"{defects[k]}: it reaches out of the wall, which is {sites[k].wall_mm:.3g} mm thick there; "
                "make it smaller, or change its depth_mm"
            )
    grains = [(k, grain) for k, grain in grains if k not in faults]
    for first, second in _overlaps(grains):
        if first not in faults:
            faults[second] = f"{defects[second]} overlaps with {defects[first]}; move one of them"
    return Fitted(tuple(piece for piece in grains if piece[0] not in faults), tuple(threads), faults)


def _thread(wall: GlassWall, defect: InCavity, site: Site) -> tuple[Thread | None, str]:
    """Return the thread, or None and why there can be none."""
    if not wall.has_cavity:
        return None, f"{defect}: the container's rim is rounded, so its inside is not known"
    if site.wall_mm >= np.hypot(*site.outside_mm[:2]):
        return None, f"{defect}: the glass reaches to the axis at this height; place it above the floor"
    other = wall.sites(np.array([defect.height_mm]), np.array([defect.other_angle_deg]))[0]
    if other is None:
        return None, f"{defect}: there is no wall for it to end in at {defect.other_angle_deg:g} deg"
    thread = defect.thread(site, other)
    if not wall.roots(thread):
        return (
            None,
            f"{defect}: its root of {2.0 * thread.root_radius_mm:.3g} mm reaches out of the wall; make it smaller",
        )
    return thread, ""


def _overlaps(grains: list[tuple[int, Grain]]) -> list[tuple[int, int]]:
    """Return the pairs of numbers of different defects that overlap, ascending."""
    if not grains:
        return []
    centres, semi_axes, rotations = (
        np.array([getattr(grain, field) for _, grain in grains]) for field in ("centre_mm", "semi_axes_mm", "rotation")
    )
    owner = np.array([k for k, _ in grains])
    pairs = np.sort(owner[touching_pairs(centres, semi_axes, rotations)], axis=1)
    return [(int(a), int(b)) for a, b in np.unique(pairs[pairs[:, 0] != pairs[:, 1]].reshape(-1, 2), axis=0)]


def fitted(geometry: ContainerGeometry, defects: Sequence[Defect]) -> Fitted:
    """Put defects into the wall of a container, all of them.

    Raises
    ------
    InputError
        If one does not fit; the message names it.
    """
    answer = fit(geometry, defects)
    if answer.faults:
        first = min(answer.faults)
        others = len(answer.faults) - 1
        more = f" ({others} more of {len(defects)} defects do not fit either)" if others else ""
        raise InputError(answer.faults[first] + more)
    return answer
