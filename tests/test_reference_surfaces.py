"""Crossings of lines with surfaces, against closed forms and brute force."""

import numpy as np
import pytest
import tracer_scenes
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tracer_scenes import arc, ball_mesh, box_mesh, cubic, cylinder, line, polyline, revolved_ball

from glassworkbench.scene import Ellipsoid, Revolved
from glassworkbench.tracer.reference_surfaces import crosser

quick = settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])


def torus_meridian(major, minor):
    return np.array([arc((major, 0.0), minor, 90.0 * k, 90.0 * (k + 1)) for k in range(4)])


def rays(seed, count, size):
    """Lines past the origin at any inclination, nearly horizontal and nearly vertical ones among them."""
    rng = np.random.default_rng(seed)
    inclination = np.where(
        rng.random(count) < 0.5,
        np.pi / 2.0 - 10.0 ** rng.uniform(-16.0, 0.0, count),
        10.0 ** rng.uniform(-16.0, 0.2, count),
    )
    azimuth = rng.uniform(-np.pi, np.pi, count)
    directions = np.column_stack(
        [np.sin(inclination) * np.cos(azimuth), np.sin(inclination) * np.sin(azimuth), np.cos(inclination)]
    )
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points = rng.uniform(-size, size, (count, 3))
    return points - rng.uniform(0.0, 20.0, (count, 1)) * size * directions, directions


def crossings(surface, origins, directions):
    """Return crossings sorted by line and distance."""
    found = crosser(surface)(np.asarray(origins, float), np.asarray(directions, float))
    order = np.lexsort((found.distance_mm, found.line))
    return found.line[order], found.distance_mm[order], found.entering[order], found.normal[order]


def assert_in_and_out_in_turn(surface, origins, directions):
    number, distance, entering, normal = crossings(surface, origins, directions)
    counts = np.bincount(number, minlength=len(origins))
    assert np.all(counts % 2 == 0)
    # Two crossings at one place (a corner, a tangent) may sort either way.
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    should_enter = (np.arange(len(number)) - np.repeat(starts, counts)) % 2 == 0
    apart = np.abs(np.diff(distance, append=np.inf)) > 1e-9
    apart &= np.abs(np.diff(distance, prepend=-np.inf)) > 1e-9
    assert np.all((entering == should_enter)[apart])
    into = np.einsum("ij,ij->i", normal, directions[number])
    assert np.all((into[entering] < 1e-6) & np.isfinite(into[entering]))
    assert np.all((into[~entering] > -1e-6) & np.isfinite(into[~entering]))
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, rtol=1e-14)
    return origins[number] + distance[:, None] * directions[number]


@st.composite
def poses(draw):
    numbers = st.floats(-1.0, 1.0)
    axis = np.array([draw(numbers), draw(numbers), draw(numbers)])
    if np.linalg.norm(axis) < 1e-3:
        axis = np.array([0.0, 0.0, 1.0])
    return {"axis": axis, "base_mm": 20.0 * np.array([draw(numbers), draw(numbers), draw(numbers)])}


def in_own_frame(surface, points):
    """Return r and z of points about the axis of a revolved surface."""
    relative = points - surface.base_mm
    z = relative @ surface.axis
    return np.linalg.norm(relative - z[:, None] * surface.axis, axis=1), z


@quick
@given(seed=st.integers(0, 2**32 - 1), radius=st.floats(0.01, 500.0), pose=poses())
def test_revolved_ball_is_met_where_the_ellipsoid_is(seed, radius, pose):
    ball = revolved_ball(radius, **pose)
    origins, directions = rays(seed, 200, radius)
    origins = origins + ball.base_mm
    points = assert_in_and_out_in_turn(ball, origins, directions)
    far = np.abs(origins).max()
    assert np.all(np.abs(np.linalg.norm(points - ball.base_mm, axis=1) - radius) < 1e-12 * far)

    # Lines that all but touch may be told apart either way.
    closest = np.linalg.norm(np.cross(origins - ball.base_mm, directions), axis=1)
    clear = np.abs(closest / radius - 1.0) > 1e-6
    ours = crossings(ball, origins[clear], directions[clear])
    theirs = crossings(Ellipsoid(ball.base_mm, (radius,) * 3), origins[clear], directions[clear])
    np.testing.assert_array_equal(ours[0], theirs[0])
    np.testing.assert_array_equal(ours[2], theirs[2])
    np.testing.assert_allclose(ours[1], theirs[1], atol=1e-9 * far)


@quick
@given(seed=st.integers(0, 2**32 - 1), pose=poses())
def test_crossings_of_a_torus_lie_on_it(seed, pose):
    torus = Revolved(torus_meridian(30.0, 8.0), **pose)
    origins, directions = rays(seed, 200, 40.0)
    origins = origins + torus.base_mm
    r, z = in_own_frame(torus, assert_in_and_out_in_turn(torus, origins, directions))
    assert np.all(np.abs(np.hypot(r - 30.0, z) - 8.0) < 1e-12 * np.abs(origins).max())


@quick
@given(seed=st.integers(0, 2**32 - 1), pose=poses())
def test_crossings_of_cones_and_discs_lie_on_them(seed, pose):
    gem = Revolved(polyline((0.0, -20.0), (10.0, -20.0), (30.0, 0.0), (0.0, 15.0)), **pose)
    origins, directions = rays(seed, 200, 30.0)
    origins = origins + gem.base_mm
    r, z = in_own_frame(gem, assert_in_and_out_in_turn(gem, origins, directions))
    off_disc, off_lower, off_upper = np.abs(z + 20.0), np.abs(z - r + 30.0), np.abs(z + 0.5 * r - 15.0)
    assert np.all(np.minimum(np.minimum(off_disc, off_lower), off_upper) < 2e-12 * np.abs(origins).max())


@quick
@given(seed=st.integers(0, 2**32 - 1))
def test_crossings_of_an_ellipsoid_lie_on_it(seed):
    rng = np.random.default_rng(seed)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    axes = 10.0 ** rng.uniform(-1.0, 1.5, 3)
    ellipsoid = Ellipsoid(rng.uniform(-50.0, 50.0, 3), axes, rotation)
    origins, directions = rays(seed, 200, axes.max())
    origins = origins + ellipsoid.centre_mm
    points = assert_in_and_out_in_turn(ellipsoid, origins, directions)
    unit = (points - ellipsoid.centre_mm) @ rotation / axes
    assert np.all(np.abs(np.linalg.norm(unit, axis=1) - 1.0) < 1e-12 * np.abs(origins).max() / axes.min())


@quick
@given(seed=st.integers(0, 2**32 - 1))
def test_lines_leave_a_mesh_as_often_as_they_enter(seed):
    origins, directions = rays(seed, 300, 15.0)
    points = assert_in_and_out_in_turn(ball_mesh(10.0), origins, directions)
    # Facets of 12 by 20 lie at least cos(pi/20) * cos(pi/12) of the radius from the centre.
    distance = np.linalg.norm(points, axis=1)
    assert np.all((distance < 10.0 + 1e-11) & (distance > 9.4))


def test_lines_through_vertices_and_along_edges_of_a_mesh_are_counted_once():
    box = box_mesh((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    grid = np.array(np.meshgrid(*[[-2.0, -1.0, 0.0, 1.0, 2.0]] * 3)).reshape(3, -1).T
    starts, ends = (np.repeat(grid, len(grid), axis=0), np.tile(grid, (len(grid), 1)))
    lengths = np.linalg.norm(ends - starts, axis=1)
    starts, ends, lengths = starts[lengths > 0.0], ends[lengths > 0.0], lengths[lengths > 0.0]
    number, _, entering, _ = crossings(box, starts, (ends - starts) / lengths[:, None])
    balance = np.bincount(number, np.where(entering, 1.0, -1.0), minlength=len(starts))
    assert np.all(balance == 0.0)


def test_lines_at_the_joints_of_a_meridian_are_counted_once():
    # Horizontal lines exactly at joints and at flat faces, lines along the axis, and lines through sharp edges.
    body = Revolved(polyline((0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (20.0, 5.0), (20.0, 10.0), (5.0, 20.0), (0.0, 20.0)))
    origins, directions = [], []
    for x in (0.0, 1.0, 5.0, 10.0, 15.0, 20.0):
        for z in (0.0, 2.0, 5.0, 10.0, 15.0, 20.0):
            for direction in (
                (1, 0, 0),
                (0, 1, 0),
                (0, 0, 1),
                (0, 0, -1),
                (1, 0, 1),
                (-1, 0, -2),
                (3, 4, 0),
                (0, 1, 1e-17),
            ):
                origins.append((x, 0.0, z))
                directions.append(direction)
    directions = np.array(directions, float)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    number, _, entering, normal = crossings(body, np.array(origins), directions)
    assert np.all(np.isfinite(normal))
    assert np.all(np.bincount(number, np.where(entering, 1.0, -1.0), minlength=len(origins)) == 0.0)


def test_nearly_horizontal_lines_keep_their_digits():
    # Where the polynomial of degree 6 has a double root; half the digits would be lost.
    torus = Revolved(torus_meridian(30.0, 8.0))
    slopes = np.concatenate([[0.0], 10.0 ** np.arange(-17.0, -1.0)])
    directions = np.column_stack([np.sqrt(1.0 - slopes**2), np.zeros_like(slopes), slopes])
    number, distance, _, _ = crossings(torus, np.tile([-100.0, 7.0, 3.0], (len(slopes), 1)), directions)
    np.testing.assert_array_equal(np.bincount(number), 4)
    first = distance[::4]
    height = 3.0 + first * slopes
    reach = 30.0 + np.sqrt(8.0**2 - height**2)
    np.testing.assert_allclose(100.0 - first * directions[:, 0], np.sqrt(reach**2 - 7.0**2), rtol=1e-13)


@settings(quick, max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_crossing_of_a_wavy_rational_meridian_is_missed(seed):
    rng = np.random.default_rng(seed)
    heights = np.cumsum(rng.uniform(0.5, 3.0, 9))
    radii = rng.uniform(1.0, 8.0, 9)
    segments = [line((0.0, heights[0]), (radii[0], heights[0]))]
    for k in range(8):
        middle = rng.uniform([0.0, heights[0]], [10.0, heights[-1]], (2, 2))
        segment = cubic((radii[k], heights[k]), *middle, (radii[k + 1], heights[k + 1]))
        segment[:, 2] = rng.uniform(0.3, 3.0, 4)
        segments.append(segment)
    segments.append(line((radii[-1], heights[-1]), (0.0, heights[-1])))
    body = Revolved(np.array(segments), axis=rng.normal(size=3))
    origins, directions = rays(seed, 40, 8.0)
    found = crosser(body)(origins, directions)

    count, missed = brute_force_counts(body, origins, directions)
    ours = np.bincount(found.line, minlength=len(origins))
    # Sampling sees no more than there is, and nearly all of it.
    assert np.all(ours >= count)
    assert np.all((ours - count) % 2 == 0)
    assert np.all(ours <= count + missed)


def brute_force_counts(body, origins, directions, samples=4001):
    """Count crossings as sign changes along a finely sampled meridian, and places where a pair may hide.

    A point of the meridian turns into a circle about the axis; a line passes its plane at one point, on one side of
    the circle or the other.
    """
    u = np.linspace(0.0, 1.0, samples)
    basis = np.stack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
    weighted = body.meridian[:, :, :2] * body.meridian[:, :, 2:]
    r, z = (np.einsum("sk,ku->su", weighted[..., c], basis) / (body.meridian[:, :, 2] @ basis) for c in range(2))
    r, z = r.ravel(), z.ravel()
    relative = origins - body.base_mm
    slope = directions @ body.axis
    steep = np.abs(slope) > 1e-3
    safe = np.where(steep, slope, 1.0)
    counts, pairs = np.zeros(len(origins), int), np.full(len(origins), 10**6)
    for k in np.flatnonzero(steep):
        at = (z - relative[k] @ body.axis) / safe[k]
        point = relative[k] + at[:, None] * directions[k]
        gap = r - np.linalg.norm(point - z[:, None] * body.axis, axis=1)
        counts[k] = np.count_nonzero(np.diff(gap > 0.0))
        dips = (np.abs(gap[1:-1]) <= np.abs(gap[:-2])) & (np.abs(gap[1:-1]) <= np.abs(gap[2:]))
        close = np.abs(gap[1:-1]) < 4.0 * np.maximum(np.abs(np.diff(gap))[:-1], np.abs(np.diff(gap))[1:]) + 1e-9
        pairs[k] = 2 * np.count_nonzero(dips & close & (np.diff(gap > 0.0)[:-1] == 0) & (np.diff(gap > 0.0)[1:] == 0))
    return counts, pairs


def test_a_bottle_is_sound_from_every_side():
    scene = tracer_scenes.bottle(fill=True)
    origins, directions = tracer_scenes.rays_through(scene, 3000, seed=21)
    directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    for body in scene.bodies:
        assert_in_and_out_in_turn(body.surface, origins, directions)


@pytest.mark.parametrize("radius", [0.01, 1.0, 1e4])
def test_a_cylinder_is_met_at_its_closed_form(radius):
    body = cylinder(radius, -radius, radius)
    height = 0.6 * radius
    _, distance, entering, normal = crossings(body, [[-3.0 * radius, height, 0.1 * radius]], [[1.0, 0.0, 0.0]])
    np.testing.assert_allclose(distance, [2.2 * radius, 3.8 * radius], rtol=1e-14)
    np.testing.assert_array_equal(entering, [True, False])
    np.testing.assert_allclose(normal, [[-0.8, 0.6, 0.0], [0.8, 0.6, 0.0]], atol=1e-14)
