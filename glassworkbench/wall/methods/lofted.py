"""The cavity of a container that need not be round: one smooth surface through its curves in meridian half-planes."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import Mold
from glassworkbench.spatial import Nearest, NearestTriangles
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.candidate import Candidate
from glassworkbench.wall.lofting.half_planes import Clearance, aligned, bridged, chosen_angles, floor_height, trace
from glassworkbench.wall.lofting.loft_surface import LoftSurface, chord_parameters
from glassworkbench.wall.measuring.outside import Outside
from glassworkbench.wall.methods.revolved import PAST_MOUTH_MM
from glassworkbench.wall.solids import hollow_solid
from glassworkbench.wall.worker import run_in_worker

HALF_PLANES, ROWS = 48, 64
"""The grid to begin with."""

STEPS = 300
"""The curve in a half-plane is traced by about this many steps."""

MOST_LINES = 320
"""The grid is not refined beyond this many columns, and as many rows."""

FIRST_PASSES, PASSES = 3, 4
"""How often the grid is refined before it is known whether more of it can lead to a cavity within the outside; then."""

TOLERANCE_SHARE, TOLERANCE_MM = 0.008, 0.008
"""Between its grid points the surface should come within this share of the thinnest wall, or this."""

THIN_SHARE = 0.03
"""Nowhere should the wall be thinner than asked by more than this share."""

OFF_SHARE = 0.003
"""Share of the surface that may be off by more than the tolerance, at creases."""

SHORTEST_SHARE = 0.05
"""No span of the grid is halved that is shorter everywhere than this share of the thinnest wall."""

TURN_RAD, LONGEST_MM, SHORTEST_MM = np.radians(3.0), 4.0, 0.4
"""In the mesh each span of the grid is parted until it turns by less than this and is not longer, but no shorter."""

SAG_MM = 0.01
"""It is parted also until its chords, along it and across, are no farther than this from the surface."""

FOOT_MM = 0.02
"""What lies this close to embossing is the edge of its foot."""

STEM_SLICE_MM, STEM_SECTORS = 0.5, 48
"""A full stem's radius is its smallest this close to its top; a disc of so many sectors closes it."""

OUTER_POINTS, OTHER_PART_SHARE = 4000, 0.25
"""Seen from so many outer points, the cavity may go on outside the surface by no more than this share of the wall."""


def lofted(mold: Mold, asked: AskedThickness, wall: Outside, seconds: float) -> Candidate:
    """Return a container whose cavity is one smooth surface about the axis, refined as long as time allows.

    Raises
    ------
    InputError
        If the walls meet, so that the cavity is parted or vanishes.
    GlassWorkbenchError
        If a half-plane through the axis meets the wanted inner surface in more than one curve.
    """
    end = time.monotonic() + seconds
    anatomy = mold.anatomy
    if anatomy.stem_top_mm > 0.0:
        wall = _with_full_stem(wall, asked, anatomy.stem_top_mm)
    base, finish = anatomy.stem_top_mm or anatomy.push_up_mm, anatomy.finish_height_mm
    floor = floor_height(wall.clearance, wall.distance, base, finish)
    angles = chosen_angles(wall.clearance, floor, finish, HALF_PLANES)
    step = (finish - floor + anatomy.maximum_radius_mm) / STEPS
    meridians = aligned(trace(wall.clearance, wall.distance, angles, floor, finish, step), finish, ROWS)
    across = np.column_stack([np.cos(angles), np.sin(angles)])
    behind = _behind_embossing(wall)
    hidden = behind(wall.clearance(_in_space(meridians, across).reshape(-1, 3))).reshape(meridians.shape[:2])
    grid = _in_space(bridged(meridians, hidden), across)
    clearance = _blind(wall.clearance, behind)
    grid[1:-1] = _settled(clearance, grid[1:-1])
    grid[-1] = _settled(clearance, grid[-1], level=True)
    surface = LoftSurface(*chord_parameters(grid), grid)
    surface = _refined(surface, clearance, asked.minimum_mm, FIRST_PASSES, end)
    places = _places(wall, anatomy.stem_top_mm)
    _check_within(surface, places)
    surface = _refined(surface, clearance, asked.minimum_mm, PASSES, end)
    _check_within(surface, places)
    _check_whole(wall, surface, places)
    u, v = _mesh_parameters(surface)
    solid = None if mold.upright is None else _solid(mold, surface, end - time.monotonic())
    # OCC would take minutes for a worse mesh of the same surface.
    return Candidate(solid, surface.mesh(u, v, PAST_MOUTH_MM), surface.mesh(u, v))


def _with_full_stem(wall: Outside, asked: AskedThickness, stem_top_mm: float) -> Outside:
    """Return an outside that the top of the stem closes, so that the cavity keeps the wall above it."""
    corners = wall.corners_mm.reshape(-1, 3)
    level = np.abs(corners[:, 2] - stem_top_mm).min() + STEM_SLICE_MM
    radius = np.hypot(*corners[np.abs(corners[:, 2] - stem_top_mm) <= level, :2].T).min()
    turn = np.linspace(0.0, 2.0 * np.pi, STEM_SECTORS + 1)
    ring = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(len(turn), stem_top_mm)])
    centre = np.broadcast_to([0.0, 0.0, stem_top_mm], (STEM_SECTORS, 3))
    disc = np.stack([centre, ring[1:], ring[:-1]], axis=1)
    faces = np.zeros(STEM_SECTORS, dtype=wall.faces.dtype)
    return replace(
        wall,
        corners_mm=np.concatenate([wall.corners_mm, disc]),
        normals=np.concatenate([wall.normals, np.broadcast_to([0.0, 0.0, -1.0], disc.shape)]),
        thickness_mm=np.concatenate(
            [wall.thickness_mm, np.stack([asked.at(disc[:, k], faces) for k in range(3)], axis=1)]
        ),
        faces=np.concatenate([wall.faces, faces]),
        collar=np.concatenate([wall.collar, np.zeros(STEM_SECTORS, dtype=bool)]),
        embossed=np.concatenate([wall.embossed, np.zeros(STEM_SECTORS, dtype=bool)]),
    )


def _in_space(meridians: np.ndarray, across: np.ndarray) -> np.ndarray:
    return np.concatenate([meridians[..., :1] * across, meridians[..., 1:]], axis=2)


def _behind_embossing(wall: Outside) -> Callable[[Nearest], np.ndarray]:
    """Return what tells of found outer points whether embossing, or the edge of its foot, is what they lie on.

    Under a thread as wide as the wall is thick the nearest outer points are those on the edge of its foot.
    """
    embossing = wall.embossing()
    if embossing is None:
        return lambda found: np.zeros(len(found.triangles), dtype=bool)
    foot = NearestTriangles(embossing.corners_mm, embossing.normals)
    return lambda found: wall.embossed[found.triangles] | (foot.search(found.feet_mm).distance_mm < FOOT_MM)


def _blind(clearance: Clearance, behind: Callable[[Nearest], np.ndarray]) -> Clearance:
    """Return a clearance that is content with any point behind embossing, so that the surface leads smoothly past."""

    def content(points: np.ndarray) -> Nearest:
        found = clearance(points)
        return replace(found, clearance_mm=np.where(behind(found), 0.0, found.clearance_mm))

    return content


def _settled(clearance: Clearance, points: np.ndarray, level: bool = False) -> np.ndarray:
    """Return points (..., 3) moved onto the inner surface, straight away from or towards what decides about them."""
    moved = points.reshape(-1, 3).copy()
    rows = np.arange(len(moved))
    for _ in range(8):
        found = clearance(moved[rows])
        away = moved[rows] - found.feet_mm
        if level:
            away[:, 2] = 0.0
        full = np.maximum(np.linalg.norm(moved[rows] - found.feet_mm, axis=1), 1e-12)
        squared = np.maximum(np.einsum("ij,ij->i", away, away), 0.05 * full**2)
        moved[rows] -= (found.clearance_mm * full / squared)[:, None] * away
        rows = rows[np.abs(found.clearance_mm) > 1e-5]
        if not len(rows):
            break
    return moved.reshape(points.shape)


def _refined(surface: LoftSurface, clearance: Clearance, thinnest_mm: float, passes: int, end: float) -> LoftSurface:
    """Return a surface with more columns and rows where it leaves the wanted one between them."""
    for _ in range(passes):
        lines = len(surface.u) + len(surface.v)
        for halve in (_columns_halved, _rows_halved):
            if time.monotonic() < end:
                surface = halve(surface, clearance, thinnest_mm)
        if len(surface.u) + len(surface.v) == lines:
            break
    return surface


def _columns_halved(surface: LoftSurface, clearance: Clearance, thinnest_mm: float) -> LoftSurface:
    between = 0.5 * (surface.u[1:] + surface.u[:-1])
    points = surface.at(between, surface.v)
    chords = np.linalg.norm(np.roll(surface.points, -1, axis=1) - surface.points, axis=2)[1:]
    heights = np.linalg.norm(np.diff(surface.points, axis=0), axis=2)
    off = clearance(points[1:].reshape(-1, 3)).clearance_mm.reshape(len(points) - 1, -1)
    worst = _worst(off.T, (chords * heights).T, chords.T, thinnest_mm, MOST_LINES - len(between))
    new = points[:, worst]
    new[1:-1] = _settled(clearance, new[1:-1])
    new[-1] = _settled(clearance, new[-1], level=True)
    return surface.with_columns(between[worst], new)


def _rows_halved(surface: LoftSurface, clearance: Clearance, thinnest_mm: float) -> LoftSurface:
    between = 0.5 * (surface.v[1:] + surface.v[:-1])
    points = surface.at(surface.u[:-1], between)
    chords = np.linalg.norm(np.roll(surface.points, -1, axis=1) - surface.points, axis=2)[1:]
    heights = np.linalg.norm(np.diff(surface.points, axis=0), axis=2)
    off = clearance(points.reshape(-1, 3)).clearance_mm.reshape(len(points), -1)
    worst = _worst(off, chords * heights, heights, thinnest_mm, MOST_LINES - len(between))
    return surface.with_rows(between[worst], _settled(clearance, points[worst]))


def _worst(off: np.ndarray, areas: np.ndarray, lengths: np.ndarray, thinnest_mm: float, room: int) -> np.ndarray:
    """Return the numbers of the spans (of n, with m points each) that have to be halved, in order.

    Parameters
    ----------
    off, areas, lengths : array (n, m)
        Deviation at the points in the middle of the spans, the area each stands for, and the spans' lengths there.
    """
    tolerance = max(TOLERANCE_SHARE * thinnest_mm, TOLERANCE_MM)
    thin = off < -max(THIN_SHARE * thinnest_mm, TOLERANCE_MM)
    bad = (areas * ((np.abs(off) > tolerance) | thin)).sum(axis=1)
    order = np.argsort(-bad, kind="stable")
    left = bad.sum() - np.cumsum(bad[order])
    needed = np.zeros(len(bad), dtype=bool)
    needed[order[: 1 + int(np.searchsorted(-left, -OFF_SHARE * areas.sum()))]] = bad.sum() > OFF_SHARE * areas.sum()
    needed |= thin.any(axis=1)
    needed &= (bad > 0.0) & (lengths.max(axis=1) > SHORTEST_SHARE * thinnest_mm)
    chosen = order[needed[order]][: max(room, 0)]
    return np.sort(chosen)


def _mesh_parameters(surface: LoftSurface) -> tuple[np.ndarray, np.ndarray]:
    """Return parameters for a mesh whose triangles turn and stretch little."""
    points, normals = surface.with_normals(surface.u, surface.v)
    u = _parted(surface.u, points.swapaxes(0, 1)[:, 1:], normals.swapaxes(0, 1)[:, 1:])
    return u[:-1], _parted(surface.v, points, normals)


def _parted(knots: np.ndarray, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return knots (n,) with more in between, judged by the lines (n, m, 3) of points and normals."""
    cosines = np.clip(np.einsum("ijk,ijk->ij", normals[1:], normals[:-1]), -1.0, 1.0)
    turns, chords = np.arccos(cosines), np.linalg.norm(np.diff(points, axis=0), axis=2)
    lengths = chords.max(axis=1)
    smooth = np.maximum(turns.max(axis=1) / TURN_RAD, np.sqrt((turns * chords).max(axis=1) / (8.0 * SAG_MM)))
    wanted = np.minimum(smooth, lengths / SHORTEST_MM)
    parts = np.ceil(np.maximum(np.maximum(wanted, lengths / LONGEST_MM), 1.0)).astype(int)
    pieces = [
        np.linspace(low, high, count, endpoint=False)
        for low, high, count in zip(knots[:-1], knots[1:], parts, strict=True)
    ]
    return np.append(np.concatenate(pieces), knots[-1])


@dataclass(frozen=True, eq=False)
class _Places:
    """Points (n, 3) of the outside, the unit normals (n, 3) and the thickness (n,) asked there."""

    points_mm: np.ndarray
    normals: np.ndarray
    thickness_mm: np.ndarray


def _places(wall: Outside, stem_top_mm: float) -> _Places:
    """Return places spread over the outside, without embossing and a stem."""
    glass = ~wall.collar & ~wall.embossed & (wall.corners_mm[:, :, 2].max(axis=1) < wall.finish_height_mm)
    glass &= wall.corners_mm[:, :, 2].min(axis=1) >= stem_top_mm
    numbers = np.flatnonzero(glass)[:: max(1, int(glass.sum()) // OUTER_POINTS)]
    normals = wall.normals[numbers].mean(axis=1)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return _Places(wall.corners_mm[numbers].mean(axis=1), normals, wall.thickness_mm[numbers].mean(axis=1))


def _check_within(surface: LoftSurface, places: _Places) -> None:
    """Raise where the outside lies in the cavity."""
    _refuse_if_any(places.points_mm[_within(surface, places.points_mm)])


def _check_whole(wall: Outside, surface: LoftSurface, places: _Places) -> None:
    """Raise where the wanted cavity goes on outside the surface."""
    depth = (1.0 + OTHER_PART_SHARE) * places.thickness_mm
    behind = places.points_mm - depth[:, None] * places.normals
    wanted = wall.clearance(behind).clearance_mm > 0.5 * OTHER_PART_SHARE * places.thickness_mm
    wrong = behind[wanted & ~_within(surface, behind)]
    _refuse_if_any(wrong[wrong[:, 2] < wall.finish_height_mm])


def _refuse_if_any(places_mm: np.ndarray) -> None:
    if len(places_mm):
        x, y, z = places_mm[0]
        raise GlassWorkbenchError(
            f"the half-plane at angle {np.degrees(np.arctan2(y, x)) % 360.0:.0f} degrees meets the body in more than "
            f"one curve at height {z:.1f} mm"
        )


def _within(surface: LoftSurface, points: np.ndarray) -> np.ndarray:
    """Tell whether points (n, 3) lie inside the surface's curve at their angle, between the two nearest columns."""
    middle = surface.points[len(surface.v) // 2]
    angles = np.unwrap(np.arctan2(middle[:, 1], middle[:, 0]))
    angles = np.append(angles, angles[0] + 2.0 * np.pi)
    own = angles[0] + (np.arctan2(points[:, 1], points[:, 0]) - angles[0]) % (2.0 * np.pi)
    column = np.clip(np.searchsorted(angles, own, side="right") - 1, 0, len(angles) - 2)
    share = (own - angles[column]) / (angles[column + 1] - angles[column])
    after = (column + 1) % (len(angles) - 1)
    flat = np.stack([np.hypot(surface.points[..., 0], surface.points[..., 1]), surface.points[..., 2]])
    r, z = (1.0 - share) * flat[:, :, column] + share * flat[:, :, after]
    crosses = (z[1:] > points[:, 2]) != (z[:-1] > points[:, 2])
    with np.errstate(divide="ignore", invalid="ignore"):
        at = r[:-1] + (points[:, 2] - z[:-1]) / (z[1:] - z[:-1]) * (r[1:] - r[:-1])
    return np.count_nonzero(crosses & (at > np.hypot(points[:, 0], points[:, 1])), axis=0) % 2 == 1


def _bodies(surface: LoftSurface) -> tuple[Part.Shape, Part.Shape]:
    """Return the cavity up to the finish plane, and reaching straight up past it, as solids."""
    face = surface.face()
    height = surface.points[-1, 0, 2]
    mouth = next(
        edge
        for edge in face.Edges
        if not edge.Degenerated
        and all(abs(vertex.Z - height) < 1e-6 for vertex in edge.Vertexes)
        and abs(edge.CenterOfMass.z - height) < 1e-6
    )
    lid = Part.Face(Part.Wire([mouth]))
    rise = FreeCAD.Vector(0.0, 0.0, PAST_MOUTH_MM)
    collar = mouth.extrude(rise)
    top = lid.copy()
    top.translate(rise)
    return _sewn([face, lid]), _sewn([face, *collar.Faces, top])


def _sewn(faces: list[Part.Shape]) -> Part.Shape:
    shell = Part.Shell(faces)
    shell.sewShape(1e-6)
    if len(shell.Shells) != 1 or not shell.Shells[0].isClosed():
        raise GlassWorkbenchError("the inner surface does not close at the mouth")
    solid = Part.Solid(shell.Shells[0])
    return solid if solid.Volume > 0.0 else solid.reversed()


def _solid(mold: Mold, surface: LoftSurface, seconds: float) -> Part.Shape:
    cavity, past_mouth = _bodies(surface)
    try:
        return hollow_solid(mold.upright, cavity, mold.anatomy.finish_face)
    # OCC raises errors of many kinds, which derive from Exception only.
    except Exception:
        # Slower, but it needs no ring of the finish plane around the mouth.
        return run_in_worker(cut, [mold.upright, past_mouth], {}, seconds)[0]


def cut(outer: Part.Shape, past_mouth: Part.Shape) -> list[Part.Shape]:
    """Return the outer solid without the cavity; for `run_in_worker`.

    Raises
    ------
    GlassWorkbenchError
        If not exactly one valid solid is left.
    """
    rest = outer.cut(past_mouth)
    if len(rest.Solids) != 1 or not rest.isValid():
        raise GlassWorkbenchError("the cavity does not come out of the outside as one valid solid")
    return [rest.Solids[0]]
