"""Rays at the edge of what float64 can tell: both tracers meet every surface where it is, as often as it is there.

Tolerances are backward: a crossing may lie where a line moved by a few units in the last place would meet the
surface. At incidence cos(theta) that is the move over cos(theta) along the line, at most the root of twice the move
times the size, where the line only touches.
"""

import numpy as np
import pytest
from tracer_scenes import CAMERA, arc, cubic, line, revolved_ball

from glassworkbench.scene import Body, Environment, Medium, Revolved, Scene
from glassworkbench.tracer import native
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


@pytest.fixture(params=TRACERS)
def tracer(request):
    return request.param


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
