"""The container's outer solid as the void in a mold block: halves or one block, with neck ring, bottom plate, core."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold.axis import Standing, axis_lines, is_hollow, to_upright
from glassworkbench.mold.measures import crossings_on_axis, mesh_of, signed_volume, smallest_box
from glassworkbench.mold.placing import moved, placement_of

AXIS_REACH_SHARE = 0.02
"""A solid whose extent across the axis ends farther from it than this share of the block's is a bolt or a pin."""

MOST_CORES = 2
"""How many solids may stand in the void (a core, and what holds it)."""

SMALLEST_VOID_SHARE = 0.01
"""A void below this share of the box around the block is a bore or a clearance, not a container."""

STEEL_SHARE = 0.5
"""A hollow solid that fills more than this share of the box around it is rather a block of steel than a glass."""

CORE_FIT = 0.97
"""A shoulder of a core that is at least this share of the void's radius closes it: there the container ends."""


@dataclass(frozen=True, eq=False)
class Cavity:
    """The void of a mold block.

    Parameters
    ----------
    solid : Part.Shape
        What fills the void, in the block's coordinates: the outer shape of the container.
    up : array (3,) or None
        Direction from base to mouth, which is where the void leaves the block or the core comes in; None for a void
        that is closed all around.
    told : str
        One sentence that says which solids were taken, which left out, and where the mouth is.
    """

    solid: Part.Shape
    up: np.ndarray | None
    told: str


def cavity_of_block(block: Part.Shape) -> Part.Shape:
    """Return the outer solid of the container that a mold block makes; see `find_cavity`."""
    return find_cavity(block).solid


def looks_like_block(shape: Part.Shape) -> bool:
    """Return whether several solids of a shape touch and lie around one axis, as the parts of a mold block do.

    One solid looks like a block, too, where it is hollow (see `axis.is_hollow`) and its void is closed all around or
    small beside it.
    """
    if not shape.Solids:
        return False
    vertices, triangles = mesh_of(shape)
    if len(shape.Solids) == 1:
        return _is_hollow_block(shape.Solids[0], vertices, triangles)
    line = axis_lines(shape, vertices, triangles)[0]
    upright = moved(shape, np.linalg.inv(placement_of(Standing(*line, 0), vertices)))
    parts, _ = _around_axis(upright.Solids)
    reach = 1e-3 * shape.BoundBox.DiagonalLength
    return any(a.distToShape(b)[0] < reach for a, b in itertools.combinations(parts, 2))


def _is_hollow_block(solid: Part.Shape, vertices: np.ndarray, triangles: np.ndarray) -> bool:
    direction, point = axis_lines(solid, vertices, triangles)[0]
    standing = Standing(direction, point, 0)
    if not is_hollow(standing, vertices, triangles):
        return False
    box_mm3 = smallest_box(to_upright(vertices, standing))
    return is_closed_around(solid) or signed_volume(vertices, triangles) > STEEL_SHARE * box_mm3


def is_closed_around(solid: Part.Shape) -> bool:
    """Return whether a hollow solid's void has no mouth."""
    return len(solid.Shells) > 1


def find_cavity(block: Part.Shape) -> Cavity:
    """Return the void of a mold block, closed at the mouth by the plane where the void leaves the block.

    What is tried is the box around the solids, less the solids: of the pieces, the container is the one on the axis
    that reaches the box, if at all, with a disc across the axis at one end. Solids beside the axis (bolts, pins) are
    ignored. Where only a gap is left on the axis, a core stands in the void; then solids are taken away until a void
    is found, and the container, whose outside is what is left, ends where the core's shoulder closes it.

    OCC's booleans can hang on damaged input: run this in a process with a time limit where that matters.

    Parameters
    ----------
    block : Part.Shape
        One or more closed solids, in mm.

    Raises
    ------
    InputError
        If the solids enclose no void that could be a container.
    """
    if not block.Solids:
        raise InputError("it holds no solid that could be a mold block; close its surfaces and export solids")
    vertices, triangles = mesh_of(block)
    for direction, point in axis_lines(block, vertices, triangles):
        placement = placement_of(Standing(direction, point, 0), vertices)
        upright = moved(block, np.linalg.inv(placement))
        parts, beside = _around_axis(upright.Solids)
        for count in range(min(MOST_CORES, len(parts) - 1) + 1):
            found = [
                (void, mouth, cores)
                for cores in itertools.combinations(parts, count)
                for void, mouth in _voids([part for part in parts if part not in cores])
            ]
            if found:
                void, mouth, cores = max(found, key=lambda each: each[0].Volume)
                solid, mouth, shoulder_mm = _below_shoulder(void, mouth, cores)
                told = _told(len(block.Solids), len(parts) - count, len(beside), count, shoulder_mm)
                return Cavity(moved(solid, placement), mouth * direction if mouth else None, told)
    raise InputError(
        "its solids enclose no void that is open at one end at most, so no container can be found in them; "
        "export the halves of the mold closed, without what lies around them"
    )


def _around_axis(solids: list[Part.Shape]) -> tuple[list[Part.Shape], list[Part.Shape]]:
    """Return the upright solids that reach the z axis, or nearly, with their extent across it, and the others."""
    boxes = [solid.BoundBox for solid in solids]
    size = max(max(box.XLength, box.YLength) for box in boxes)
    reach = AXIS_REACH_SHARE * size
    around, beside = [], []
    for solid, box in zip(solids, boxes, strict=True):
        near = max(box.XMin, -box.XMax, box.YMin, -box.YMax) < reach
        (around if near else beside).append(solid)
    return around, beside


def _voids(parts: list[Part.Shape]) -> Iterator[tuple[Part.Shape, float]]:
    """Yield the pieces of the box around the upright parts, less the parts, that may be the container.

    With each goes the sense along z in which it leaves the box: 1, -1, or 0 for one that is closed all around.
    """
    heights = [vertex.Z for part in parts for vertex in part.Vertexes]
    low, high = min(heights), max(heights)
    # Wider than the parts: where a box touches a round block along a line, booleans fail.
    side = 2.0 * max(part.BoundBox.DiagonalLength for part in parts)
    box = Part.makeBox(2.0 * side, 2.0 * side, high - low, FreeCAD.Vector(-side, -side, low))
    least = SMALLEST_VOID_SHARE * sum(part.Volume for part in parts)
    for piece in box.cut(parts).Solids:
        if piece.Volume > least and max(piece.BoundBox.XMax, piece.BoundBox.YMax) < 0.9 * side:
            vertices, triangles = mesh_of(piece)
            crossings = crossings_on_axis(vertices, triangles)
            full = len(crossings) == 2 and crossings[1] - crossings[0] > 0.5 * np.ptp(vertices[:, 2])
            if full:
                near = 1e-6 * (high - low)
                touched = [np.abs(vertices[:, 2] - end).min() < near for end in (low, high)]
                open_on_axis = [np.abs(crossings - end).min() < near for end in (low, high)]
                if touched == open_on_axis and not all(touched):
                    yield piece, float(touched[1]) - float(touched[0])


def _below_shoulder(
    void: Part.Shape, mouth: float, cores: tuple[Part.Shape, ...]
) -> tuple[Part.Shape, float, float | None]:
    """Return the void up to where the shoulder of a core closes it, the mouth's sense, and the height from the base.

    Without such a shoulder, the void and its mouth as they are, and None.
    """
    crossings = crossings_on_axis(*mesh_of(void))
    for sense in (mouth,) if mouth else (1.0, -1.0):
        shoulders = []
        for face in (face for core in cores for face in core.Faces if face.Surface.isPlanar()):
            height = face.CenterOfMass.z
            normal = face.normalAt(*face.Surface.parameter(face.CenterOfMass))
            within = crossings[0] + 1e-6 < height < crossings[1] - 1e-6
            if within and sense * normal.z < -1.0 + 1e-9 and _closes(face, void, height):
                shoulders.append(height)
        if shoulders:
            # The core comes in through the mouth: its shoulder faces the base, and the one next to it ends the glass.
            end = sense * min(sense * height for height in shoulders)
            size = 4.0 * void.BoundBox.DiagonalLength
            start = end - size if sense > 0.0 else end
            part = void.common(Part.makeBox(2 * size, 2 * size, size, FreeCAD.Vector(-size, -size, start)))
            base = crossings[0] if sense > 0.0 else crossings[1]
            return part.Solids[0], sense, abs(end - base)
    return void, mouth, None


def _closes(shoulder: Part.Face, void: Part.Shape, height: float) -> bool:
    """Return whether a ring around the z axis reaches the void's wall at its height, but for the clearance of a fit."""
    centre = FreeCAD.Vector(0, 0, height)
    if shoulder.isInside(centre, 1e-4, True) or not Part.Face(shoulder.OuterWire).isInside(centre, 1e-4, True):
        return False
    section = void.slice(FreeCAD.Vector(0, 0, 1), height)
    return bool(section) and shoulder.OuterWire.Length > CORE_FIT * max(wire.Length for wire in section)


def _told(solids: int, taken: int, beside: int, cores: int, shoulder_mm: float | None) -> str:
    left_out = [f"{beside} beside the axis (bolts, pins)"] if beside else []
    if cores:
        left_out.append(f"{cores} that {'stands' if cores == 1 else 'stand'} in it (the core)")
    if taken == solids:
        told = f"the mold is the void {'in its solid' if solids == 1 else f'that its {solids} solids enclose'}"
    else:
        told = f"the mold is the void that {taken} of its {solids} solids {'encloses' if taken == 1 else 'enclose'}"
    if left_out:
        told += f", without {' and '.join(left_out)}"
    if shoulder_mm is not None:
        return f"{told}; its mouth is where the core's shoulder closes it, {shoulder_mm:.4g} mm above the base"
    return f"{told}; its mouth is where the void leaves the block"
