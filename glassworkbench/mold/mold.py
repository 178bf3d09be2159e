"""A mold: the outer shape of a container, standing upright, with what is known of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold.anatomy import Anatomy
from glassworkbench.mold.axis import Standing, axis_lines, find_standing, is_hollow, to_upright
from glassworkbench.mold.cavity import find_cavity, is_closed_around, looks_like_block
from glassworkbench.mold.closing import closed_solid
from glassworkbench.mold.face_numbers import numbers_in_file
from glassworkbench.mold.measures import mesh_of, signed_volume
from glassworkbench.mold.meridian import ROUND_MM, chain, face_profiles, flattened
from glassworkbench.mold.outer_shape import outer_shape, outer_shape_within_crest
from glassworkbench.mold.placing import moved, placement_of
from glassworkbench.mold.surveying import survey
from glassworkbench.scene import Mesh
from glassworkbench.scene.validate import positive

SMALLEST_MM, LARGEST_MM = 4.0, 10_000.0
"""No glass container is smaller or larger; a file that is was written in another unit than it declares."""

EMBOSSED_SHARE = 0.1
"""What stands out from a round core by less than this share of the largest radius is a thread or embossing."""

INSIDE_OUT = "it was inside out: its faces were turned outward"


@dataclass(frozen=True, eq=False)
class Mold:
    """The outer shape of a container.

    Parameters
    ----------
    solid : Part.Shape or None
        One closed solid, in CAD coordinates; None for a mold that is a mesh.
    upright : Part.Shape or None
        The same solid with its axis on +z and its lowest point at z = 0; its faces keep their numbers.
    placement : array (4, 4)
        Takes upright coordinates to CAD coordinates.
    anatomy : Anatomy
    name : str
    path : Path or None
        The file it came from, None for a FreeCAD object.
    sha256 : str
        Digest of that file, empty for a FreeCAD object.
    core : array (n, 4, 3) or None
        The meridian of its faces that are turned about the axis, base to finish; None if they do not connect.
    mesh : Mesh or None
        The upright body of a mold that was read from a mesh, closed; None for one of CAD faces.
    repairs : tuple of str
        A sentence for each thing that was changed of what the file holds, to make it a mold.
    file_faces : tuple of int
        For each face of the solid, the 1-based number in what the file holds, 0 where that has none; empty for a mesh.
    """

    solid: Part.Shape | None
    upright: Part.Shape | None
    placement: np.ndarray
    anatomy: Anatomy
    name: str
    path: Path | None = None
    sha256: str = ""
    core: np.ndarray | None = None
    mesh: Mesh | None = None
    repairs: tuple[str, ...] = ()
    file_faces: tuple[int, ...] = ()

    @property
    def is_nearly_round(self) -> bool:
        """Whether the body is one of revolution but for threads and embossing, so that its inside can be one."""
        return self.core is not None and self.anatomy.departure_mm < EMBOSSED_SHARE * self.anatomy.maximum_radius_mm


def mold_from_shape(
    shape: Part.Shape,
    name: str,
    *,
    axis: object = None,
    up: object = None,
    finish_height_mm: float | None = None,
    outer_shell: bool = False,
    block: bool = False,
    close_open_shell: bool = False,
) -> Mold:
    """Return the mold that a shape (of a selected FreeCAD object, in mm) is.

    Parameters
    ----------
    shape : Part.Shape
    name : str
    axis : array (3,), optional
        Direction of the axis, either sense.
    up : array (3,), optional
        Direction from base to finish.
    finish_height_mm : float, optional
        The shape is cut flat at this height above its lowest point, and the mouth is there.
    outer_shell : bool
        Take the outer shape of a container that is already hollow, closed over its rim, instead of refusing it.
    block : bool
        The solids are a mold block, and the container is the void in them; see `cavity.find_cavity`.
    close_open_shell : bool
        Close the flat holes of a surface that is open, instead of refusing it.

    Raises
    ------
    InputError
        As `read_mold`.
    """
    repairs: list[str] = [INSIDE_OUT] if faces_inward(shape) else []
    file_shape, rim_face = shape, 0
    if block:
        cavity = find_cavity(shape)
        shape = cavity.solid
        repairs.append(cavity.told)
        up = cavity.up if up is None and axis is None else up
    if close_open_shell:
        shape, told = closed_solid(shape)
        repairs += told
    solid, vertices, triangles = outward(single_solid(shape))
    if finish_height_mm is not None:
        solid, up = _cut_at_finish(solid, vertices, triangles, axis, up, finish_height_mm)
        solid, vertices, triangles = outward(solid)
    standing = find_standing(solid, vertices, triangles, axis=axis, up=up)
    if is_hollow(standing, vertices, triangles):
        if not outer_shell:
            raise InputError(already_hollow(solid))
        rim_face = numbers_in_file(solid, file_shape)[standing.finish_face - 1] if standing.finish_face else 0
        solid, told = _outer_solid(solid, standing, vertices)
        repairs += told
        solid, vertices, triangles = outward(solid)
        standing = find_standing(solid, vertices, triangles, up=standing.axis)
    placement = placement_of(standing, vertices)
    upright = moved(solid, np.linalg.inv(placement))
    profiles = face_profiles(upright.Faces)
    core = chain(profiles)
    if core is None:
        core = chain(face_profiles(upright.Faces, ROUND_MM), ROUND_MM)
    anatomy = survey(standing, placement, to_upright(vertices, standing), triangles, profiles, core)
    numbers = numbers_in_file(solid, file_shape)
    if rim_face:
        # The new face over the rim and the mouth stands for the rim.
        numbers = tuple(rim_face if k == anatomy.finish_face else n for k, n in enumerate(numbers, start=1))
    return Mold(solid, upright, placement, anatomy, name, core=core, repairs=tuple(repairs), file_faces=numbers)


def already_hollow(solid: Part.Shape) -> str:
    """Return what a hollow solid is, and what can be done with it, in a sentence."""
    if not looks_like_block(solid):
        return (
            "it is already hollow; leave the wall away to render it as it is, "
            "or take its outside as the mold (outer_shell=True) to hollow that anew"
        )
    if is_closed_around(solid):
        return "it is one solid around a void, as a mold block is; take the void in it as the mold (block=True)"
    return (
        "it is one solid that looks like a mold block; take the void in it as the mold (block=True), "
        "or its outside (outer_shell=True) if it is a container with so thick a wall"
    )


def _outer_solid(solid: Part.Shape, standing: Standing, vertices_mm: np.ndarray) -> tuple[Part.Shape, tuple[str, ...]]:
    """Return the outer shape of a hollow container, and what was changed to get it."""
    if standing.finish_face:
        return outer_shape(solid, standing.finish_face), ()
    placement = placement_of(standing, vertices_mm)
    outer, cut_mm = outer_shape_within_crest(moved(solid, np.linalg.inv(placement)))
    told = (f"its rounded rim has no level ring, so it was cut flat {cut_mm:.3g} mm below its top",) if cut_mm else ()
    return moved(outer, placement), told


def _cut_at_finish(
    solid: Part.Shape,
    vertices_mm: np.ndarray,
    triangles: np.ndarray,
    axis: object,
    up: object,
    finish_height_mm: float,
) -> tuple[Part.Shape, np.ndarray]:
    """Return what lies below the user's finish height, and the direction that is up."""
    direction, point = axis_lines(solid, vertices_mm, triangles, axis=axis, up=up)[0]
    placement = placement_of(Standing(direction, point, 0), vertices_mm)
    upright = moved(solid, np.linalg.inv(placement))
    from_axis = 2.0 * np.linalg.norm(vertices_mm - placement[:3, 3], axis=1).max()
    finish_height_mm = positive(finish_height_mm, "finish_height_mm")
    below = Part.makeCylinder(from_axis, 1.0 + finish_height_mm, FreeCAD.Vector(0, 0, -1))
    cut = upright.common(below)
    if not cut.Solids or finish_height_mm >= from_axis:
        raise InputError(
            f"finish_height_mm: {finish_height_mm:g} mm is not within the shape; give a height above its lowest point"
        )
    return moved(single_solid(cut), placement), direction


def check_size(size_mm: float) -> None:
    """Raise an InputError if something of this size is no container, so that its unit is another than it says."""
    # Before any mesh is made: OCC's mesher does not come back from a shape of a few tenths of a millimetre.
    if size_mm < SMALLEST_MM:
        raise InputError(
            f"it is only {size_mm:.2g} mm large, so its lengths are probably metres; "
            "give the scale to mm (scale_to_mm=1000)"
        )
    if size_mm > LARGEST_MM:
        raise InputError(
            f"it is {size_mm:.2g} mm large, too much for a container; "
            "give the scale to mm (scale_to_mm=0.001, if it is a thousand times too large)"
        )


def single_solid(shape: Part.Shape) -> Part.Shape:
    """Return the one closed solid that a shape holds.

    Raises
    ------
    InputError
        If it holds none, several, or an open shell.
    """
    if shape.isNull() or not shape.Faces:
        raise InputError("it is empty; choose something that holds a solid")
    if len(shape.Solids) > 1 and looks_like_block(shape):
        raise InputError(
            f"it holds {len(shape.Solids)} solids that look like a mold block; "
            "take the void in them as the mold (block=True)"
        )
    if len(shape.Solids) > 1:
        raise InputError(
            f"it holds {len(shape.Solids)} solids, but a mold is one; join them, or export only the container's, "
            "or take the void in them where they are a mold block (block=True)"
        )
    if not shape.Solids:
        # IGES knows no solids: its faces come loose, and are one when sewn.
        sewn = Part.makeShell(shape.Faces)
        sewn.sewShape()
        if not sewn.isClosed():
            kind = "an open shell" if shape.Shells else "loose faces"
            raise InputError(
                f"it holds no solid, only {kind}; close the surface and export it as a solid, "
                "or have its flat holes closed (close_open_shell=True)"
            )
        return Part.makeSolid(sewn)
    solid = shape.Solids[0]
    if not all(shell.isClosed() for shell in solid.Shells):
        raise InputError(
            "its solid is not closed (a shell has free edges); repair it in the CAD program, "
            "or have its flat holes closed (close_open_shell=True)"
        )
    return solid


def faces_inward(shape: Part.Shape) -> bool:
    """Return whether a shape is one solid whose faces are turned inward."""
    return len(shape.Solids) == 1 and shape.Solids[0].Volume < 0.0


def outward(solid: Part.Shape) -> tuple[Part.Shape, np.ndarray, np.ndarray]:
    """Return a closed solid with its faces turned outward, and its mesh (vertices (n, 3), triangles (m, 3))."""
    check_size(solid.BoundBox.DiagonalLength)
    vertices, triangles = mesh_of(solid)
    if signed_volume(vertices, triangles) > 0.0:
        return solid, vertices, triangles
    return solid.reversed(), vertices, triangles[:, ::-1]


def outer_meridian(mold: Mold) -> np.ndarray:
    """Return the exact profile of a mold of revolution, from the axis at the base, up the outside, to the axis on top.

    Parameters
    ----------
    mold : Mold

    Returns
    -------
    array (n, 4, 3)
        Rational cubic Bezier segments (r mm, z mm, weight) in upright coordinates, as `scene.Revolved` takes them.
        Curves of degree above 3 are approximated within `meridian.APPROXIMATION_MM`, all else is exact.

    Raises
    ------
    InputError
        If the mold is not a body of revolution.
    """
    if not mold.anatomy.is_revolved or mold.core is None:
        raise InputError(
            f"{mold.name}: it departs from a body of revolution by {mold.anatomy.departure_mm:.3g} mm, "
            "so no single meridian describes it"
        )
    return mold.core


def core_meridian(mold: Mold, spacing_mm: float = 0.25) -> np.ndarray | None:
    """Return the profile of a nearly round mold without its threads and embossing, fine enough to be offset.

    It is the chain of the faces that are turned about the axis, so it is exact where the body is round, and passes
    under whatever stands out from them.

    Parameters
    ----------
    mold : Mold
    spacing_mm : float
        Largest distance between neighbouring points; on curves they turn by at most 2 degrees from one to the next.

    Returns
    -------
    array (n, 2) or None
        Points (r mm, z mm) in upright coordinates from the axis at the base, up the outside, to the axis at the finish;
        None where the mold is not nearly round.
    """
    return flattened(mold.core, spacing_mm) if mold.is_nearly_round else None
