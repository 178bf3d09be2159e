"""Bodies of rational Bezier patches: exact hits, no leaks, no facets, and input that is refused."""

import numpy as np
import patch_bodies
import pytest
import tracer_scenes

from glassworkbench.errors import InputError
from glassworkbench.scene import Body, Ellipsoid, Medium, Mesh, Patches, Revolved, Scene, Sheet
from glassworkbench.tracer import native
from glassworkbench.tracer.reference_surfaces import crosser

needs_native = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")


def glass(surface):
    """A scene of one tinted body under a coloured sky."""
    media = (Medium("glass", 1.5, (0.02, 0.01, 0.03)),)
    return Scene((Body("glass", surface),), media, (tracer_scenes.sky(),), tracer_scenes.CAMERA)


def rounded_rod():
    """A cylinder with a spherical end and a flat one with a rounded rim."""
    return np.array(
        [
            tracer_scenes.arc((0.0, 0.0), 10.0, -90.0, 0.0),
            tracer_scenes.line((10.0, 0.0), (10.0, 20.0)),
            tracer_scenes.arc((7.0, 20.0), 3.0, 0.0, 90.0),
            tracer_scenes.line((7.0, 23.0), (0.0, 23.0)),
        ]
    )


def torus():
    return np.array([tracer_scenes.arc((30.0, 0.0), 10.0, 90.0 * k, 90.0 * (k + 1)) for k in range(4)])


TWINS = {
    "ball": lambda: (patch_bodies.ball_patches(10.0), Ellipsoid((0.0, 0.0, 0.0), (10.0, 10.0, 10.0))),
    "coarse ball": lambda: (patch_bodies.ball_patches(10.0, 3), Ellipsoid((0.0, 0.0, 0.0), (10.0, 10.0, 10.0))),
    "rod": lambda: (patch_bodies.turned_patches(rounded_rod(), 8, 6), Revolved(rounded_rod())),
    "torus": lambda: (patch_bodies.turned_patches(torus(), 8, 6), Revolved(torus())),
}


@needs_native
@pytest.mark.parametrize("name", TWINS)
def test_patches_are_met_where_the_same_body_in_closed_form_is(name):
    patches, twin = (glass(surface) for surface in TWINS[name]())
    origins, directions = tracer_scenes.rays_through(patches, 20_000, seed=31)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    mine, truth = native.radiance(patches, origins, directions), native.radiance(twin, origins, directions)
    assert mine.leaks.sum() == 0
    found = crosser(twin.bodies[0].surface)(origins, directions)
    ahead = found.distance_mm > 0.0
    nearest = np.full(len(origins), np.inf)
    np.minimum.at(nearest, found.line[ahead], found.distance_mm[ahead])
    # A ray that all but touches may be told apart either way.
    assert np.count_nonzero(np.isfinite(nearest) != np.isfinite(mine.depth_mm)) <= 1
    met = np.isfinite(nearest) & np.isfinite(mine.depth_mm)
    error = np.abs(mine.depth_mm[met] - nearest[met])
    assert np.median(error) < 1e-12
    assert np.mean(error < 1e-9) > 0.9999
    # The native core crosses meridians inexactly with nearly horizontal rays, and the sky has no azimuth overhead.
    fair = (np.abs(directions[:, 2]) > 1e-2) & (np.abs(directions[:, 2]) < 0.99)
    difference = np.abs(mine.radiance - truth.radiance).max(axis=1)[fair]
    assert np.median(difference) < 1e-12
    assert np.mean(difference < 1e-6) > 0.999


@needs_native
@pytest.mark.parametrize("pieces", [2, 5, 11])
def test_how_fine_the_mesh_is_does_not_change_what_a_ray_sees(pieces):
    rays = tracer_scenes.rays_at((-9.0, -9.0, -9.0), (9.0, 9.0, 9.0), 5000, seed=32)
    coarse = native.radiance(glass(patch_bodies.ball_patches(10.0, pieces)), *rays)
    exact = native.radiance(glass(Ellipsoid((0.0, 0.0, 0.0), (10.0, 10.0, 10.0))), *rays)
    difference = np.abs(coarse.radiance - exact.radiance).max(axis=1)
    assert np.mean(difference < 1e-6) > 0.999


@needs_native
@pytest.mark.parametrize("body", ["ball", "rod", "torus", "pebble"])
def test_no_ray_leaks(body):
    patches = patch_bodies.pebble_patches() if body == "pebble" else TWINS[body]()[0]
    scene = glass(patches)
    answer = native.radiance(scene, *tracer_scenes.rays_through(scene, 50_000, seed=33), cutoff=1e-4)
    assert answer.crossings.sum() > 200_000
    assert answer.leaks.sum() == 0


def test_lines_through_vertices_edges_and_poles_leave_as_often_as_they_enter():
    patches = patch_bodies.ball_patches(10.0, 4)
    mesh = patches.mesh
    ends = np.concatenate([mesh.vertices_mm, mesh.vertices_mm[mesh.triangles].mean(axis=1)])
    middles = 0.5 * (mesh.vertices_mm[mesh.triangles] + mesh.vertices_mm[np.roll(mesh.triangles, -1, axis=1)])
    ends = np.concatenate([ends, middles.reshape(-1, 3)])
    starts = np.random.default_rng(34).permutation(ends)
    apart = np.linalg.norm(ends - starts, axis=1) > 0.0
    directions = (ends - starts)[apart]
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    found = crosser(patches)(starts[apart], directions)
    balance = np.bincount(found.line, np.where(found.entering, 1.0, -1.0), minlength=len(directions))
    assert np.all(balance == 0.0)
    points = starts[apart][found.line] + found.distance_mm[:, None] * directions[found.line]
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 10.0, atol=1e-9)
    np.testing.assert_allclose(found.normal, points / 10.0, atol=1e-6)


@needs_native
def test_a_ray_along_the_axis_meets_the_poles_square_on():
    scene = glass(patch_bodies.ball_patches(10.0))
    path = native.follow(scene, np.array([0.0, 0.0, 50.0]), np.array([0.0, 0.0, -1.0]))
    assert [crossing.cos_incidence for crossing in path] == pytest.approx([1.0, 1.0], abs=1e-9)
    # The normal at a pole is a limit, good to 1e-7 rad.
    np.testing.assert_allclose(path[0].point_mm, [0.0, 0.0, 10.0], atol=1e-12)
    np.testing.assert_allclose(path[1].point_mm, [0.0, 0.0, -10.0], atol=1e-6)


@needs_native
def test_a_wall_of_a_twentieth_of_a_millimetre_is_crossed_face_by_face():
    outer, inner = patch_bodies.ball_patches(10.0, 5), patch_bodies.ball_patches(9.95, 7)
    bodies = (Body("outer", outer), Body("inner", inner))
    scene = Scene(bodies, (Medium("outer and not inner", 1.5),), (tracer_scenes.sky(),), tracer_scenes.CAMERA)
    path = native.follow(scene, np.array([-50.0, 2.0, 3.0]), np.array([1.0, 0.0, 0.0]))
    assert [(crossing.body, crossing.entering) for crossing in path] == [
        ("outer", True),
        ("inner", True),
        ("inner", False),
        ("outer", False),
    ]
    answer = native.radiance(scene, *tracer_scenes.rays_through(scene, 20_000, seed=35))
    assert answer.leaks.sum() == 0


@pytest.mark.parametrize("highest", [9, 12, 25])
def test_a_sheet_of_high_degree_is_evaluated_like_its_quadratic_self(highest):
    # A straight line of degree 9 is the line, run evenly.
    quadratic = patch_bodies.turned_sheets([patch_bodies.quarter_arc((0.0, 0.0), 5.0, 0.0)])[0]
    raised = quadratic.control_points[0, 0]
    for degree in range(2, highest):
        weight = np.arange(degree + 2)[:, None, None] / (degree + 1)
        raised = weight * np.pad(raised, ((1, 0), (0, 0), (0, 0))) + (1.0 - weight) * np.pad(
            raised, ((0, 1), (0, 0), (0, 0))
        )
    uv = np.random.default_rng(36).uniform(0.0, 1.0, (50, 2))
    for mine, truth in zip(Sheet(raised[None, None]).evaluate(uv), quadratic.evaluate(uv), strict=True):
        np.testing.assert_allclose(mine, truth, atol=1e-12)


def test_derivatives_of_a_sheet_of_several_patches_are_its_slopes():
    sheet = patch_bodies.pebble_patches().sheets[0]
    uv = np.random.default_rng(37).uniform((0.1, 0.1), (5.9, 0.9), (40, 2))
    _, by_u, by_v = sheet.evaluate(uv)
    for slope, step in ((by_u, (1e-6, 0.0)), (by_v, (0.0, 1e-6))):
        difference = sheet.evaluate(uv + step)[0] - sheet.evaluate(uv - step)[0]
        np.testing.assert_allclose(slope, difference / 2e-6, atol=1e-6)


def test_corners_off_their_sheet_are_refused():
    ball = patch_bodies.ball_patches(10.0, 3)
    moved = np.array(ball.uv_of_corner)
    moved[7, 1] += 0.01
    with pytest.raises(InputError, match="corner 1 of triangle 7"):
        Patches(ball.sheets, ball.mesh, ball.sheet_of_triangle, moved)
    with pytest.raises(InputError, match="sheet_of_triangle"):
        Patches(ball.sheets[:4], ball.mesh, ball.sheet_of_triangle, ball.uv_of_corner)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda points: points[..., 3].__setitem__(..., 0.0), "weight"),
        (lambda points: points.__setitem__((0, 0, 0, 0, 0), np.nan), "finite"),
    ],
)
def test_sheets_that_mean_nothing_are_refused(change, word):
    points = np.array(patch_bodies.ball_patches(10.0, 3).sheets[0].control_points)
    change(points)
    with pytest.raises(InputError, match=word):
        Sheet(points)
    with pytest.raises(InputError, match="u_knots"):
        Sheet(np.ones((1, 1, 2, 2, 4)), u_knots=(1.0, 0.0))
    with pytest.raises(InputError, match="degrees"):
        Sheet(np.ones((1, 1, 27, 2, 4)))


def test_a_line_along_the_edge_between_an_entered_and_a_left_face_is_balanced():
    box = tracer_scenes.box_mesh((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    assert isinstance(box, Mesh)
    found = crosser(box)(np.array([[-5.0, 1.0, 1.0], [-5.0, -1.0, 1.0]]), np.tile([1.0, 0.0, 0.0], (2, 1)))
    assert np.sum(np.where(found.entering, 1, -1)) == 0
