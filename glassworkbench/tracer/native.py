"""The one door to the C++ core: checks dtypes and contiguity, and calls the C interface of ``native/tracer.h``."""

from __future__ import annotations

import ctypes
import os
import weakref
from functools import cache
from pathlib import Path

import numpy as np
from numpy.ctypeslib import ndpointer

from glassworkbench.errors import Cancelled, GlassWorkbenchError, InputError
from glassworkbench.scene import Body, Ellipsoids, Environment, Mesh, Panel, Patches, Revolved, Scene, Telecentric
from glassworkbench.scene.cameras import Camera, camera_frame
from glassworkbench.scene.validate import finite_array, unit_vector
from glassworkbench.tracer.control import Cancel, Control
from glassworkbench.tracer.curved_triangles import CurvedTriangles
from glassworkbench.tracer.film import Film
from glassworkbench.tracer.result import Crossing, Radiance

LIBRARY_FOLDER = Path(os.environ.get("GLASSWORKBENCH_LIBRARIES", Path(__file__).with_name("native") / "lib"))
"""Another folder holds other builds, such as those of 'make sanitize'."""

INTERFACE_VERSION = 5
BUILDS_BY_VECTOR_WIDTH = {2: ("baseline",), 4: ("v3", "baseline"), 8: ("v4", "v3", "baseline")}

_DOUBLES = ndpointer(np.float64, flags="C_CONTIGUOUS")
_FLOATS = ndpointer(np.float32, flags="C_CONTIGUOUS")
_INT32S = ndpointer(np.int32, flags="C_CONTIGUOUS")
_INT64S = ndpointer(np.int64, flags="C_CONTIGUOUS")


class _Settings(ctypes.Structure):
    _fields_ = (("cutoff", ctypes.c_double), ("maximum_depth", ctypes.c_int32), ("absorption", ctypes.c_int32))


class _Camera(ctypes.Structure):
    _fields_ = (
        ("parallel", ctypes.c_int32),
        ("width", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("origin", ctypes.c_double * 3),
        ("right", ctypes.c_double * 3),
        ("up", ctypes.c_double * 3),
        ("forward", ctypes.c_double * 3),
        ("half_height", ctypes.c_double),
    )


def available() -> bool:
    """Tell whether the native core is built and fits this processor."""
    return _library() is not None


def default_threads() -> int:
    """Return the number of processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def radiance(
    scene: Scene,
    origins: np.ndarray,
    directions: np.ndarray,
    *,
    cutoff: float = 1e-3,
    maximum_depth: int = 256,
    absorption: bool = True,
    threads: int | None = None,
    cancel: Cancel | None = None,
) -> Radiance:
    """Trace any rays through a scene; see `NativeScene.radiance`."""
    return NativeScene(scene).radiance(
        origins,
        directions,
        cutoff=cutoff,
        maximum_depth=maximum_depth,
        absorption=absorption,
        threads=threads,
        cancel=cancel,
    )


def follow(scene: Scene, origin: np.ndarray, direction: np.ndarray, *, room: int = 1024) -> list[Crossing]:
    """Return the interfaces along the refracted path of one ray; see `NativeScene.follow`."""
    return NativeScene(scene).follow(origin, direction, room=room)


class NativeScene:
    """A scene as the native core holds it; it lives as long as this object.

    Raises
    ------
    GlassWorkbenchError
        If the native core is not built, or has no memory for the scene.
    """

    def __init__(self, scene: Scene) -> None:
        library = _library()
        if library is None:
            raise GlassWorkbenchError("the native tracer is not built; run 'make build' in the project's folder")
        self._library = library
        self._scene = scene
        self._handle = library.glass_scene_new()
        if not self._handle:
            raise GlassWorkbenchError("the native tracer has no memory for the scene")
        weakref.finalize(self, library.glass_scene_free, self._handle)
        for body in scene.bodies:
            self._add_body(body)
        table = scene.medium_table()
        indices = scene.refractive_indices()
        absorptions = np.ascontiguousarray(scene.absorptions_per_mm())
        self._call("glass_set_media", table, len(table), indices, absorptions, len(indices))
        for light in scene.lights:
            if isinstance(light, Panel):
                self._call("glass_add_panel", light.origin_mm, light.u_mm, light.v_mm, light.radiance)
            elif isinstance(light, Environment):
                self._call("glass_set_environment", light.radiance, *light.radiance.shape[:2])
        self._call("glass_finish", scene.brightest())

    def radiance(
        self,
        origins: np.ndarray,
        directions: np.ndarray,
        *,
        cutoff: float = 1e-3,
        maximum_depth: int = 256,
        absorption: bool = True,
        threads: int | None = None,
        cancel: Cancel | None = None,
    ) -> Radiance:
        """Trace rays.

        Parameters
        ----------
        origins, directions : array (n, 3)
            In mm; directions of any length above 0.
        cutoff : float
            Rays whose weight falls below it are left out, and bounded.
        maximum_depth : int
            Interfaces along one path.
        absorption : bool
            Whether media absorb.
        threads : int, optional
            All processors where not given. The result does not depend on it.
        cancel : Cancel, optional

        Returns
        -------
        Radiance

        Raises
        ------
        InputError
            If the arrays do not fit together, a number is not finite, or a direction has no length.
        Cancelled
        """
        origins = finite_array(origins, (None, 3), "origins")
        n = len(origins)
        directions = finite_array(directions, (n, 3), "directions")
        if not np.all(np.any(directions, axis=1)):
            raise InputError("directions: a direction must have a length above 0")
        colour, left_out, bound, depth = np.empty((n, 3)), np.empty((n, 3)), np.empty(n), np.empty(n)
        crossings, leaks = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
        self._call(
            "glass_radiance",
            _Settings(cutoff, maximum_depth, absorption),
            threads or default_threads(),
            (cancel or Cancel()).control,
            n,
            origins,
            directions,
            colour,
            left_out,
            bound,
            depth,
            crossings,
            leaks,
        )
        return Radiance(colour, left_out, bound, depth, crossings, leaks)

    def image(
        self,
        film: Film,
        tiles: np.ndarray,
        wanted: np.ndarray,
        *,
        tolerance: float,
        halvings: int,
        cutoff: float,
        ambient: np.ndarray,
        absorption: bool,
        threads: int,
        cancel: Cancel,
    ) -> None:
        """Trace the wanted pixels of some tiles into a film, each until its error lies below the tolerance.

        Parameters
        ----------
        film : Film
        tiles : int64 array (n,)
            Numbers of tiles; see `tiles`.
        wanted : uint8 array (h, w)
            Not 0 where a pixel is to be traced.
        tolerance : float
            Of a pixel's radiance.
        halvings : int
            How often a pixel is halved before its error is looked at, 0 to 3.
        ambient : array (3,)
            Radiance that stands for the light at the end of paths that are left out.
        """
        self._call(
            "glass_image",
            _Settings(cutoff, 256, absorption),
            _camera(self._scene.camera, *self._scene.size),
            tolerance,
            halvings,
            np.ascontiguousarray(ambient, dtype=np.float64),
            threads,
            cancel.control,
            len(tiles),
            np.ascontiguousarray(tiles, dtype=np.int64),
            np.ascontiguousarray(wanted, dtype=np.uint8),
            film.radiance,
            film.sampling,
            film.pruned,
            film.depth_mm,
            film.totals,
        )

    def follow(self, origin: np.ndarray, direction: np.ndarray, *, room: int = 1024) -> list[Crossing]:
        """Return the interfaces along the refracted path of one ray (the reflected, where reflection is total)."""
        numbers, values = np.zeros((room, 4), dtype=np.int32), np.zeros((room, 5))
        origin = finite_array(origin, (3,), "origin")
        direction = unit_vector(direction, "direction")
        count = self._library.glass_follow(self._handle, origin, direction, room, numbers, values)
        if count < 0:
            raise GlassWorkbenchError("the native tracer failed to follow the ray; it ran out of memory")
        names = [body.name for body in self._scene.bodies]
        return [
            Crossing(value[:3].copy(), names[number[0]], bool(number[1]), int(number[2]), int(number[3]), *value[3:])
            for number, value in zip(numbers[:count], values[:count], strict=True)
        ]

    def _add_body(self, body: Body) -> None:
        surface = body.surface
        if isinstance(surface, Revolved):
            self._call("glass_add_revolved", surface.meridian, len(surface.meridian), surface.base_mm, surface.axis)
        elif isinstance(surface, Mesh):
            self._call(
                "glass_add_mesh",
                surface.vertices_mm,
                surface.normals,
                len(surface.vertices_mm),
                surface.triangles,
                len(surface.triangles),
            )
        elif isinstance(surface, Patches):
            self._add_patches(surface)
        elif isinstance(surface, Ellipsoids):
            self._call(
                "glass_add_ellipsoids",
                len(surface.centres_mm),
                surface.centres_mm,
                surface.semi_axes_mm,
                surface.rotations,
            )
        else:
            self._call("glass_add_ellipsoid", surface.centre_mm, surface.semi_axes_mm, surface.rotation)

    def _add_patches(self, patches: Patches) -> None:
        sheets, triangles = patches.sheets, CurvedTriangles.of(patches)
        self._call(
            "glass_add_patches",
            np.array([(*sheet.degrees, *sheet.control_points.shape[:2]) for sheet in sheets], dtype=np.int32),
            len(sheets),
            np.concatenate([knots for sheet in sheets for knots in (sheet.u_knots, sheet.v_knots)]),
            np.concatenate([sheet.control_points.ravel() for sheet in sheets]),
            len(patches.sheet_of_triangle),
            triangles.sheet,
            triangles.corners_mm,
            triangles.uv,
            triangles.pole,
            len(triangles.edges_mm),
            triangles.edges_mm,
            triangles.edge,
            triangles.along.astype(np.int32),
            triangles.low_mm,
            triangles.high_mm,
            triangles.cone_axis,
            triangles.cone_sine,
        )

    def _call(self, name: str, *arguments: object) -> None:
        outcome = getattr(self._library, name)(self._handle, *arguments)
        if outcome == 1:
            raise Cancelled("cancelled")
        if outcome != 0:
            raise GlassWorkbenchError("the native tracer ran out of memory")


def _camera(camera: Camera, width: int, height: int) -> _Camera:
    right, up, forward = camera_frame(camera)
    parallel = isinstance(camera, Telecentric)
    half_height = 0.5 * camera.height_mm if parallel else np.tan(0.5 * camera.vertical_field_of_view_rad)
    triple = ctypes.c_double * 3
    return _Camera(
        parallel,
        width,
        height,
        triple(*camera.origin_mm),
        triple(*right),
        triple(*up),
        triple(*forward),
        half_height,
    )


@cache
def _library() -> ctypes.CDLL | None:
    """Return the widest build that this processor runs, or None if none was built."""
    baseline = _load("baseline")
    if baseline is None:
        return None
    for build in BUILDS_BY_VECTOR_WIDTH[baseline.glass_vector_width()]:
        library = _load(build)
        if library is not None:
            return library
    return baseline


def _load(build: str) -> ctypes.CDLL | None:
    path = LIBRARY_FOLDER / f"libglassworkbench_tracer_{build}.so"
    if not path.exists():
        return None
    try:
        library = ctypes.CDLL(str(path))
    except OSError:
        return None
    library.glass_interface_version.restype = ctypes.c_int32
    if library.glass_interface_version() != INTERFACE_VERSION:
        return None
    _declare(library)
    return library


def _declare(library: ctypes.CDLL) -> None:
    handle, int32, int64 = ctypes.c_void_p, ctypes.c_int32, ctypes.c_int64
    settings, camera, control = (ctypes.POINTER(kind) for kind in (_Settings, _Camera, Control))
    signatures = {
        "glass_vector_width": (int32, ()),
        "glass_scene_new": (handle, ()),
        "glass_scene_free": (None, (handle,)),
        "glass_add_revolved": (int32, (handle, _DOUBLES, int64, _DOUBLES, _DOUBLES)),
        "glass_add_mesh": (int32, (handle, _DOUBLES, _DOUBLES, int64, _INT32S, int64)),
        "glass_add_patches": (
            int32,
            (
                handle,
                _INT32S,
                int64,
                _DOUBLES,
                _DOUBLES,
                int64,
                _INT32S,
                *[_DOUBLES] * 2,
                _INT32S,
                int64,
                _DOUBLES,
                _INT32S,
                _INT32S,
                *[_DOUBLES] * 4,
            ),
        ),
        "glass_add_ellipsoid": (int32, (handle, _DOUBLES, _DOUBLES, _DOUBLES)),
        "glass_add_ellipsoids": (int32, (handle, int64, *[_DOUBLES] * 3)),
        "glass_set_media": (int32, (handle, _INT32S, int64, _DOUBLES, _DOUBLES, int64)),
        "glass_add_panel": (int32, (handle, _DOUBLES, _DOUBLES, _DOUBLES, _DOUBLES)),
        "glass_set_environment": (int32, (handle, _DOUBLES, int64, int64)),
        "glass_finish": (int32, (handle, ctypes.c_double)),
        "glass_radiance": (
            int32,
            (handle, settings, int32, control, int64, *[_DOUBLES] * 6, _INT64S, _INT64S),
        ),
        "glass_image": (
            int32,
            (
                handle,
                settings,
                camera,
                ctypes.c_double,
                int32,
                _DOUBLES,
                int32,
                control,
                int64,
                _INT64S,
                ndpointer(np.uint8, flags="C_CONTIGUOUS"),
                *[_FLOATS] * 4,
                _INT64S,
            ),
        ),
        "glass_follow": (int64, (handle, _DOUBLES, _DOUBLES, int64, _INT32S, _DOUBLES)),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(library, name)
        function.restype = result
        function.argtypes = arguments
