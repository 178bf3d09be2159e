"""A staged scene with defects in its container."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.flaws.defect import AIR, Defect, Grain, Substance
from glassworkbench.flaws.fitting import Fitted, fitted
from glassworkbench.flaws.kinds import IN_GLASS
from glassworkbench.scene import Body, ContainerGeometry, Ellipsoids, Medium, Scene
from glassworkbench.scene.media import MAXIMUM_BODIES

TOLD = 6
"""As many defects are named in the image's metadata; the others are counted."""


def with_defects(scene: Scene, geometry: ContainerGeometry, defects: Sequence[Defect]) -> Scene:
    """Return a station's scene with defects in the glass of its container.

    Parameters
    ----------
    scene : Scene
        As `staging.station` returns it: its first medium is the glass.
    geometry : ContainerGeometry
        What it was staged with.
    defects : sequence of Defect
        Those that are made with the wall (`kinds.IN_WALL`) are in the geometry already, and only told.

    Raises
    ------
    InputError
        If a defect does not lie in the wall, two overlap, or they are of more kinds than a scene may have bodies.
    """
    if not defects:
        return scene
    pieces = fitted(geometry, [defect for defect in defects if isinstance(defect, IN_GLASS)])
    substances = _grouped(pieces)
    threads = [Body(f"thread_{k + 1}", thread.surface) for k, (_, thread) in enumerate(pieces.threads)]
    _check_bodies(scene, substances, len(threads))
    wall, *others = scene.media
    bodies, media = [], []
    glass = _joined(wall.where, threads)
    carved = ""
    for number, (substance, grains) in enumerate(substances.items(), start=1):
        name = f"{substance.name}_{number}"
        bodies.append(Body(name, _ellipsoids(grains)))
        if substance == AIR:
            carved = f" and not {name}"
        else:
            media.append(_medium(f"{name} and ({glass})", substance, wall))
    media.append(replace(wall, where=f"({glass}){carved}"))
    media += [replace(medium, where=_without(medium.where, threads)) for medium in others]
    return replace(
        scene,
        bodies=(*scene.bodies, *bodies, *threads),
        media=media,
        metadata={**scene.metadata, "defects": _told(defects)},
    )


def _grouped(pieces: Fitted) -> dict[Substance, list[Grain]]:
    """Return the ellipsoids of each substance, those that hold where others overlap first."""
    groups: dict[Substance, list[Grain]] = {}
    seen: dict[int, int] = {}
    rank: dict[Substance, int] = {}
    for k, grain in pieces.grains:
        groups.setdefault(grain.substance, []).append(grain)
        rank[grain.substance] = max(rank.get(grain.substance, 0), seen.get(k, 0))
        seen[k] = seen.get(k, 0) + 1
    return {substance: groups[substance] for substance in sorted(groups, key=rank.__getitem__)}


def _check_bodies(scene: Scene, substances: dict[Substance, list[Grain]], threads: int) -> None:
    count = len(scene.bodies) + len(substances) + threads
    if count > MAXIMUM_BODIES:
        raise InputError(
            f"defects: {len(substances)} substances, {threads} threads and the container are {count} bodies, but a "
            f"scene may have at most {MAXIMUM_BODIES}; give stones one mineral and cords one index_offset"
        )


def _joined(wall: str, threads: list[Body]) -> str:
    """Return where the container's glass is, with threads inside it."""
    if not threads:
        return wall
    return f"{wall} or outer and ({' or '.join(body.name for body in threads)})"


def _without(where: str, threads: list[Body]) -> str:
    if not threads:
        return where
    return f"({where}) and not ({' or '.join(body.name for body in threads)})"


def _ellipsoids(grains: list[Grain]) -> Ellipsoids:
    return Ellipsoids(
        np.array([grain.centre_mm for grain in grains]),
        np.array([grain.semi_axes_mm for grain in grains]),
        np.array([grain.rotation for grain in grains]),
    )


def _medium(where: str, substance: Substance, glass: Medium) -> Medium:
    index = substance.refractive_index
    absorption = substance.absorption_per_mm
    return replace(
        glass,
        where=where,
        refractive_index=(glass.refractive_index if index is None else index) + substance.index_offset,
        absorption_per_mm=glass.absorption_per_mm if absorption is None else np.full(3, absorption),
    )


def _told(defects: Sequence[Defect]) -> str:
    named = "; ".join(f"{defect} ({defect.severity})" for defect in defects[:TOLD])
    return named if len(defects) <= TOLD else f"{named}; and {len(defects) - TOLD} more"
