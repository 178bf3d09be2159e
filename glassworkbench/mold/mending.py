"""Makes a closed, outward mesh of the triangles in a file, tells what was mended, and refuses what cannot be."""

from __future__ import annotations

import importlib
import itertools
from collections import deque

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.mold.measures import signed_volume

WELD_SHARE = 1e-7
"""Vertices nearer to each other than this share of the mesh's size are one; STL writes each of them six times."""

SMALL_HOLE_SHARE = 0.02
"""A hole no wider than this share of the mesh's size is filled without asking."""

CROSSING_SHARE = 1e-4
"""Crossings no longer than this share of the size are left: where walls curve, meshers let slivers cross so little."""

FLAT_HOLE_SHARE = 1e-3
"""A hole whose edge keeps to a plane within this share of its width is flat."""


def mended(
    vertices_mm: np.ndarray, triangles: np.ndarray, *, close_open_shell: bool = False
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Return a closed, outward mesh (vertices (n, 3), triangles (m, 3)), and a sentence for each repair.

    Equal vertices are welded. Triangles that are there twice are dropped, those that face the other way turned, and
    small holes filled.

    Parameters
    ----------
    vertices_mm, triangles : arrays (n, 3), (m, 3)
    close_open_shell : bool
        Fill flat holes of any width.

    Raises
    ------
    InputError
        If it has edges with more than two faces, larger holes, several separate surfaces, one side only, or faces
        that cross each other; the sentence says where.
    """
    told: list[str] = []
    if not np.all(np.isfinite(vertices_mm)):
        raise InputError("a vertex is not finite (NaN or infinity); export the mesh again")
    size = float(np.linalg.norm(np.ptp(vertices_mm, axis=0)))
    vertices_mm, place = np.unique(welded(vertices_mm, WELD_SHARE * size), axis=0, return_inverse=True)
    triangles = _without_doubles(place.reshape(-1)[triangles], told)
    turned = _aligned(vertices_mm, triangles)
    triangles = np.where(turned[:, None], triangles[:, ::-1], triangles)
    vertices_mm, triangles = _filled(vertices_mm, triangles, size, close_open_shell, told)
    given = len(turned)
    turned = np.pad(turned, (0, len(triangles) - given))
    if signed_volume(vertices_mm, triangles) < 0.0:
        triangles, turned = triangles[:, ::-1], ~turned
    if np.all(turned[:given]):
        told.append("it was inside out: all its triangles were turned outward")
    elif np.any(turned[:given]):
        told.append(f"{turned[:given].sum()} of its {given} triangles faced inward and were turned")
    _check_crossings(vertices_mm, triangles, size, told)
    return vertices_mm, np.ascontiguousarray(triangles), told


def welded(points: np.ndarray, within: float) -> np.ndarray:
    """Return the points (n, 3), those nearer to each other than `within` made equal.

    Two near points share a cell of a grid unless a cell's wall parts them; then they share one of the grid moved by
    half a cell along some of the axes.
    """
    points = points.copy()
    for shift in itertools.product((0.0, 0.5), repeat=3):
        cells = np.floor(points / (4.0 * within) + shift)
        _, first, place = np.unique(cells, axis=0, return_index=True, return_inverse=True)
        points = points[first[place.reshape(-1)]]
    return points


def boundary_loops(vertices_mm: np.ndarray, triangles: np.ndarray) -> list[np.ndarray]:
    """Return the closed loops of vertex numbers along the edges that have one triangle only, in its sense.

    Raises
    ------
    InputError
        If two holes touch in a vertex, so that the loops cannot be told apart.
    """
    edges = _edges(triangles)
    count = len(vertices_mm)
    lone = edges[~np.isin(edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0])]
    starts, counts = np.unique(lone[:, 0], return_counts=True)
    if np.any(counts > 1):
        place = _where(vertices_mm[starts[np.argmax(counts)]])
        raise InputError(f"two of its holes touch {place}; close them in the program it comes from")
    ahead = dict(lone.tolist())
    loops = []
    while ahead:
        start, here = ahead.popitem()
        loop = [start]
        while here != start:
            loop.append(here)
            here = ahead.pop(here)
        loops.append(np.array(loop))
    return loops


def fan(vertices_mm: np.ndarray, loop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices with the middle of a hole's loop added, and the triangles (m, 3) that fill the hole from it.

    Raises
    ------
    InputError
        If the triangles would fold over each other.
    """
    edge = vertices_mm[loop]
    middle = edge.mean(axis=0)
    # Filling runs against the loop, whose sense is that of the triangles around the hole.
    corners = np.column_stack([np.roll(loop, -1), loop, np.full(len(loop), len(vertices_mm))])
    facets = np.cross(edge - middle, np.roll(edge, -1, axis=0) - middle)
    if np.any(facets @ facets.sum(axis=0) <= 0.0):
        place = _where(edge[0])
        raise InputError(f"it has a hole {place} whose edge is folded; close it in the program it comes from")
    return np.vstack([vertices_mm, middle]), corners


def _edges(triangles: np.ndarray) -> np.ndarray:
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)


def _where(point_mm: np.ndarray) -> str:
    x, y, z = point_mm
    return f"near ({x:.3f}, {y:.3f}, {z:.3f}) mm"


def _without_doubles(triangles: np.ndarray, told: list[str]) -> np.ndarray:
    corners = np.sort(triangles, axis=1)
    # Welding may close a sliver; what has lost a corner has no area and leaves no hole.
    kept = np.flatnonzero((corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]))
    _, first = np.unique(corners[kept], axis=0, return_index=True)
    if len(first) < len(triangles):
        told.append(f"{len(triangles) - len(first)} triangles without area, or there twice, were dropped")
    if len(first) < 4:
        raise InputError("it has no triangles that could be a container; export it again")
    return triangles[kept[np.sort(first)]]


def _aligned(vertices_mm: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return which triangles (m,) must be turned so that all face to the same side of their one surface."""
    edges = _edges(triangles)
    low, high = edges.min(axis=1), edges.max(axis=1)
    order = np.lexsort((high, low))
    same = (low[order][1:] == low[order][:-1]) & (high[order][1:] == high[order][:-1])
    crowded = np.flatnonzero(same[1:] & same[:-1])
    if len(crowded):
        middle = vertices_mm[edges[order[crowded[0]]]].mean(axis=0)
        raise InputError(
            f"more than two triangles meet in an edge {_where(middle)}, so inside and outside cannot be told apart; "
            "remove what is doubled there"
        )
    first, second = order[:-1][same], order[1:][same]
    against = edges[first, 0] == edges[second, 0]
    one, other = first % len(triangles), second % len(triangles)
    neighbours: list[list[tuple[int, bool]]] = [[] for _ in triangles]
    for a, b, turn in zip(one.tolist(), other.tolist(), against.tolist(), strict=True):
        neighbours[a].append((b, turn))
        neighbours[b].append((a, turn))
    turned = {0: False}
    waiting = deque([0])
    while waiting:
        here = waiting.popleft()
        for there, turn in neighbours[here]:
            wanted = turned[here] ^ turn
            if there not in turned:
                turned[there] = wanted
                waiting.append(there)
            elif turned[there] != wanted:
                middle = vertices_mm[triangles[there]].mean(axis=0)
                raise InputError(f"its surface has one side only (a twisted band {_where(middle)}); model it anew")
    if len(turned) < len(triangles):
        apart = next(number for number in range(len(triangles)) if number not in turned)
        raise InputError(
            f"it holds surfaces that are not joined, one of them {_where(vertices_mm[triangles[apart, 0]])}; "
            "export the container's outside alone"
        )
    return np.array([turned[number] for number in range(len(triangles))])


def _filled(
    vertices_mm: np.ndarray, triangles: np.ndarray, size: float, close_open_shell: bool, told: list[str]
) -> tuple[np.ndarray, np.ndarray]:
    loops = boundary_loops(vertices_mm, triangles)
    widths = [float(np.linalg.norm(np.ptp(vertices_mm[loop], axis=0))) for loop in loops]
    for loop, width in zip(loops, widths, strict=True):
        place = _where(vertices_mm[loop[0]])
        edge = vertices_mm[loop] - vertices_mm[loop].mean(axis=0)
        flat = np.linalg.svd(edge, compute_uv=False)[2] < FLAT_HOLE_SHARE * width * np.sqrt(len(loop))
        if width > SMALL_HOLE_SHARE * size and not (close_open_shell and flat):
            remedy = "have its flat holes closed (close_open_shell=True)" if flat else "close it"
            raise InputError(f"it has a hole {width:.3g} mm wide {place}; {remedy}, or export it as a closed surface")
        vertices_mm, lid = fan(vertices_mm, loop)
        triangles = np.concatenate([triangles, lid])
    if loops:
        widest = int(np.argmax(widths))
        count = "a hole was" if len(loops) == 1 else f"{len(loops)} holes were"
        place = _where(vertices_mm[loops[widest][0]])
        told.append(f"{count} filled, the widest of {widths[widest]:.3g} mm {place}")
    return vertices_mm, triangles


def _check_crossings(vertices_mm: np.ndarray, triangles: np.ndarray, size: float, told: list[str]) -> None:
    mesh = importlib.import_module("Mesh").Mesh(vertices_mm[triangles].reshape(-1, 3).tolist())
    crossings = [(np.array(start), np.array(end)) for _, _, start, end in mesh.getSelfIntersections()]
    if not crossings:
        return
    lengths = [float(np.linalg.norm(end - start)) for start, end in crossings]
    longest = int(np.argmax(lengths))
    place = _where(np.mean(crossings[longest], axis=0))
    if lengths[longest] > CROSSING_SHARE * size:
        raise InputError(
            f"its surface crosses itself in {len(crossings)} places, the longest of them {place}; "
            "repair it in the program it comes from"
        )
    told.append(f"slivers cross each other over at most {lengths[longest]:.2g} mm, {place}, and were left so")
