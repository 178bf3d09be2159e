"""What it does to the image that some surfaces are only near to those they stand for.

A mesh stands for a smooth surface: along a side between normals n0 and n1 its triangles lie (n1 - n0) . (p1 - p0) / 8
off it (the sagitta of an arc). Normals of that surface at the vertices, interpolated, are off by about the square of
the angle to the triangles around; averages of the triangles' are off by a share of the angle itself. Patches tell
themselves how far off they are. The image is probed with rays at every second pixel, once as the scene is and thrice
with these surfaces displaced: along their normals, and with their normals tilted in two directions. What the probes
change by is the error.

Both displacements are exaggerated until they move what is seen by about a pixel, and the change is divided by the
same factor. So an edge in the image, which a probe would else seldom meet, counts as its height times the share of a
pixel that it moves. A pixel has the root mean square of the nine probes around it. This is first order and an average:
an estimate, no bound. An error that is not in the normals (a mesh too coarse for the shape it was made of) cannot be
known here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from glassworkbench.scene import Body, Mesh, Patches, Scene, Telecentric
from glassworkbench.tracer.extent import longest_chord_mm
from glassworkbench.tracer.part import Part

STEP = 2
"""Pixels from probe to probe."""

AVERAGED_SHARE = 0.4
"""Of the angle between a normal and the triangles it averages: how far it is off (median, a random mesh of a ball)."""

MOST_TILT = 0.05
"""Radians by which normals are tilted, at most, for what they change by to be proportional."""

Probe = Callable[[Scene, np.ndarray, np.ndarray], np.ndarray]
"""Returns the radiance (n, 3) of a scene along rays from origins (n, 3) in directions (n, 3)."""


@dataclass(frozen=True, eq=False)
class _Doubt:
    """A mesh whose surface is doubtful, at each vertex: by how much, and by what angle."""

    mesh: Mesh
    off_mm: np.ndarray
    off_rad: np.ndarray


def surface_error(scene: Scene, part: Part, probe: Probe) -> np.ndarray:
    """Return the estimated error (h, w), in radiance, that approximate surfaces add to each pixel of a part.

    Parameters
    ----------
    scene : Scene
    part : Part
        Of its image; a pixel's value does not depend on it.
    probe : callable
    """
    doubts = {k: doubt for k, body in enumerate(scene.bodies) if (doubt := _doubt(body)) is not None}
    if not doubts:
        return np.broadcast_to(0.0, (part.height, part.width))
    rows = np.arange(part.top // STEP - 1, (part.top + part.height - 1) // STEP + 2)
    columns = np.arange(part.left // STEP - 1, (part.left + part.width - 1) // STEP + 2)
    x, y = np.meshgrid((columns + 0.5) * STEP, (rows + 0.5) * STEP)
    width, height = scene.size
    rays = scene.camera.rays((2.0 * x.ravel() - width) / height, 1.0 - 2.0 * y.ravel() / height)

    is_meshes = all(doubt.mesh is scene.bodies[k].surface for k, doubt in doubts.items())
    base = probe(scene if is_meshes else _with(scene, {k: doubt.mesh for k, doubt in doubts.items()}), *rays)
    squares = np.zeros(len(base))
    for factor, meshes in _displaced(scene, doubts):
        squares += (np.abs(probe(_with(scene, meshes), *rays) - base).max(axis=1) / factor) ** 2
    squares = squares.reshape(x.shape)
    around = [squares[i : i + len(rows) - 2, j : j + len(columns) - 2] for i in range(3) for j in range(3)]
    errors = np.sqrt(np.mean(around, axis=0))
    at = np.arange(part.top, part.top + part.height) // STEP - rows[1]
    along = np.arange(part.left, part.left + part.width) // STEP - columns[1]
    return errors[np.ix_(at, along)]


def _displaced(scene: Scene, doubts: dict[int, _Doubt]) -> Iterator[tuple[float, dict[int, Mesh]]]:
    """Yield how much each displacement is exaggerated, and the meshes displaced so."""
    pixel_mm, pixel_rad = _pixel(scene)
    off_mm = max(float(np.max(doubt.off_mm)) for doubt in doubts.values())
    off_rad = max(float(np.max(doubt.off_rad)) for doubt in doubts.values())
    if off_mm > 0.0:
        factor = max(1.0, pixel_mm / off_mm)
        # Neighbours move apart, so that no wall between them is pierced.
        signs = np.resize([1.0, -1.0], len(doubts))
        yield (
            factor,
            {
                k: _moved(doubt.mesh, sign * factor * doubt.off_mm)
                for sign, (k, doubt) in zip(signs, doubts.items(), strict=True)
            },
        )
    if off_rad > 0.0:
        factor = max(1.0, min(MOST_TILT, 2.0 * pixel_rad) / off_rad)
        for direction in range(2):
            yield (
                factor,
                {k: _tilted(doubt.mesh, factor * doubt.off_rad, direction) for k, doubt in doubts.items()},
            )


def _pixel(scene: Scene) -> tuple[float, float]:
    """Return how wide a pixel is at the bodies, in mm, and in radians: seen from the camera, or along the bodies."""
    camera, height = scene.camera, scene.size[1]
    if isinstance(camera, Telecentric):
        return camera.height_mm / height, camera.height_mm / height / max(longest_chord_mm(scene), 1e-300)
    angle = 2.0 * np.tan(0.5 * camera.vertical_field_of_view_rad) / height
    return angle * float(np.linalg.norm(camera.target_mm - camera.origin_mm)), angle


def _with(scene: Scene, meshes: dict[int, Mesh]) -> Scene:
    bodies = [replace(body, surface=meshes.get(k, body.surface)) for k, body in enumerate(scene.bodies)]
    return replace(scene, bodies=bodies)


def _doubt(body: Body) -> _Doubt | None:
    surface = body.surface
    if isinstance(surface, Mesh):
        doubt = _doubt_of_mesh(surface)
    elif isinstance(surface, Patches) and surface.surface_error_mm > 0.0:
        doubt = _doubt_of_patches(surface)
    else:
        return None
    return doubt if doubt.off_mm.any() or doubt.off_rad.any() else None


def _doubt_of_mesh(mesh: Mesh) -> _Doubt:
    off_mm, off_rad = np.zeros(len(mesh.vertices_mm)), np.zeros(len(mesh.vertices_mm))
    corners = mesh.vertices_mm[mesh.triangles]
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(facets, axis=1, keepdims=True)
    facets = np.divide(facets, lengths, out=np.zeros_like(facets), where=lengths > 0.0)
    for k in range(3):
        here, there = mesh.triangles[:, k], mesh.triangles[:, (k + 1) % 3]
        turn = mesh.normals[there] - mesh.normals[here]
        rise = np.abs(np.einsum("ij,ij->i", turn, mesh.vertices_mm[there] - mesh.vertices_mm[here])) / 8.0
        np.maximum.at(off_mm, here, rise)
        np.maximum.at(off_mm, there, rise)
        between = np.linalg.norm(np.cross(mesh.normals[here], facets), axis=1)
        angle = np.arcsin(np.minimum(between, 1.0))
        np.maximum.at(off_rad, here, AVERAGED_SHARE * angle if mesh.has_averaged_normals else angle**2)
    # Flat faces turn by rounding.
    size = np.ptp(mesh.vertices_mm, axis=0).max()
    off_mm[off_mm < 1e-9 * size] = 0.0
    off_rad[off_rad < 1e-7] = 0.0
    return _Doubt(mesh, off_mm, off_rad)


def _doubt_of_patches(patches: Patches) -> _Doubt:
    """Return the doubt of a mesh with the sheets' normals.

    An error d that comes and goes along a patch of length l tilts it by up to 4 d / l, as an arc of that height does.
    """
    corners = patches.mesh.triangles.ravel()
    number = np.repeat(patches.sheet_of_triangle, 3)
    _, by_u, by_v = patches.evaluate(number, patches.uv_of_corner.reshape(-1, 2))
    normals = np.cross(by_u, by_v)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=patches.mesh.normals[corners].copy(), where=lengths > 0.0)
    outward = np.sign(np.einsum("ij,ij->i", normals, patches.mesh.normals[corners]))
    mesh = Mesh(patches.mesh.vertices_mm[corners], np.arange(len(corners)).reshape(-1, 3), outward[:, None] * normals)
    long_mm = np.array([_patch_length_mm(sheet.control_points) for sheet in patches.sheets])[number]
    off_mm = np.full(len(corners), patches.surface_error_mm)
    return _Doubt(mesh, off_mm, np.arctan(4.0 * off_mm / long_mm))


def _patch_length_mm(control_points: np.ndarray) -> float:
    """Return the typical length of a sheet's patches along their longer sides."""
    points = control_points[..., :3] / control_points[..., 3:]
    along_u = np.linalg.norm(np.diff(points, axis=2), axis=-1).sum(axis=2).mean()
    along_v = np.linalg.norm(np.diff(points, axis=3), axis=-1).sum(axis=3).mean()
    return max(float(along_u), float(along_v), 1e-300)


def _moved(mesh: Mesh, off_mm: np.ndarray) -> Mesh:
    """Return a mesh with its vertices moved outwards; those at one place stay together, so that it remains closed."""
    _, place = np.unique(mesh.vertices_mm, axis=0, return_inverse=True)
    place = place.reshape(-1)
    shift = np.zeros((place.max() + 1, 3))
    np.add.at(shift, place, off_mm[:, None] * mesh.normals)
    shift /= np.bincount(place)[:, None]
    return Mesh(mesh.vertices_mm + shift[place], mesh.triangles, mesh.normals)


def _tilted(mesh: Mesh, off_rad: np.ndarray, direction: int) -> Mesh:
    """Return a mesh with its normals tilted towards one of two directions along the surface."""
    least = np.eye(3)[np.argmin(np.abs(mesh.normals), axis=1)]
    aside = np.cross(mesh.normals, least)
    aside /= np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-300)
    if direction == 1:
        aside = np.cross(mesh.normals, aside)
    normals = mesh.normals + np.tan(off_rad)[:, None] * aside
    return Mesh(mesh.vertices_mm, mesh.triangles, normals / np.linalg.norm(normals, axis=1, keepdims=True))
