"""Scenes say what is wrong with them when they are made."""

import pickle

import numpy as np
import pytest
import tracer_scenes
from tracer_scenes import CAMERA, arc, box_mesh, line, polyline

from glassworkbench.errors import InputError
from glassworkbench.scene import (
    Body,
    ContainerGeometry,
    Ellipsoid,
    Environment,
    Medium,
    Mesh,
    Panel,
    Pinhole,
    Revolved,
    Scene,
    Telecentric,
    medium_table,
)

CONE = [(0.0, 0.0), (10.0, 0.0), (0.0, 20.0)]


def test_a_meridian_is_stored_with_the_body_to_its_left():
    upward = Revolved(polyline(*CONE))
    downward = Revolved(polyline(*reversed(CONE)))
    np.testing.assert_allclose(downward.meridian, upward.meridian)
    assert upward.meridian[0, 0, 1] == 0.0


def test_pieces_on_the_axis_and_points_are_dropped():
    closed = Revolved(polyline(*CONE, (0.0, 20.0), (0.0, 5.0), (0.0, 0.0)))
    assert len(closed.meridian) == 2


def test_gaps_of_rounding_are_closed_exactly():
    meridian = polyline(*CONE)
    meridian[1, 0, :2] += 1e-9
    joined = Revolved(meridian).meridian
    np.testing.assert_array_equal(joined[0, 3, :2], joined[1, 0, :2])


def test_a_scene_may_be_sent_to_another_process():
    scene = tracer_scenes.bottle(fill=True)
    again = pickle.loads(pickle.dumps(scene))
    np.testing.assert_array_equal(again.bodies[0].surface.meridian, scene.bodies[0].surface.meridian)
    assert again.medium_table().tolist() == scene.medium_table().tolist()


def with_control_point(index, value):
    meridian = polyline(*CONE)
    meridian[index] = value
    return meridian


@pytest.mark.parametrize(
    ("meridian", "word"),
    [
        (np.empty((0, 4, 3)), "no segments"),
        (polyline((0.0, 0.0), (10.0, 0.0), (10.0, 20.0)), "open"),
        (np.array([line((0, 0), (10, 0)), line((11, 0), (0, 20))]), "gap"),
        (polyline((0.0, 0.0), (-10.0, 0.0), (0.0, 20.0)), "left of the axis"),
        (with_control_point((0, 1, 2), 0.0), "weight"),
        (with_control_point((1, 2, 1), np.nan), "finite"),
        (polyline((0.0, 0.0), (10.0, 10.0), (0.0, 0.0)), "no area"),
        (polyline((0.0, 0.0), (0.0, 20.0)), "off the axis"),
        (np.zeros((2, 3, 3)), "n x 4 x 3"),
        ("bottle", "expected numbers"),
    ],
)
def test_a_meridian_that_bounds_no_body_is_refused(meridian, word):
    with pytest.raises(InputError, match=word):
        Revolved(meridian)


def test_an_axis_needs_a_direction():
    with pytest.raises(InputError, match="axis"):
        Revolved(polyline(*CONE), axis=(0.0, 0.0, 0.0))


def test_a_ring_may_close_on_itself_off_the_axis():
    ring = Revolved(np.array([arc((30.0, 0.0), 5.0, 90.0 * k, 90.0 * (k + 1)) for k in range(4)]))
    np.testing.assert_array_equal(ring.meridian[-1, 3, :2], ring.meridian[0, 0, :2])


def test_a_mesh_with_a_hole_is_refused_and_the_hole_placed():
    box = box_mesh((0.0, 0.0, 0.0), (1.0, 2.0, 3.0))
    with pytest.raises(InputError, match=r"not closed, near \("):
        Mesh(box.vertices_mm, box.triangles[1:])


def test_a_mesh_with_a_face_turned_over_is_refused():
    box = box_mesh((0.0, 0.0, 0.0), (1.0, 2.0, 3.0))
    turned = box.triangles.copy()
    turned[0] = turned[0, ::-1]
    with pytest.raises(InputError, match="not closed"):
        Mesh(box.vertices_mm, turned)


@pytest.mark.parametrize(
    ("triangles", "word"),
    [([[0, 1, 99]] * 4, "out of range"), ([[0, 1, -1]] * 4, "out of range"), ([[0, 1, 2]], "at least 4")],
)
def test_triangles_must_name_their_vertices(triangles, word):
    with pytest.raises(InputError, match=word):
        Mesh(np.eye(3), triangles)


def test_normals_that_are_not_given_point_outwards():
    ball = tracer_scenes.ball_mesh(5.0)
    averaged = Mesh(ball.vertices_mm, ball.triangles).normals
    np.testing.assert_allclose(np.linalg.norm(averaged, axis=1), 1.0)
    assert np.all(np.einsum("ij,ij->i", averaged, ball.normals) > 0.99)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: Ellipsoid((0, 0, 0), (1, 0, 1)), "semi_axes_mm"),
        (lambda: Ellipsoid((0, 0, 0), (1, 1, 1), 2.0 * np.eye(3)), "orthonormal"),
        (lambda: Ellipsoid((0, 0), (1, 1, 1)), "centre_mm"),
        (lambda: Body("not", None), "body name"),
        (lambda: Body("1st", None), "body name"),
        (lambda: Medium("a", 0.9), "refractive_index"),
        (lambda: Medium("a", float("nan")), "refractive_index"),
        (lambda: Medium("a", 1.5, (0.1, -0.1, 0.0)), "absorption_per_mm"),
        (lambda: Medium("a and", 1.5), "a and"),
        (lambda: Panel((0, 0, 0), (1, 0, 0), (2, 0, 0)), "span an area"),
        (lambda: Panel((0, 0, 0), (1, 0, 0), (0, 1, 0), -1.0), "radiance"),
        (lambda: Environment(np.empty((0, 4, 3))), "radiance"),
        (lambda: Environment((1.0, -1.0, 0.0)), "radiance"),
        (lambda: Pinhole((0, 0, 0), (0, 0, 0), 1.0), "differ"),
        (lambda: Pinhole((0, 0, 0), (0, 0, 9), 1.0), "parallel"),
        (lambda: Pinhole((0, 0, 0), (0, 9, 0), np.pi), "180"),
        (lambda: Telecentric((0, 0, 0), (0, 9, 0), 0.0), "height_mm"),
        (lambda: ContainerGeometry(None, None, (0, 0, 0), (1, 0, 1), 1.0), "high_mm"),
        (lambda: Scene((), (), (), CAMERA, size=(0, 10)), "size"),
        (lambda: Scene((), (), (Environment(1.0), Environment(2.0)), CAMERA), "environment"),
    ],
)
def test_values_that_cannot_be_are_refused_by_name(make, word):
    with pytest.raises(InputError, match=word):
        make()


def test_two_bodies_need_two_names():
    ball = Ellipsoid((0, 0, 0), (1, 1, 1))
    with pytest.raises(InputError, match="twice"):
        Scene((Body("a", ball), Body("a", ball)), (), (), CAMERA)


def test_the_first_medium_that_matches_holds():
    media = (Medium("a and b", 1.3), Medium("a or c", 1.5), Medium("b and not c", 1.4))
    # Rows count a, b, c as bits 1, 2, 4.
    assert medium_table(("a", "b", "c"), media).tolist() == [0, 2, 3, 1, 2, 2, 2, 1]


@pytest.mark.parametrize(
    ("where", "word"),
    [
        ("glas", "no body is named 'glas'"),
        ("not a", "air"),
        ("a + b", "joined by"),
        ("__import__('os')", "joined by"),
        ("a if b else a", "joined by"),
        ("True", "joined by"),
    ],
)
def test_an_expression_that_means_nothing_is_refused(where, word):
    with pytest.raises(InputError, match=word):
        medium_table(("a", "b"), (Medium(where, 1.5),))


def test_there_are_as_many_bodies_as_bits():
    names = tuple(f"b{k}" for k in range(17))
    with pytest.raises(InputError, match="at most 16"):
        medium_table(names, ())
