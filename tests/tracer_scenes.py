"""Scenes for the tracer's tests, made from numbers alone, and rays to try them with."""

from itertools import pairwise

import numpy as np
from patch_bodies import ball_patches, pebble_patches, quarter_arc, turned_patches

from glassworkbench.scene import (
    Body,
    Ellipsoid,
    Ellipsoids,
    Environment,
    Medium,
    Mesh,
    Panel,
    Patches,
    Pinhole,
    Revolved,
    Scene,
)

SODA_LIME = 1.52338
WATER = 1.3334
CAMERA = Pinhole((0.0, -1000.0, 0.0), (0.0, 0.0, 0.0), 0.3)


def line(start, end):
    """A straight meridian segment from (r, z) to (r, z), degree-elevated."""
    points = np.linspace(start, end, 4)
    return np.column_stack([points, np.ones(4)])


def cubic(*points):
    """A polynomial cubic segment from four control points (r, z)."""
    return np.column_stack([points, np.ones(4)])


def arc(centre, radius, start_deg, end_deg):
    """A circular segment of less than a half turn: a rational quadratic, degree-elevated."""
    start, end = np.radians([start_deg, end_deg])
    weight = np.cos(0.5 * (end - start))
    angles = np.array([start, 0.5 * (start + end), end])
    points = np.column_stack([np.cos(angles), np.sin(angles)]) * np.array([1.0, 1.0 / weight, 1.0])[:, None]
    quadratic = np.column_stack([radius * points + centre, np.ones(3)]) * np.array([1.0, weight, 1.0])[:, None]
    a, b, c = quadratic
    elevated = np.array([a, (a + 2.0 * b) / 3.0, (2.0 * b + c) / 3.0, c])
    elevated[:, :2] /= elevated[:, 2:]
    return elevated


def polyline(*points):
    """A chain of straight segments."""
    return np.array([line(p, q) for p, q in pairwise(points)])


def revolved_ball(radius, centre_z=0.0, **pose):
    """A sphere as two quarter arcs turned about the axis."""
    centre = (0.0, centre_z)
    return Revolved(np.array([arc(centre, radius, -90.0, 0.0), arc(centre, radius, 0.0, 90.0)]), **pose)


def cylinder(radius, low_z, high_z, **pose):
    """A solid cylinder."""
    return Revolved(polyline((0.0, low_z), (radius, low_z), (radius, high_z), (0.0, high_z)), **pose)


def bottle_meridian(inset=0.0, finish_z=300.0):
    """A wine bottle with push-up, heel, straight body, curved shoulder, tapered neck and a bead at the finish.

    `inset` makes the cavity's: smaller radii, a higher floor, no bead.
    """
    r, floor = 38.0 - inset, inset
    neck, mouth = 15.0 - inset, 13.5 - inset
    segments = [
        cubic((0.0, 22.0 + floor), (12.0, 22.0 + floor), (20.0 - 0.5 * inset, 2.0 + floor), (26.0, floor)),
        line((26.0, floor), (28.0, floor)),
        arc((28.0, r - 28.0 + floor), r - 28.0, -90.0, 0.0),
        line((r, r - 28.0 + floor), (r, 180.0)),
        cubic((r, 180.0), (r, 215.0), (neck + 2.0, 212.0), (neck, 238.0)),
    ]
    if inset:
        segments += [line((neck, 238.0), (mouth, finish_z)), line((mouth, finish_z), (0.0, finish_z))]
    else:
        segments += [
            line((neck, 238.0), (mouth, 284.0)),
            arc((mouth, 290.0), 6.0, -90.0, 0.0),
            line((mouth + 6.0, 290.0), (mouth + 6.0, 298.0)),
            arc((mouth + 4.0, 298.0), 2.0, 0.0, 90.0),
            line((mouth + 4.0, finish_z), (0.0, finish_z)),
        ]
    return np.array(segments)


def sky(height=8, width=16, seed=5):
    """An environment of random colours."""
    return Environment(np.random.default_rng(seed).uniform(0.1, 2.0, (height, width, 3)))


def box_mesh(low, high):
    """A box whose faces have vertices and normals of their own."""
    faces = [(axis, side) for axis in range(3) for side in (0, 1)]
    vertices, triangles, normals = [], [], []
    for axis, side in faces:
        u, v = (axis + 1) % 3, (axis + 2) % 3
        corners = np.zeros((4, 3))
        corners[:, axis] = (low, high)[side][axis]
        corners[:, u] = np.array([low[u], high[u], high[u], low[u]])
        corners[:, v] = np.array([low[v], low[v], high[v], high[v]])
        first = len(vertices)
        vertices += list(corners)
        order = [(0, 1, 2), (0, 2, 3)] if side else [(0, 2, 1), (0, 3, 2)]
        triangles += [tuple(first + k for k in triangle) for triangle in order]
        normals += [(2 * side - 1) * np.eye(3)[axis]] * 4
    return Mesh(np.array(vertices), np.array(triangles), np.array(normals))


def prism_mesh(profile, length):
    """A convex polygon (x, y), counter-clockwise, drawn out along z from -length/2 to length/2, with flat faces."""
    profile = np.asarray(profile, dtype=float)
    count = len(profile)
    vertices, triangles, normals = [], [], []
    for side in (-1.0, 1.0):
        first = len(vertices)
        vertices += [(x, y, 0.5 * side * length) for x, y in profile]
        normals += [(0.0, 0.0, side)] * count
        for k in range(1, count - 1):
            fan = (first, first + k, first + k + 1)
            triangles.append(fan if side > 0.0 else fan[::-1])
    for k in range(count):
        a, b = profile[k], profile[(k + 1) % count]
        normal = np.array([b[1] - a[1], a[0] - b[0], 0.0]) / np.hypot(*(b - a))
        first = len(vertices)
        vertices += [(*a, -0.5 * length), (*b, -0.5 * length), (*b, 0.5 * length), (*a, 0.5 * length)]
        normals += [normal] * 4
        triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    return Mesh(np.array(vertices), np.array(triangles), np.array(normals))


def ball_mesh(radius, rings=12, sectors=20, centre=(0.0, 0.0, 0.0)):
    """A sphere of triangles with the sphere's own normals at the vertices."""
    polar = np.linspace(0.0, np.pi, rings + 1)[1:-1]
    azimuth = np.linspace(0.0, 2.0 * np.pi, sectors, endpoint=False)
    around = [(np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)) for p in polar for a in azimuth]
    directions = np.array([(0.0, 0.0, 1.0), *around, (0.0, 0.0, -1.0)])
    last = len(directions) - 1
    triangles = []
    for j in range(sectors):
        following = (j + 1) % sectors
        triangles.append((0, 1 + j, 1 + following))
        for i in range(rings - 2):
            a, b = 1 + i * sectors + j, 1 + i * sectors + following
            triangles += [(a, a + sectors, b), (b, a + sectors, b + sectors)]
        bottom = 1 + (rings - 2) * sectors
        triangles.append((bottom + j, last, bottom + following))
    return Mesh(radius * directions + np.array(centre), np.array(triangles), directions)


def bottle(fill=False, absorption=(0.02, 0.004, 0.015), lights=None, **pose):
    """A bottle of glass, empty or filled; the cavity reaches past the mouth and the filling into the wall."""
    bodies = [
        Body("outer", Revolved(bottle_meridian(), **pose)),
        Body("cavity", Revolved(bottle_meridian(inset=3.0, finish_z=320.0), **pose)),
    ]
    media = [Medium("outer and not cavity", SODA_LIME, absorption)]
    if fill:
        bodies.append(Body("fill", Revolved(polyline((0, 1), (36.5, 1), (36.5, 190), (0, 190)), **pose)))
        media.append(Medium("cavity and fill", WATER, np.array(absorption) * 0.1))
    return Scene(bodies, media, lights or (sky(), _panel()), CAMERA)


def _panel():
    return Panel((-100.0, 120.0, -20.0), (200.0, 0.0, 0.0), (0.0, 0.0, 360.0), (1.0, 0.9, 0.8))


def goblet():
    """A cut-glass gem of cones and discs with a spherical bubble and a water-filled conical hole, askew."""
    pose = {"base_mm": (3.0, -4.0, 12.0), "axis": (0.3, -0.5, 0.8)}
    gem = polyline((0, 0), (18, 0), (30, 14), (30, 20), (20, 34), (0, 34))
    hole = polyline((0, 12), (14, 40), (0, 40))
    bubble = revolved_ball(2.0, 7.0, base_mm=(5.0, -6.0, 16.0), axis=(0.0, 1.0, 1.0))
    bodies = (Body("gem", Revolved(gem, **pose)), Body("hole", Revolved(hole, **pose)), Body("bubble", bubble))
    media = (Medium("gem and not hole and not bubble", 1.6, (0.01, 0.0, 0.02)), Medium("hole and gem", WATER))
    return Scene(bodies, media, (sky(seed=6), _panel()), CAMERA)


def ring():
    """A torus: a meridian that closes on itself off the axis, with an ellipsoidal stone in it."""
    torus = Revolved(np.array([arc((30.0, 0.0), 10.0, 90.0 * k, 90.0 * (k + 1)) for k in range(4)]), axis=(0, 1, 0))
    stone = Ellipsoid((30.0, 0.5, 1.0), (5.0, 3.0, 1.0), _rotation(0.4, 0.7))
    media = (Medium("stone", 1.9, (0.3, 0.1, 0.2)), Medium("torus", SODA_LIME, (0.0, 0.01, 0.0)))
    return Scene((Body("torus", torus), Body("stone", stone)), media, (sky(seed=7),), CAMERA)


def seeds():
    """Bubbles down to 0.02 mm in an ellipsoid, a body of the same index that only colours, and an idle body."""
    rotation = _rotation(0.3, 1.1)
    bodies = (
        Body("drop", Ellipsoid((1.0, 2.0, 3.0), (30.0, 20.0, 25.0), rotation)),
        Body("seed", Ellipsoid((6.0, 2.0, 4.0), (0.02, 0.02, 0.02))),
        Body("blister", Ellipsoid((-4.0, 1.0, 0.0), (6.0, 3.0, 0.5), rotation.T)),
        Body("tint", Ellipsoid((0.0, 0.0, -5.0), (9.0, 9.0, 9.0))),
        Body("idle", Ellipsoid((0.0, 0.0, 0.0), (50.0, 50.0, 50.0))),
    )
    media = (
        Medium("tint and drop and not blister", 1.5, (0.2, 0.01, 0.05)),
        Medium("drop and not seed and not blister", 1.5, (0.001, 0.0, 0.0)),
    )
    return Scene(bodies, media, (sky(seed=8), _panel()), CAMERA)


def bubbles():
    """A drop of glass with bubbles and flat films askew, one body of them, and grains that absorb."""
    rng = np.random.default_rng(12)
    places = np.stack(np.meshgrid(*[np.arange(-2.0, 3.0)] * 3), axis=-1).reshape(-1, 3) * 5.0
    turned = np.linalg.qr(rng.normal(size=(125, 3, 3)))[0]
    semi_axes = 2.2 * 10.0 ** rng.uniform(-2.0, 0.0, (125, 3))
    bodies = (
        Body("drop", Ellipsoid((1.0, 2.0, 3.0), (26.0, 21.0, 25.0))),
        Body("bubbles", Ellipsoids(places[::2], semi_axes[::2], turned[::2])),
        Body("grains", Ellipsoids(places[1::2], semi_axes[1::2], turned[1::2])),
    )
    media = (Medium("grains", 1.7, (3.0, 2.0, 1.0)), Medium("drop and not bubbles", SODA_LIME, (0.01, 0.0, 0.01)))
    return Scene(bodies, media, (sky(seed=11), _panel()), CAMERA)


def meshes():
    """A box of glass with a smooth-shaded ball of air in it, and a revolved core of water in the ball."""
    bodies = (
        Body("box", box_mesh((-40.0, -30.0, -25.0), (40.0, 30.0, 25.0))),
        Body("ball", ball_mesh(20.0)),
        Body("core", revolved_ball(12.0, axis=(0.6, 0.0, 0.8))),
    )
    media = (Medium("core", WATER, (0.01, 0.02, 0.03)), Medium("box and not ball", SODA_LIME, (0.0, 0.005, 0.01)))
    return Scene(bodies, media, (sky(seed=9), _panel()), CAMERA)


def patches():
    """A free-form pebble of glass with a torus of water in it, and half a lens of rational octants: all of patches."""
    pebble = pebble_patches()
    torus = turned_patches([quarter_arc((9.0, 0.0), 4.0, 90.0 * k) for k in range(4)], 6, 4)
    lens = ball_patches(9.0, 6).placed(_rotation(0.5, 0.3), np.array([24.0, 3.0, 1.0]))
    bodies = (
        Body("pebble", pebble),
        Body("torus", torus.placed(_rotation(1.2, -0.4), np.array([-2.0, 1.0, 0.5]))),
        Body("lens", lens),
        Body("half", box_mesh((0.0, -20.0, -30.0), (24.0, 20.0, 30.0))),
    )
    media = (
        Medium("torus", WATER, (0.01, 0.02, 0.03)),
        Medium("pebble or lens and half", SODA_LIME, (0.0, 0.01, 0.02)),
    )
    return Scene(bodies, media, (sky(seed=10), _panel()), CAMERA)


def _rotation(tilt, turn):
    about_x = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    about_z = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    return about_z @ about_x


SCENES = {
    "bottle": bottle,
    "filled_bottle": lambda: bottle(fill=True),
    "leaning_bottle": lambda: bottle(fill=True, base_mm=(10.0, -20.0, 5.0), axis=(0.2, 0.1, 0.9)),
    "goblet": goblet,
    "ring": ring,
    "seeds": seeds,
    "bubbles": bubbles,
    "meshes": meshes,
    "patches": patches,
}


def rays_at(low, high, count, seed):
    """Rays from around and within a box at points in it; one in eight each nearly horizontal and nearly vertical."""
    rng = np.random.default_rng(seed)
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    middle, size = 0.5 * (low + high), np.linalg.norm(high - low)
    distance = rng.choice([0.3, 1.0, 5.0], (count, 1)) * size
    towards = rng.normal(size=(count, 3))
    origins = middle + distance * towards / np.linalg.norm(towards, axis=1, keepdims=True)
    directions = rng.uniform(low, high, (count, 3)) - origins
    eighth = count // 8
    small = 10.0 ** rng.uniform(-14.0, -1.0, (2 * eighth, 1))
    directions[:eighth, 2:] = small[:eighth] * size
    directions[eighth : 2 * eighth, :2] *= small[eighth:]
    origins[: 2 * eighth] = rng.uniform(low, high, (2 * eighth, 3)) - 2.0 * directions[: 2 * eighth]
    return origins, directions


def bounds(scene):
    """Corners of a box around the scene's bodies, but for balls 50 mm large or more, which only surround."""
    corners = []
    for body in scene.bodies:
        surface = body.surface
        if isinstance(surface, Mesh):
            corners += list(surface.vertices_mm)
        elif isinstance(surface, Patches):
            corners += list(surface.mesh.vertices_mm)
        elif isinstance(surface, Revolved):
            radius = surface.meridian[:, :, 0].max()
            for z in (surface.meridian[:, :, 1].min(), surface.meridian[:, :, 1].max()):
                end = surface.base_mm + z * surface.axis
                corners += [end - radius, end + radius]
        elif isinstance(surface, Ellipsoids):
            corners += [surface.centres_mm.min(axis=0), surface.centres_mm.max(axis=0)]
        elif surface.semi_axes_mm.max() < 50.0:
            reach = surface.semi_axes_mm.max()
            corners += [surface.centre_mm - reach, surface.centre_mm + reach]
    return np.min(corners, axis=0), np.max(corners, axis=0)


def rays_through(scene, count, seed):
    """Rays at the scene's bodies from all sides, inside included."""
    return rays_at(*bounds(scene), count, seed)
