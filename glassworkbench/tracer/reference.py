"""The tracer in numpy, to be read beside the physics; the native one must agree with it.

A ray carries one bit a body, "I am inside", and the scene's table says which medium those bits mean: that alone is
constructive solid geometry, nested media and bubbles. At each change of medium the ray splits in two, and the light
of both branches is followed until what is left of a branch falls below a cut-off; what was cut off is bounded.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene import Environment, Panel, Scene
from glassworkbench.tracer.reference_surfaces import Crosser, crosser, largest_coordinate_mm
from glassworkbench.tracer.result import Crossing, Radiance

TOUCHING = 1e-9
"""Crossings no farther than this from a ray's start, relative to the scene's coordinates, may be the surface it starts
on; the bits tell."""

MOST_STRAIGHT_CROSSINGS = 4096
"""Crossings that a path may make without a change of medium; only a broken scene needs more."""

RAYS_AT_ONCE = 8192
"""Rays that are followed together; bounds the memory."""


def fresnel(index_before: np.ndarray, index_after: np.ndarray, cos_incidence: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the reflectances R_s and R_p of a smooth interface, and the cosine of the angle of refraction.

    Fresnel's equations for intensities, with Snell's law n1 sin i = n2 sin t. Near the critical angle
    cos t = sqrt((1 - sin t)(1 + sin t)) keeps the digits that 1 - sin^2 t would lose; beyond it R_s = R_p = 1 and
    cos t = 0.

    References
    ----------
    M. Born and E. Wolf, Principles of Optics, 7th edition, section 1.5.
    """
    sin_incidence = np.sqrt((1.0 - cos_incidence) * (1.0 + cos_incidence))
    sin_refraction = index_before / index_after * sin_incidence
    total = sin_refraction >= 1.0
    cos_refraction = np.sqrt(np.where(total, 0.0, (1.0 - sin_refraction) * (1.0 + sin_refraction)))
    along_s = index_before * cos_incidence, index_after * cos_refraction
    along_p = index_before * cos_refraction, index_after * cos_incidence
    with np.errstate(invalid="ignore"):
        reflectance_s = np.where(total, 1.0, ((along_s[0] - along_s[1]) / (along_s[0] + along_s[1])) ** 2)
        reflectance_p = np.where(total, 1.0, ((along_p[0] - along_p[1]) / (along_p[0] + along_p[1])) ** 2)
    return reflectance_s, reflectance_p, cos_refraction


def radiance(
    scene: Scene,
    origins: np.ndarray,
    directions: np.ndarray,
    *,
    cutoff: float = 1e-3,
    maximum_depth: int = 256,
) -> Radiance:
    """Return what rays see in a scene.

    Parameters
    ----------
    scene : Scene
    origins : array (n, 3)
        In mm.
    directions : array (n, 3)
        Of any length above 0.
    cutoff : float
        Branches whose weight is below this in every channel are left out, and enter the bound.
    maximum_depth : int
        Changes of medium that a path may meet; longer ones are left out, and enter the bound.

    Raises
    ------
    InputError
        If a direction has no length, or a number is not finite.
    """
    origins, directions = _checked_rays(origins, directions)
    tracing = _Tracing.of(scene)
    parts = [
        _radiance_of_chunk(tracing, origins[start:end], directions[start:end], cutoff, maximum_depth)
        for start in range(0, max(len(origins), 1), RAYS_AT_ONCE)
        for end in [start + RAYS_AT_ONCE]
    ]
    return Radiance(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Radiance)))


def follow(
    scene: Scene, origin: np.ndarray, direction: np.ndarray, *, reflect_at: tuple[int, ...] = (), room: int = 1024
) -> list[Crossing]:
    """Return the interfaces along one path of a ray, in order, until it meets a light or `room` of them.

    Parameters
    ----------
    scene : Scene
    origin : array (3,)
        In mm.
    direction : array (3,)
        Of any length above 0.
    reflect_at : tuple of int
        Interfaces, counted from 0, at which the path takes the reflected branch; elsewhere it takes the refracted
        one, unless reflection is total.
    room : int
        The most interfaces that are returned.

    Raises
    ------
    InputError
        If the direction has no length, or a number is not finite.
    """
    origins, directions = _checked_rays(np.reshape(origin, (1, 3)), np.reshape(direction, (1, 3)))
    tracing = _Tracing.of(scene)
    rays = _start(tracing, origins, directions)
    path: list[Crossing] = []
    while len(path) < room and rays.straight[0] <= MOST_STRAIGHT_CROSSINGS:
        met = _next_crossing(tracing, rays)
        if met.body[0] < 0 or _meet_panels(tracing, rays, met.distance)[1][0] >= 0:
            break
        rays = rays.moved(met.distance)
        split = _split(tracing, rays, met)
        is_interface = split.medium_before[0] != split.medium_after[0]
        reflects = is_interface and (split.reflectance[0] == 1.0 or len(path) in reflect_at)
        rays = split.reflected if reflects else split.refracted
        if is_interface:
            path.append(
                Crossing(
                    rays.origin[0],
                    scene.bodies[met.body[0]].name,
                    bool(met.entering[0]),
                    int(split.medium_before[0]),
                    int(split.medium_after[0]),
                    float(split.cos_incidence[0]),
                    float(split.reflectance[0]),
                )
            )
    return path


def _checked_rays(origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    origins, directions = np.array(origins, dtype=np.float64), np.array(directions, dtype=np.float64)
    if origins.ndim != 2 or origins.shape[1] != 3 or origins.shape != directions.shape:
        raise InputError(f"rays: expected origins and directions of n x 3, got {origins.shape} and {directions.shape}")
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    if not (np.all(np.isfinite(origins)) and np.all(np.isfinite(lengths)) and np.all(lengths > 0.0)):
        raise InputError("rays: every origin must be finite and every direction have a length above 0")
    return origins, directions / lengths


@dataclass(frozen=True, eq=False)
class _Tracing:
    """A scene made ready for tracing."""

    crossers: tuple[Crosser, ...]
    touching_mm: float
    medium_table: np.ndarray
    refractive_indices: np.ndarray
    absorptions_per_mm: np.ndarray
    panels: tuple[Panel, ...]
    environment: Environment | None
    brightest: float

    @classmethod
    def of(cls, scene: Scene) -> _Tracing:
        environments = [light for light in scene.lights if isinstance(light, Environment)]
        size = max((largest_coordinate_mm(body.surface) for body in scene.bodies), default=0.0)
        return cls(
            tuple(crosser(body.surface) for body in scene.bodies),
            TOUCHING * size,
            scene.medium_table(),
            scene.refractive_indices(),
            scene.absorptions_per_mm(),
            tuple(light for light in scene.lights if isinstance(light, Panel)),
            environments[0] if environments else None,
            scene.brightest(),
        )


@dataclass(frozen=True, eq=False)
class _Rays:
    """Rays under way, one a row: `owner` is the ray they split from, `inside` the bits, `last_body` the body just
    crossed (-1: none), `depth` and `straight` count crossings with and without a change of medium, `travelled_mm`
    the way since the start.
    """

    owner: np.ndarray
    origin: np.ndarray
    direction: np.ndarray
    weight: np.ndarray
    inside: np.ndarray
    last_body: np.ndarray
    depth: np.ndarray
    straight: np.ndarray
    travelled_mm: np.ndarray

    def take(self, chosen: np.ndarray) -> _Rays:
        return _Rays(*(getattr(self, f.name)[chosen] for f in fields(self)))

    def with_(self, other: _Rays) -> _Rays:
        return _Rays(*(np.concatenate([getattr(self, f.name), getattr(other, f.name)]) for f in fields(self)))

    def but(self, **changed: np.ndarray) -> _Rays:
        return _Rays(*(changed.get(f.name, getattr(self, f.name)) for f in fields(self)))

    def moved(self, distance: np.ndarray) -> _Rays:
        return self.but(
            origin=self.origin + distance[:, None] * self.direction, travelled_mm=self.travelled_mm + distance
        )


@dataclass(frozen=True, eq=False)
class _Met:
    """The crossing that each ray meets first: body -1 and an infinite distance where there is none."""

    body: np.ndarray
    distance: np.ndarray
    entering: np.ndarray
    normal: np.ndarray
    smooth_normal: np.ndarray


def _start(tracing: _Tracing, origins: np.ndarray, directions: np.ndarray) -> _Rays:
    """Return the rays with the bits they start with: inside a body whose surface they cross an odd number of times."""
    count = len(origins)
    inside = np.zeros(count, dtype=np.int64)
    for bit, cross in enumerate(tracing.crossers):
        found = cross(origins, directions)
        crossed = np.bincount(found.line[found.distance_mm > 0.0], minlength=count)
        inside |= (crossed & 1) << bit
    none = np.zeros(count, dtype=np.int64)
    return _Rays(
        np.arange(count), origins, directions, np.ones((count, 3)), inside, none - 1, none, none, np.zeros(count)
    )


def _next_crossing(tracing: _Tracing, rays: _Rays) -> _Met:
    """Return what each ray crosses next.

    The surface that a ray starts on is told by the sense of the crossing: it contradicts the bits, for the ray is
    past it. No ray is moved off a surface, so walls and bubbles may be as thin as they like.
    """
    count = len(rays.owner)
    body = np.full(count, -1)
    distance = np.full(count, np.inf)
    entering = np.zeros(count, dtype=bool)
    normal, smooth_normal = np.zeros((count, 3)), np.zeros((count, 3))
    for number, cross in enumerate(tracing.crossers):
        found = cross(rays.origin, rays.direction)
        line, along = found.line, found.distance_mm
        is_inside = (rays.inside[line] >> number) & 1 == 1
        contradicts = found.entering == is_inside
        behind = np.where(rays.last_body[line] == number, along <= 0.0, along < -tracing.touching_mm)
        candidate = np.flatnonzero(~behind & ~(contradicts & (np.abs(along) <= tracing.touching_mm)))
        order = candidate[np.lexsort((along[candidate], line[candidate]))]
        nearest = order[np.append(True, np.diff(line[order]) > 0)] if len(order) else order
        nearer = nearest[np.maximum(along[nearest], 0.0) < distance[line[nearest]]]
        row = line[nearer]
        body[row] = number
        distance[row] = np.maximum(along[nearer], 0.0)
        entering[row] = found.entering[nearer]
        normal[row] = found.normal[nearer]
        smooth_normal[row] = found.smooth_normal[nearer]
    return _Met(body, distance, entering, normal, smooth_normal)


def _meet_panels(tracing: _Tracing, rays: _Rays, before: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the distance to the nearest panel before the given distance, and its number, -1 where there is none."""
    nearest, number = before.copy(), np.full(len(before), -1)
    for k, panel in enumerate(tracing.panels):
        normal = np.cross(panel.u_mm, panel.v_mm)
        area_squared = normal @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (panel.origin_mm - rays.origin) @ normal / (rays.direction @ normal)
            place = rays.origin + distance[:, None] * rays.direction - panel.origin_mm
        along_u = np.cross(place, panel.v_mm) @ normal / area_squared
        along_v = np.cross(panel.u_mm, place) @ normal / area_squared
        on_panel = (along_u >= 0.0) & (along_u <= 1.0) & (along_v >= 0.0) & (along_v <= 1.0)
        closer = on_panel & (distance > 0.0) & (distance < nearest)
        nearest = np.where(closer, distance, nearest)
        number = np.where(closer, k, number)
    return nearest, number


def _environment_radiance(environment: Environment | None, directions: np.ndarray) -> np.ndarray:
    """Return the surroundings' radiance (n, 3), bilinear in the polar angle from +z and the azimuth."""
    if environment is None:
        return np.zeros_like(directions)
    image = environment.radiance
    height, width = image.shape[:2]
    x, y, z = directions.T
    row = np.arctan2(np.hypot(x, y), z) / np.pi * height - 0.5
    column = (np.arctan2(y, x) / (2.0 * np.pi) + 0.5) * width - 0.5
    row = np.clip(row, 0.0, height - 1.0)
    upper, left = np.floor(row).astype(np.int64), np.floor(column).astype(np.int64)
    down, right = (row - upper)[:, None], (column - left)[:, None]
    lower = np.minimum(upper + 1, height - 1)
    left, next_left = left % width, (left + 1) % width
    top = (1.0 - right) * image[upper, left] + right * image[upper, next_left]
    bottom = (1.0 - right) * image[lower, left] + right * image[lower, next_left]
    return (1.0 - down) * top + down * bottom


@dataclass(frozen=True, eq=False)
class _Split:
    """Both branches of rays at crossings; which of them carry light, `reflectance` tells."""

    reflected: _Rays
    refracted: _Rays
    reflectance: np.ndarray
    cos_incidence: np.ndarray
    medium_before: np.ndarray
    medium_after: np.ndarray


def _split(tracing: _Tracing, rays: _Rays, met: _Met) -> _Split:
    """Split rays that stand at crossings into the reflected and the refracted branch.

    Where the medium stays, or only its absorption changes, nothing is reflected and the ray goes straight on.
    """
    bit = np.left_shift(1, met.body)
    inside_after = np.where(met.entering, rays.inside | bit, rays.inside & ~bit)
    medium_before, medium_after = tracing.medium_table[rays.inside], tracing.medium_table[inside_after]
    index_before, index_after = tracing.refractive_indices[medium_before], tracing.refractive_indices[medium_after]

    bent = _bend(rays.direction, met.smooth_normal, index_before, index_after)
    # An interpolated normal may send light to the wrong side of its triangle; then the triangle's own decides.
    outgoing = np.where(met.entering, 1.0, -1.0)
    reflected_goes_through = outgoing * _dot(bent[0], met.normal) <= 0.0
    refracted_comes_back = (bent[2] < 1.0) & (outgoing * _dot(bent[1], met.normal) >= 0.0)
    wrong = (reflected_goes_through | refracted_comes_back) & np.any(met.normal != met.smooth_normal, axis=1)
    again = _bend(rays.direction, met.normal, index_before, index_after)
    reflected, refracted, reflectance, cos_incidence = (
        np.where(wrong if a.ndim == 1 else wrong[:, None], b, a) for a, b in zip(bent, again, strict=True)
    )

    plain = index_before == index_after
    reflectance = np.where(plain, 0.0, reflectance)
    refracted = np.where(plain[:, None], rays.direction, refracted)
    interface = medium_before != medium_after
    onward = rays.but(last_body=met.body, depth=rays.depth + interface, straight=rays.straight + ~interface)
    return _Split(
        onward.but(direction=reflected, weight=rays.weight * reflectance[:, None]),
        onward.but(direction=refracted, weight=rays.weight * (1.0 - reflectance)[:, None], inside=inside_after),
        reflectance,
        cos_incidence,
        medium_before,
        medium_after,
    )


def _bend(
    directions: np.ndarray, normals: np.ndarray, index_before: np.ndarray, index_after: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Return reflected and refracted directions, unpolarised reflectance (R_s + R_p) / 2, and cos of incidence."""
    along = _dot(directions, normals)
    facing = np.where((along < 0.0)[:, None], normals, -normals)
    cos_incidence = np.minimum(np.abs(along), 1.0)
    reflectance_s, reflectance_p, cos_refraction = fresnel(index_before, index_after, cos_incidence)
    ratio = index_before / index_after
    reflected = directions + 2.0 * cos_incidence[:, None] * facing
    refracted = ratio[:, None] * directions + (ratio * cos_incidence - cos_refraction)[:, None] * facing
    return _unit(reflected), _unit(refracted), 0.5 * (reflectance_s + reflectance_p), cos_incidence


def _radiance_of_chunk(
    tracing: _Tracing, origins: np.ndarray, directions: np.ndarray, cutoff: float, maximum_depth: int
) -> Radiance:
    """Follow all branches of the rays in step, one crossing a round."""
    count = len(origins)
    seen, left_out, bound = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count)
    depth_mm = np.full(count, np.inf)
    crossings, leaks = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
    rays = _start(tracing, origins, directions)
    while len(rays.owner):
        met = _next_crossing(tracing, rays)
        distance, panel = _meet_panels(tracing, rays, met.distance)

        # Beer-Lambert: what a medium lets through falls exponentially with the way in it.
        absorption = tracing.absorptions_per_mm[tracing.medium_table[rays.inside]]
        finite = np.where(np.isfinite(distance), distance, 0.0)
        rays = rays.but(weight=rays.weight * np.exp(-absorption * finite[:, None]))

        for k, light in enumerate(tracing.panels):
            lit = panel == k
            np.add.at(seen, rays.owner[lit], rays.weight[lit] * light.radiance)
        escapes = (panel < 0) & (met.body < 0)
        surroundings = _environment_radiance(tracing.environment, rays.direction[escapes])
        np.add.at(seen, rays.owner[escapes], rays.weight[escapes] * surroundings)
        np.add.at(leaks, rays.owner[escapes], rays.inside[escapes] != 0)

        goes_on = (panel < 0) & (met.body >= 0)
        rays = rays.take(goes_on).moved(distance[goes_on])
        met = _Met(*(getattr(met, f.name)[goes_on] for f in fields(met)))
        contradicts = met.entering == ((rays.inside >> met.body) & 1 == 1)
        np.add.at(crossings, rays.owner, 1)
        np.add.at(leaks, rays.owner, contradicts)
        split = _split(tracing, rays, met)
        first = (split.medium_before != split.medium_after) & (rays.depth == 0)
        depth_mm[rays.owner[first]] = rays.travelled_mm[first]

        rays = split.refracted.with_(split.reflected)
        largest = rays.weight.max(axis=1)
        lost = (largest < cutoff) | (rays.depth > maximum_depth) | (rays.straight > MOST_STRAIGHT_CROSSINGS)
        np.add.at(left_out, rays.owner[lost], rays.weight[lost])
        np.add.at(bound, rays.owner[lost], largest[lost] * tracing.brightest)
        rays = rays.take(~lost & (largest > 0.0))
    return Radiance(seen, left_out, bound, depth_mm, crossings, leaks)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...k,...k->...", a, b)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.sqrt(_dot(vectors, vectors))[..., None]
