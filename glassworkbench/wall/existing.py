"""A container that is already hollow, as its file has it."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.freecad import Part
from glassworkbench.mold.axis import Standing, find_standing, is_hollow
from glassworkbench.mold.meridian import chain, face_profiles
from glassworkbench.mold.mold import mold_from_shape, outward, single_solid
from glassworkbench.mold.outer_shape import cavity_shape
from glassworkbench.mold.placing import moved, placement_of
from glassworkbench.mold.read import read_shape
from glassworkbench.scene import ContainerGeometry, Revolved
from glassworkbench.wall.container import geometry_within
from glassworkbench.wall.methods.revolved import PAST_MOUTH_MM
from glassworkbench.wall.seen import fine_mesh, seen_surface


def read_container(path: str | os.PathLike, *, scale_to_mm: float | None = None) -> ContainerGeometry:
    """Return the hollow container in a CAD file as a station takes it.

    Parameters
    ----------
    path : path
        STEP, IGES, BREP or FCStd file with one closed, hollow solid: the glass.
    scale_to_mm : float, optional
        Multiplies every length, for a file whose declared unit is wrong.

    Returns
    -------
    ContainerGeometry
        It has no cavity where the rim is rounded, as nothing then
        parts the inside from the outside.

    Raises
    ------
    InputError
        If the file cannot be read, does not hold exactly one closed solid, or that is a mold, full inside.
    """
    shape = read_shape(path, scale_to_mm=scale_to_mm, made_container=True)
    try:
        return container_from_shape(shape, Path(path).stem)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def container_from_shape(shape: Part.Shape, name: str) -> ContainerGeometry:
    """Return the container that a hollow shape (in mm) is, as a station takes it; see `read_container`."""
    solid, vertices, triangles = outward(single_solid(shape))
    standing = find_standing(solid, vertices, triangles)
    if not is_hollow(standing, vertices, triangles):
        raise InputError("it is a mold, full inside; say how thick its wall shall be, as thickness=3")
    try:
        mold = mold_from_shape(solid, name, outer_shell=True)
        upright = moved(solid, np.linalg.inv(mold.placement))
        cavity = cavity_shape(upright, standing.finish_face, PAST_MOUTH_MM)
    except InputError:
        return _glass_alone(solid, standing, vertices)
    turned = _turned(cavity)
    return geometry_within(mold, cavity if turned is None else turned)


def _glass_alone(solid: Part.Shape, standing: Standing, vertices_mm: np.ndarray) -> ContainerGeometry:
    upright = moved(solid, np.linalg.inv(placement_of(standing, vertices_mm)))
    turned = _turned(upright)
    if turned is None:
        surface, notes = seen_surface(upright, "the glass")
        low, high = surface.box_mm
    else:
        surface, notes = turned, ()
        low, high = fine_mesh(upright).box_mm
    return ContainerGeometry(surface, None, low, high, float(high[2]), notes)


def _turned(upright: Part.Shape) -> Revolved | None:
    """Return the surface of an upright solid if all its faces are turned about the axis."""
    profiles = face_profiles(upright.Faces)
    meridian = chain(profiles) if all(profile is not None for profile in profiles) else None
    return None if meridian is None else Revolved(meridian)
