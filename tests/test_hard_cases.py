"""Rays at the edge of what float64 can tell: both tracers meet every surface where it is, as often as it is there.

Tolerances are backward: a crossing may lie where a line moved by a few units in the last place would meet the
surface. At incidence cos(theta) that is the move over cos(theta) along the line, at most the root of twice the move
times the size, where the line only touches.

Beside these: tests/test_physics.py walks paths backwards and balances energy, tests/test_patches.py holds collapsed
edges, tests/test_native.py threads, builds and bodies that coincide.
"""

from dataclasses import replace

import numpy as np
import pytest
import tracer_scenes
from closed_forms import critical_angle, normal_reflectance, reflectances
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from patch_bodies import ball_patches
from tracer_scenes import CAMERA, SODA_LIME, arc, cubic, cylinder, line, polyline, revolved_ball

from glassworkbench.scene import Body, Ellipsoid, Environment, Medium, Revolved, Scene
from glassworkbench.tracer import native, reference
from glassworkbench.tracer.reference_surfaces import crosser

TRACERS = [
    "reference",
    pytest.param("native", marks=pytest.mark.skipif(not native.available(), reason="the native tracer is not built")),
]
MOVE = 64.0 * np.finfo(float).eps
"""Of the largest coordinate: what a tracer may move a line by."""

SLOPES = np.concatenate([[0.0], *[[-(10.0**k), 10.0**k] for k in range(-16, 0)]])
"""d_z of nearly horizontal lines."""

QUARTER = 4.0 / 3.0 * (np.sqrt(2.0) - 1.0)
"""Handle of a cubic that follows a quarter circle."""

quick = settings(
    max_examples=15,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)


@pytest.fixture(params=TRACERS)
def tracer(request):
    return request.param


def module(tracer):
    return native if tracer == "native" else reference


def idle(surface):
    """A scene in which light passes a body straight on."""
    return Scene((Body("body", surface),), (Medium("body", 1.0),), (Environment(1.0),), CAMERA)


def crossings(tracer, surface, origins, directions):
    """Return line, distance and sense of the crossings ahead of the origins, and their points, in order."""
    if tracer == "reference":
        found = crosser(surface)(origins, directions)
        order = np.lexsort((found.distance_mm, found.line))
        order = order[found.distance_mm[order] > 0.0]
        number, distance, entering = found.line[order], found.distance_mm[order], found.entering[order]
        return number, distance, entering, origins[number] + distance[:, None] * directions[number]
    scene = native.NativeScene(idle(surface))
    paths = [scene.follow(o, d) for o, d in zip(origins, directions, strict=True)]
    number = np.repeat(np.arange(len(paths)), [len(path) for path in paths])
    points = np.array([crossing.point_mm for path in paths for crossing in path]).reshape(-1, 3)
    entering = np.array([crossing.entering for path in paths for crossing in path], dtype=bool)
    return number, dot(points - origins[number], directions[number]), entering, points


def dot(a, b):
    return np.einsum("...k,...k->...", a, b)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def torus_of_cubics(major, minor):
    """Four polynomial cubics that follow a circle beside the axis to 3e-4 of its radius."""
    corners = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]]) * minor
    segments = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        circle = np.array([a, a + QUARTER * b, b + QUARTER * a, b])
        segments.append(cubic(*(circle + np.array([major, 0.0]))))
    return Revolved(np.array(segments))


def domed_cylinder(radius, height):
    """A straight wall between a dome of a polynomial cubic below and a half ball above."""
    handle = QUARTER * radius
    low = cubic((0.0, -0.5 * radius), (handle, -0.5 * radius), (radius, -0.5 * handle), (radius, 0.0))
    return Revolved(np.array([low, line((radius, 0.0), (radius, height)), arc((0.0, height), radius, 0.0, 90.0)]))


TURNED = {
    "ball": revolved_ball(10.0),
    "domed cylinder": domed_cylinder(10.0, 25.0),
    "torus of cubics": torus_of_cubics(30.0, 8.0),
}


def on_meridian(body, u):
    """Return points of all segments at the parameters u and their tangents, (k, 2) each, in extended precision."""
    u = u.astype(np.longdouble)
    basis = np.stack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
    rates = np.stack([-3 * (1 - u) ** 2, 3 * (1 - u) * (1 - 3 * u), 3 * u * (2 - 3 * u), 3 * u**2])
    weighted = body.meridian.astype(np.longdouble)
    weighted[:, :, :2] *= weighted[:, :, 2:]
    value, rate = (np.einsum("skc,ku->suc", weighted, b).reshape(-1, 3) for b in (basis, rates))
    points = value[:, :2] / value[:, 2:]
    return points, (rate[:, :2] - points * rate[:, 2:]) / value[:, 2:]


@pytest.mark.parametrize("away", [1.0, 30.0, 1000.0])
@pytest.mark.parametrize("name", TURNED)
def test_nearly_horizontal_lines_meet_the_points_that_they_were_aimed_at(tracer, name, away):
    body = TURNED[name]
    rng = np.random.default_rng(31)
    u = np.concatenate([[0.0, 1e-9, 1e-5, 0.5, 1.0 - 1e-7], rng.random(7)])
    point, tangent = on_meridian(body, u)
    point, tangent = (np.repeat(a, len(SLOPES), axis=0) for a in (point, tangent))
    slope = np.tile(SLOPES, len(point) // len(SLOPES))
    # From radial to all but tangent, and through the axis.
    azimuth = rng.choice([0.0, 1.0], len(point), p=[0.1, 0.9]) * rng.uniform(-np.pi, np.pi, len(point))
    directions = unit(np.column_stack([np.cos(azimuth), np.sin(azimuth), slope]))
    place = np.column_stack([point[:, 0], 0.0 * point[:, 0], point[:, 1]])
    normal = unit(np.column_stack([tangent[:, 1], 0.0 * point[:, 0], -tangent[:, 0]]))
    origins = (place - away * directions).astype(float)

    number, distance, _, points = crossings(tracer, body, origins, directions)
    size = np.abs(body.meridian[:, :, :2]).max()
    move = MOVE * (np.abs(origins).max() + size)
    reach = move / np.maximum(np.abs(dot(normal, directions)), np.sqrt(move / size))
    truth = dot(place - origins, directions)
    error = np.full(len(origins), np.inf)
    np.minimum.at(error, number, np.abs(distance - truth[number]).astype(float))
    touches = np.abs(dot(normal, directions)) < np.sqrt(move / size)
    assert np.all((error <= reach) | touches)
    off_line = np.cross(points - origins[number], directions[number])
    assert np.linalg.norm(off_line, axis=1).max() < 1e-9 * size


def test_nearly_horizontal_lines_meet_a_ball_at_its_closed_form(tracer):
    # The flat lines' parameter on the meridian settles before the distance does: it once ended 0.1 mm off.
    radius, rng = 10.0, np.random.default_rng(32)
    count = 60 * len(SLOPES)
    directions = np.column_stack([np.ones(count), np.zeros(count), np.tile(SLOPES, 60)])
    # How far the middle of the chord lies from the centre: from the axis up to all but touching.
    closest = radius * rng.choice([0.0, 1e-12, 1e-5, 0.4, 0.99, 1.0 - 1e-6], count)
    turn = rng.choice([0.0, 0.5 * np.pi, 1.0, 0.1, 1e-8], count)
    middle = np.column_stack([0.0 * closest, closest * np.cos(turn), closest * np.sin(turn)])
    directions = unit(directions)
    away = rng.choice([1.1, 2.0, 30.0, 1000.0], count)
    origins = middle - radius * away[:, None] * directions

    o, d = origins.astype(np.longdouble), directions.astype(np.longdouble)
    b, a, c = dot(o, d), dot(d, d), dot(o, o) - np.longdouble(radius) ** 2
    half = np.sqrt(b * b - a * c)
    truth = np.column_stack([(-b - half) / a, (-b + half) / a]).astype(float)
    number, distance, entering, points = crossings(tracer, revolved_ball(radius), origins, directions)
    np.testing.assert_array_equal(number, np.repeat(np.arange(count), 2))
    np.testing.assert_array_equal(entering, np.tile([True, False], count))
    move = MOVE * radius * (1.0 + away)
    assert np.all(np.abs(distance.reshape(-1, 2) - truth).max(axis=1) <= move * radius / half)
    assert np.abs(np.linalg.norm(points, axis=1) - radius).max() < 1e-9 * radius


@pytest.mark.parametrize("away", [1e-9, 1e-3, 1.0, 1e3, 1e6])
def test_a_ball_is_met_from_however_far(tracer, away):
    radius, rng = 10.0, np.random.default_rng(33)
    towards = unit(rng.normal(size=(200, 3)))
    directions = unit(rng.normal(size=(200, 3)))
    directions *= np.where(dot(directions, towards) > 0.0, -1.0, 1.0)[:, None]
    directions = unit(directions - 0.3 * towards)
    origins = radius * towards - away * directions
    number, distance, entering, _ = crossings(tracer, revolved_ball(radius), origins, directions)
    np.testing.assert_array_equal(number, np.repeat(np.arange(200), 2))
    np.testing.assert_array_equal(entering, np.tile([True, False], 200))
    steepness = -dot(towards, directions)
    np.testing.assert_allclose(distance[::2], away, rtol=0.0, atol=MOVE * (away + radius) / steepness.min())
    chord = distance[1::2] - distance[::2]
    assert np.all(np.abs(chord - 2.0 * radius * steepness) <= 2.0 * MOVE * (away + radius) / steepness)


@pytest.mark.parametrize("body", ["revolved", "patches"])
def test_lines_along_and_beside_the_axis_meet_a_ball_at_its_poles(tracer, body):
    # A pole is where the meridian ends on the axis, and where an edge of each patch is collapsed into a point.
    ball = revolved_ball(10.0) if body == "revolved" else ball_patches(10.0, 4)
    beside = np.concatenate([[0.0], 10.0 ** np.arange(-16.0, 0.0), [5.0, 9.9]])
    offset, tilt = (grid.ravel() for grid in np.meshgrid(beside, [0.0, 1e-16, -1e-9, 1e-3]))
    azimuth = np.arange(len(offset)) * 0.25 * np.pi
    aside = np.column_stack([np.cos(azimuth), np.sin(azimuth), 0.0 * azimuth])
    directions = unit(np.array([0.0, 0.0, -1.0]) + tilt[:, None] * np.cross(aside, [0.0, 0.0, 1.0]))
    origins = offset[:, None] * aside - 40.0 * directions
    number, distance, entering, _ = crossings(tracer, ball, origins, directions)
    np.testing.assert_array_equal(number, np.repeat(np.arange(len(offset)), 2))
    np.testing.assert_array_equal(entering, np.tile([True, False], len(offset)))
    half = np.sqrt((10.0 - offset) * (10.0 + offset))
    # A patch's pole is reached to 1e-7 of its size: its parameters have no direction there.
    limit = 1e-11 if body == "revolved" else 1e-6
    np.testing.assert_allclose(distance.reshape(-1, 2), np.column_stack([40.0 - half, 40.0 + half]), atol=limit)


@pytest.mark.parametrize("inside", [False, True])
def test_a_line_that_grazes_the_hole_of_a_torus_crosses_it_or_passes_by(tracer, inside):
    # The inside of the surface is met from its hollow side: the line is in the glass on both sides of the touch.
    torus = Revolved(np.array([arc((30.0, 0.0), 8.0, 90.0 * k, 90.0 * (k + 1)) for k in range(4)]))
    gaps = 10.0 ** np.arange(-15.0, -2.0)
    closest = 22.0 * np.concatenate([1.0 - gaps, 1.0 + gaps])
    reach = 10.0 if inside else 100.0
    origins = np.column_stack([0.0 * closest - reach, closest, 0.0 * closest])
    number, _, entering, points = crossings(tracer, torus, origins, np.tile([1.0, 0.0, 0.0], (len(closest), 1)))
    count, first = np.bincount(number, minlength=len(closest)), 1 if inside else 2
    assert np.all((count == first) | (count == first + 2))
    assert np.all(count[closest < 22.0 * (1.0 - 1e-13)] == first + 2)
    assert np.all(count[closest > 22.0 * (1.0 + 1e-13)] == first)
    balance = np.bincount(number, np.where(entering, 1.0, -1.0), minlength=len(closest))
    np.testing.assert_array_equal(balance, -1.0 if inside else 0.0)
    ring = np.hypot(points[:, 0], points[:, 1])
    off = np.minimum(np.abs(ring - 22.0), np.abs(ring - 38.0))
    assert off.max() < 1e-6


@pytest.mark.parametrize("slope", [0.0, 1e-16, 1e-9, 1e-3, 1.0, 1e9])
def test_a_grazing_line_meets_a_ball_twice_or_not_at_all(tracer, slope):
    gaps = 10.0 ** np.arange(-15.0, -2.0)
    closest = 10.0 * np.concatenate([1.0 - gaps, 1.0 + gaps])
    direction = unit(np.array([1.0, 0.0, slope]))
    for turn in (0.0, 0.5, 0.5 * np.pi):
        aside = np.cos(turn) * np.array([0.0, 1.0, 0.0]) + np.sin(turn) * np.array([-direction[2], 0.0, direction[0]])
        origins = closest[:, None] * aside - 50.0 * direction
        number, distance, _, _ = crossings(tracer, revolved_ball(10.0), origins, np.tile(direction, (len(origins), 1)))
        count = np.bincount(number, minlength=len(origins))
        assert np.all((count == 0) | (count == 2))
        assert np.all(count[closest < 10.0 * (1.0 - 1e-13)] == 2)
        assert np.all(count[closest > 10.0 * (1.0 + 1e-13)] == 0)
        half = np.sqrt(np.maximum((10.0 - closest) * (10.0 + closest), 0.0))[number]
        off = np.abs(np.abs(distance - 50.0) - half)
        assert np.all(off <= MOVE * 600.0 / np.maximum(half, np.sqrt(MOVE * 600.0)))


DEGENERATE = {
    "segments without length": polyline((0, 0), (0, 0), (10, 0), (10, 0), (10, 8), (0, 8), (0, 8)),
    "repeated control points": np.array(
        [
            cubic((0, 0), (0, 0), (10, 0), (10, 0)),
            cubic((10, 0), (10, 0), (10, 0), (6, 8)),
            cubic((6, 8), (0, 8), (0, 8), (0, 8)),
        ]
    ),
    "a cusp": np.array([line((0, 0), (4, 0)), cubic((4, 0), (14, 9), (14, 1), (4, 8)), line((4, 8), (0, 8))]),
    "an apex on the axis": polyline((0, 0), (9, 4), (0, 12)),
    "a segment along the axis": polyline((0, 0), (8, 0), (8, 6), (0, 9), (0, 4), (0, 0)),
    "flat rings": polyline((0, 0), (9, 0), (9, 3), (5, 3), (5, 6), (8, 6), (8, 9), (0, 9)),
    "a needle": polyline((0, 0), (1e-3, 4), (0, 8)),
    "tangent joints": np.array(
        [line((0, 0), (6, 0)), arc((6, 4), 4.0, -90.0, 0.0), arc((6, 4), 4.0, 0.0, 90.0), line((6, 8), (0, 8))]
    ),
}


@pytest.mark.skipif(not native.available(), reason="the native tracer is not built")
@pytest.mark.parametrize("name", DEGENERATE)
def test_no_light_is_lost_in_a_degenerate_meridian(name):
    scene = furnace((Body("body", Revolved(DEGENERATE[name])),), (Medium("body", SODA_LIME),))
    seen = native.radiance(scene, *tracer_scenes.rays_through(scene, 3000, seed=36))
    assert seen.leaks.sum() == 0
    np.testing.assert_allclose(1.0 - seen.radiance, np.repeat(seen.bound[:, None], 3, axis=1), atol=1e-11)


@pytest.mark.parametrize("name", DEGENERATE)
def test_lines_through_joints_leave_a_degenerate_meridian_as_often_as_they_enter(tracer, name):
    body = Revolved(DEGENERATE[name])
    ends = body.meridian[:, [0, 3], :2].reshape(-1, 2)
    heights = np.unique(np.concatenate([ends[:, 1], np.nextafter(ends[:, 1], 1e3), 0.5 * (ends[:-1, 1] + ends[1:, 1])]))
    radii = np.unique(np.concatenate([[0.0, 1e-12], ends[:, 0], np.nextafter(ends[:, 0], 0.0), [3.3]]))
    middle = np.stack(np.meshgrid(radii, heights), axis=-1).reshape(-1, 2)
    middle = np.column_stack([middle[:, 0], 0.0 * middle[:, 0], middle[:, 1]])
    azimuths = np.array([0.0, 0.5 * np.pi, 1.0])
    flat = np.column_stack([np.cos(azimuths), np.sin(azimuths), np.zeros(3)])
    aims = [*flat, *(flat[1] + [0, 0, s] for s in SLOPES[::4]), *(flat[0] + [0, 0, s] for s in SLOPES[1::4])]
    # Straight along and nearly along the axis, and along walls.
    aims += [
        [0, 0, 1],
        [0, 0, -1],
        [1e-12, 0, 1],
        [0, 1e-6, -1],
        *(np.insert(e, 1, 0.0) for e in np.diff(ends[1::2], axis=0)),
    ]
    aims = np.array([aim for aim in aims if np.any(aim)])
    directions = unit(np.tile(aims, (len(middle), 1)))
    origins = np.repeat(middle, len(aims), axis=0) - 40.0 * directions
    number, _, entering, points = crossings(tracer, body, origins, directions)
    assert np.all(np.isfinite(points))
    balance = np.bincount(number, np.where(entering, 1.0, -1.0), minlength=len(origins))
    np.testing.assert_array_equal(balance, 0.0)
    assert np.linalg.norm(np.cross(points - origins[number], directions[number]), axis=1).max() < 1e-7


@pytest.mark.parametrize("wall", [0.02, 0.05, 1.0, 10.0])
@pytest.mark.parametrize("slope", [0.0, 1e-14, 1e-3, 1.0, 1e12])
def test_a_wall_is_crossed_face_by_face_and_as_thick_as_it_is(tracer, wall, slope):
    bodies = (Body("outer", revolved_ball(37.5)), Body("cavity", revolved_ball(37.5 - wall)))
    scene = Scene(bodies, (Medium("outer and not cavity", SODA_LIME),), (Environment(1.0),), CAMERA)
    direction = unit(np.array([0.6, 0.8, slope]))
    path = module(tracer).follow(scene, -100.0 * direction, direction)
    assert [(c.body, c.entering) for c in path] == [
        ("outer", True),
        ("cavity", True),
        ("cavity", False),
        ("outer", False),
    ]
    along = [c.point_mm @ direction for c in path]
    np.testing.assert_allclose(along, [-37.5, wall - 37.5, 37.5 - wall, 37.5], atol=1e-12)
    # Normal incidence.
    np.testing.assert_allclose([c.reflectance for c in path], normal_reflectance(SODA_LIME), rtol=1e-12)


@pytest.mark.parametrize("beyond", [-1e-6, -1e-9, -1e-12, 1e-12, 1e-9])
def test_reflection_near_the_critical_angle_is_what_fresnel_says(tracer, beyond):
    slab = Scene((Body("slab", cylinder(1e3, -1.0, 1.0)),), (Medium("slab", SODA_LIME),), (Environment(1.0),), CAMERA)
    incidence = critical_angle(SODA_LIME, 1.0) + beyond
    direction = np.array([np.sin(incidence), 0.0, np.cos(incidence)])
    reflectance = module(tracer).follow(slab, np.zeros(3), direction, room=1)[0].reflectance
    if beyond > 0.0:
        assert reflectance == 1.0
        return
    expected = np.mean(reflectances(np.longdouble(SODA_LIME), 1.0, np.longdouble(incidence)))
    # The sine of an angle a rounding error off moves what passes by that error over the distance to the angle.
    assert 1.0 - reflectance == pytest.approx(float(1.0 - expected), rel=1e-8 + 2e-16 / abs(beyond))


def furnace(bodies, media):
    return Scene(bodies, media, (Environment(1.0),), CAMERA)


BALL = revolved_ball(10.0)
TOUCHING = {
    "a bubble that touches the wall from inside": furnace(
        (Body("ball", BALL), Body("bubble", Ellipsoid((9.0, 0.0, 0.0), (1.0, 1.0, 1.0)))),
        (Medium("ball and not bubble", SODA_LIME),),
    ),
    "a bubble of 0.02 mm that touches a pole": furnace(
        (Body("ball", BALL), Body("bubble", revolved_ball(0.02, 9.98))), (Medium("ball and not bubble", SODA_LIME),)
    ),
    "a fill whose level is a joint of the cavity": furnace(
        (
            Body("outer", cylinder(12.0, -12.0, 30.0)),
            Body("cavity", domed_cylinder(10.0, 15.0)),
            Body("fill", cylinder(12.0, -9.0, 15.0)),
        ),
        (Medium("outer and not cavity", SODA_LIME), Medium("cavity and fill", 1.3334)),
    ),
    "a fill as wide as the cavity": furnace(
        (
            Body("outer", cylinder(12.0, -12.0, 30.0)),
            Body("cavity", cylinder(10.0, -10.0, 28.0)),
            Body("fill", cylinder(10.0, -10.0, 15.0)),
        ),
        (Medium("outer and not cavity", SODA_LIME), Medium("cavity and fill", 1.3334)),
    ),
}


@pytest.mark.parametrize("name", TOUCHING)
def test_bodies_that_touch_lose_no_light(tracer, name):
    scene = TOUCHING[name]
    origins, directions = tracer_scenes.rays_through(scene, 3000 if tracer == "native" else 20, seed=34)
    seen = module(tracer).radiance(scene, origins, directions)
    assert seen.leaks.sum() == 0
    np.testing.assert_allclose(1.0 - seen.radiance, np.repeat(seen.bound[:, None], 3, axis=1), atol=1e-11)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_a_scaled_scene_looks_the_same(tracer, scale):
    scene, grown = (lit(tracer_scenes.bottle_meridian, factor) for factor in (1.0, scale))
    assert_same_view(tracer, scene, grown, lambda points, directions: (scale * points, directions))


def test_a_moved_scene_looks_the_same(tracer):
    axis, base = unit(np.array([0.3, -0.5, 0.8])), np.array([120.0, -40.0, 900.0])
    side = unit(np.cross([0.0, 1.0, 0.0], axis))
    frame = np.stack([side, np.cross(axis, side), axis])
    scene = lit(tracer_scenes.bottle_meridian, 1.0)
    moved = lit(tracer_scenes.bottle_meridian, 1.0, axis=axis, base_mm=base)
    assert_same_view(tracer, scene, moved, lambda points, directions: (points @ frame + base, directions @ frame))


def lit(meridian, scale, **pose):
    """A bottle in uniform light, where all that a ray sees is how long it was in the glass."""
    outlines = [meridian(), meridian(inset=3.0, finish_z=320.0)]
    for outline in outlines:
        outline[:, :, :2] *= scale
    bodies = tuple(Body(n, Revolved(o, **pose)) for n, o in zip(("outer", "cavity"), outlines, strict=True))
    return furnace(bodies, (Medium("outer and not cavity", SODA_LIME, np.array([0.02, 0.004, 0.015]) / scale),))


def assert_same_view(tracer, scene, other, move):
    origins, directions = tracer_scenes.rays_through(scene, 2000 if tracer == "native" else 40, seed=35)
    here = module(tracer).radiance(scene, origins, directions)
    there = module(tracer).radiance(other, *move(origins, directions))
    assert here.leaks.sum() == there.leaks.sum() == 0
    difference = np.abs(here.radiance - there.radiance).max(axis=1)
    # Rays of many bounces carry rounding errors to where one branch more or less is followed: within the bound.
    assert np.mean(difference < 1e-9) > 0.95
    assert np.all(difference <= here.bound + there.bound + 1e-9)


@quick
@given(seed=st.integers(0, 2**32 - 1), name=st.sampled_from(sorted(TURNED)))
def test_crossings_come_in_pairs(tracer, seed, name):
    origins, directions = tracer_scenes.rays_at((-40.0,) * 3, (40.0,) * 3, 200, seed)
    directions = unit(directions)
    origins = origins - 500.0 * directions
    number, _, entering, _ = crossings(tracer, TURNED[name], origins, directions)
    count = np.bincount(number, minlength=len(origins))
    assert np.all(count % 2 == 0)
    place = np.arange(len(number)) - np.repeat(np.cumsum(count) - count, count)
    np.testing.assert_array_equal(entering, place % 2 == 0)


@quick
@given(seed=st.integers(0, 2**32 - 1), coarse=st.floats(1e-3, 0.5), share=st.floats(0.05, 1.0))
def test_bounds_shrink_with_the_cut_off_and_hold(tracer, seed, coarse, share):
    scene = replace(tracer_scenes.goblet(), lights=(tracer_scenes.sky(),))
    rays = tracer_scenes.rays_through(scene, 8, seed)
    less, more = (module(tracer).radiance(scene, *rays, cutoff=cutoff) for cutoff in (coarse, share * coarse))
    gain = more.radiance - less.radiance
    assert np.all(gain >= -1e-12)
    assert np.all(gain + more.bound[:, None] <= less.bound[:, None] + 1e-12)
