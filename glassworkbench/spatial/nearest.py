"""Which point s of a curved surface decides about a point p: where |p - s| - t(s) is lowest, t a thickness on it.

With t = 0 that is the nearest point. The native search (``native/``) and the one in numpy below do the same sums.
"""

from __future__ import annotations

import ctypes
import os
import weakref
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.ctypeslib import ndpointer

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.spatial.bulge import SIDES, sags

LIBRARY_FOLDER = Path(os.environ.get("GLASSWORKBENCH_LIBRARIES", Path(__file__).with_name("native") / "lib"))
INTERFACE_VERSION = 1

BLOCK = 32
"""Triangles that share one bounding box in the numpy search; small enough to look at all, large enough to skip many."""

_DOUBLES = ndpointer(np.float64, flags="C_CONTIGUOUS")
_INT32S = ndpointer(np.int32, flags="C_CONTIGUOUS")


@dataclass(frozen=True, eq=False)
class Nearest:
    """What a search finds for n points.

    Parameters
    ----------
    clearance_mm : array (n,)
        min over s of |p - s| - t(s).
    distance_mm : array (n,)
        From the point to the s that decides.
    feet_mm : array (n, 3)
        Those s.
    triangles : int array (n,)
        The triangles they lie on.
    """

    clearance_mm: np.ndarray
    distance_mm: np.ndarray
    feet_mm: np.ndarray
    triangles: np.ndarray


class NearestTriangles:
    """Triangles in an order in which the nearest is found quickly.

    Parameters
    ----------
    corners_mm : array (m, 3, 3)
        On the surface.
    normals : array (m, 3, 3)
        Unit normals of the surface at the corners. Between the corners it stands above the triangle, see `bulge.sags`.
    thickness_mm : array (m, 3), optional
        Thickness t at the corners, linear in between; 0 if not given.

    Raises
    ------
    InputError
        If there is no triangle, or a number is not finite.
    """

    def __init__(self, corners_mm: np.ndarray, normals: np.ndarray, thickness_mm: np.ndarray | None = None) -> None:
        self.corners_mm = np.ascontiguousarray(corners_mm, dtype=np.float64)
        self.normals = np.ascontiguousarray(normals, dtype=np.float64)
        count = len(self.corners_mm)
        thickness_mm = np.zeros((count, 3)) if thickness_mm is None else thickness_mm
        self.thickness_mm = np.ascontiguousarray(thickness_mm, dtype=np.float64)
        for array, shape in ((self.corners_mm, (3, 3)), (self.normals, (3, 3)), (self.thickness_mm, (3,))):
            if count == 0 or array.shape != (count, *shape) or not np.all(np.isfinite(array)):
                raise InputError(
                    "triangles: there must be some, with three finite corners, normals and thicknesses each"
                )
        library = _library()
        self._search = _NumpySearch(self) if library is None else _NativeSearch(self, library)

    def search(self, points_mm: np.ndarray) -> Nearest:
        """Return what decides about points (n, 3)."""
        points = np.ascontiguousarray(np.asarray(points_mm, dtype=np.float64).reshape(-1, 3))
        return self._search(points)


def available() -> bool:
    """Tell whether the native search is built."""
    return _library() is not None


@cache
def _library() -> ctypes.CDLL | None:
    path = next((file for file in LIBRARY_FOLDER.glob("*glassworkbench_spatial.*")), None)
    if path is None:
        return None
    try:
        library = ctypes.CDLL(str(path))
    except OSError:
        return None
    if library.spatial_interface_version() != INTERFACE_VERSION:
        return None
    library.spatial_tree_new.restype = ctypes.c_void_p
    library.spatial_tree_new.argtypes = (_DOUBLES, _DOUBLES, _DOUBLES, ctypes.c_int64)
    library.spatial_tree_free.restype = None
    library.spatial_tree_free.argtypes = (ctypes.c_void_p,)
    library.spatial_tree_search.restype = None
    library.spatial_tree_search.argtypes = (
        ctypes.c_void_p,
        _DOUBLES,
        ctypes.c_int64,
        ctypes.c_int,
        _DOUBLES,
        _DOUBLES,
        _DOUBLES,
        _INT32S,
    )
    return library


class _NativeSearch:
    def __init__(self, of: NearestTriangles, library: ctypes.CDLL) -> None:
        self._library = library
        count = len(of.corners_mm)
        self._tree = library.spatial_tree_new(of.corners_mm, of.normals, of.thickness_mm, count)
        if not self._tree:
            raise GlassWorkbenchError(f"there is no memory to search {count} triangles")
        weakref.finalize(self, library.spatial_tree_free, self._tree)

    def __call__(self, points: np.ndarray) -> Nearest:
        count = len(points)
        clearance, distance, feet = np.empty(count), np.empty(count), np.empty((count, 3))
        triangles = np.empty(count, dtype=np.int32)
        threads = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        self._library.spatial_tree_search(self._tree, points, count, threads, clearance, distance, feet, triangles)
        return Nearest(clearance, distance, feet, triangles)


class _NumpySearch:
    def __init__(self, of: NearestTriangles) -> None:
        self._order = along_a_curve(of.corners_mm.mean(axis=1))
        self._corners, self._normals = of.corners_mm[self._order], of.normals[self._order]
        self._thickness = of.thickness_mm[self._order]
        p = self._corners
        self._sags = sags(p, self._normals)
        bulge = 0.25 * np.abs(self._sags).sum(axis=1)[:, None]
        self._starts = np.arange(0, len(p), BLOCK)
        self._low = np.minimum.reduceat(p.min(axis=1) - bulge, self._starts, axis=0)
        self._high = np.maximum.reduceat(p.max(axis=1) + bulge, self._starts, axis=0)
        self._thickest = np.maximum.reduceat(self._thickness.max(axis=1), self._starts)

    def __call__(self, points: np.ndarray) -> Nearest:
        found = [self._nearest(point) for point in points]
        clearance, distance, feet, triangles = zip(*found, strict=True) if found else ([], [], [], [])
        return Nearest(
            np.array(clearance, dtype=float),
            np.array(distance, dtype=float),
            np.array(feet, dtype=float).reshape(-1, 3),
            np.array(triangles, dtype=np.int32),
        )

    def _nearest(self, point: np.ndarray) -> tuple:
        gap = np.maximum(np.maximum(self._low - point, point - self._high), 0.0)
        bound = np.linalg.norm(gap, axis=1) - self._thickest
        # A few near boxes give a value that rules out nearly all the others.
        near = np.argpartition(bound, 3)[:4] if len(bound) > 4 else np.arange(len(bound))
        best = self._lowest(point, near)
        others = np.setdiff1d(np.flatnonzero(bound < best[0]), near)
        return min(best, self._lowest(point, others), key=lambda found: found[0]) if len(others) else best

    def _lowest(self, point: np.ndarray, blocks: np.ndarray) -> tuple:
        rows = (self._starts[blocks, None] + np.arange(BLOCK)).ravel()
        rows = rows[rows < len(self._corners)]
        shares = _lowest_on_triangles(point, self._corners[rows], self._thickness[rows])
        normals = np.einsum("ij,ijk->ik", shares, self._normals[rows])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        height = sum(shares[:, i] * shares[:, j] * self._sags[rows, side] for side, (i, j) in enumerate(SIDES))
        feet = np.einsum("ij,ijk->ik", shares, self._corners[rows]) + height[:, None] * normals
        distance = np.linalg.norm(point - feet, axis=1)
        clearance = distance - np.einsum("ij,ij->i", shares, self._thickness[rows])
        k = int(np.argmin(clearance))
        return float(clearance[k]), float(distance[k]), feet[k], int(self._order[rows[k]])


def along_a_curve(centres: np.ndarray) -> np.ndarray:
    """Return an order (Morton's) in which neighbours in the list are neighbours in space."""
    size = max(float(np.ptp(centres, axis=0).max()), 1e-300)
    cells = ((centres - centres.min(axis=0)) / size * 1023.0).astype(np.int64)
    keys = np.zeros(len(cells), dtype=np.int64)
    for bit in range(10):
        for axis in range(3):
            keys |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(keys, kind="stable")


def _lowest_on_triangles(point: np.ndarray, corners: np.ndarray, thickness: np.ndarray) -> np.ndarray:
    """Return the barycentric coordinates (m, 3) of the point s of each flat triangle where |p - s| - t(s) is lowest.

    Notes
    -----
    Over a plane at distance d, with the gradient g of t in it, the minimum lies d g / sqrt(1 - g^2) from p's foot. The
    function is convex, so that is the minimum over the triangle if inside, else it lies on a side, where the same
    holds in one dimension. A thickness that grows faster than the distance (|g| >= 1) pushes the minimum to an end.
    """
    ab, ac, ap = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], point - corners[:, 0]
    d00, d01, d11 = (np.einsum("ij,ij->i", p, q) for p, q in ((ab, ab), (ab, ac), (ac, ac)))
    d20, d21 = np.einsum("ij,ij->i", ap, ab), np.einsum("ij,ij->i", ap, ac)
    t1, t2 = thickness[:, 1] - thickness[:, 0], thickness[:, 2] - thickness[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = d00 * d11 - d01 * d01
        v, w = (d11 * d20 - d01 * d21) / determinant, (d00 * d21 - d01 * d20) / determinant
        gv, gw = (d11 * t1 - d01 * t2) / determinant, (d00 * t2 - d01 * t1) / determinant
        squared = gv * t1 + gw * t2
        gap = np.maximum(np.einsum("ij,ij->i", ap, ap) - (v * d20 + w * d21), 0.0)
        reach = np.sqrt(gap / (1.0 - squared))
        v, w = v + reach * gv, w + reach * gw
        inside = (determinant > 1e-24 * d00 * d11) & (squared < 1.0) & (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0)
    return np.where(inside[:, None], np.column_stack([1.0 - v - w, v, w]), _lowest_on_sides(point, corners, thickness))


def _lowest_on_sides(point: np.ndarray, corners: np.ndarray, thickness: np.ndarray) -> np.ndarray:
    best = np.full(len(corners), np.inf)
    shares = np.zeros((len(corners), 3))
    for i, j in SIDES:
        along, offset = corners[:, j] - corners[:, i], point - corners[:, i]
        length = np.maximum(np.linalg.norm(along, axis=1), 1e-300)
        foot = np.einsum("ij,ij->i", offset, along) / length
        gap = np.sqrt(np.maximum(np.einsum("ij,ij->i", offset, offset) - foot**2, 0.0))
        rise = thickness[:, j] - thickness[:, i]
        slope = rise / length
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.clip((foot + gap * slope / np.sqrt(1.0 - slope**2)) / length, 0.0, 1.0)
        share = np.where(np.abs(slope) >= 1.0, (slope > 0.0).astype(float), share)
        value = np.hypot(gap, foot - share * length) - (thickness[:, i] + share * rise)
        lower = np.flatnonzero(value < best)
        best[lower] = value[lower]
        shares[lower] = 0.0
        shares[lower, i], shares[lower, j] = 1.0 - share[lower], share[lower]
    return shares
