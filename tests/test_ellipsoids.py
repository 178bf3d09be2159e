"""A body of many ellipsoids: the same light as the same ellipsoids apart, no leaks, and none may touch."""

from dataclasses import replace

import numpy as np
import pytest
import tracer_scenes

from glassworkbench.errors import InputError
from glassworkbench.scene import Body, Ellipsoid, Ellipsoids, Environment, Medium, Scene, Telecentric
from glassworkbench.scene.touching import contact_function, touching_pairs
from glassworkbench.tracer import native, reference, render

TRACERS = [
    pytest.param(native, marks=pytest.mark.skipif(not native.available(), reason="the native tracer is not built")),
    reference,
]
GLASS = 1.52
BALL = Body("ball", Ellipsoid((0.0, 0.0, 0.0), (10.0, 10.0, 10.0)))


def turns(count, rng):
    """Random rotations."""
    return np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]


def field(count, radius=0.3, seed=3):
    """Ellipsoids of up to a radius, at random places of a lattice within 7 mm of the origin."""
    rng = np.random.default_rng(seed)
    lattice = np.stack(np.meshgrid(*[np.arange(-6.0, 7.0)] * 3), axis=-1).reshape(-1, 3)
    lattice = lattice[np.linalg.norm(lattice, axis=1) < 6.5]
    centres = rng.permutation(lattice)[:count] + rng.uniform(-0.15, 0.15, (count, 3))
    return centres, radius * rng.uniform(0.05, 1.0, (count, 3)), turns(count, rng)


def scene_of(bodies, where):
    return Scene(
        (BALL, *bodies), (Medium(where, GLASS, (0.02, 0.0, 0.01)),), (tracer_scenes.sky(),), tracer_scenes.CAMERA
    )


@pytest.mark.parametrize("tracer", TRACERS)
def test_one_body_of_many_is_as_many_bodies(tracer):
    centres, semi_axes, rotations = field(12)
    one = scene_of([Body("bubbles", Ellipsoids(centres, semi_axes, rotations))], "ball and not bubbles")
    bodies = [
        Body(f"bubble_{k}", Ellipsoid(*values))
        for k, values in enumerate(zip(centres, semi_axes, rotations, strict=True))
    ]
    many = scene_of(bodies, "ball and not (" + " or ".join(body.name for body in bodies) + ")")
    rays = tracer_scenes.rays_at((-7.0,) * 3, (7.0,) * 3, 4000, seed=4)
    mine, truth = tracer.radiance(one, *rays), tracer.radiance(many, *rays)
    np.testing.assert_array_equal(mine.crossings, truth.crossings)
    np.testing.assert_allclose(mine.radiance, truth.radiance, rtol=0.0, atol=1e-9)
    assert mine.leaks.sum() == 0


@pytest.mark.parametrize("size", [0.3, 0.01])
@pytest.mark.skipif(not native.available(), reason="the native tracer is not built")
def test_a_field_of_bubbles_down_to_a_hundredth_of_a_millimetre_loses_no_light(size):
    centres, semi_axes, rotations = field(800)
    bubbles = Ellipsoids(centres, semi_axes * size / semi_axes.max(), rotations)
    furnace = Scene(
        (BALL, Body("bubbles", bubbles)),
        (Medium("ball and not bubbles", GLASS),),
        (Environment(1.0),),
        tracer_scenes.CAMERA,
    )
    rng = np.random.default_rng(5)
    origins = 30.0 * turns(20_000, rng)[:, 0]
    # Half of the rays at the bubbles themselves, not past them.
    targets = np.where(np.arange(len(origins))[:, None] % 2, rng.uniform(-7, 7, origins.shape), 0.0)
    targets += np.where(
        np.arange(len(origins))[:, None] % 2, 0.0, centres[rng.integers(len(centres), size=len(origins))]
    )
    answer = native.radiance(furnace, origins, targets - origins, cutoff=1e-4)
    assert answer.leaks.sum() == 0
    np.testing.assert_allclose(answer.radiance[:, 0] + answer.left_out[:, 0], 1.0, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("tracer", TRACERS)
def test_a_bubble_that_crosses_the_wall_is_open_and_loses_no_light(tracer):
    centres = np.array([[10.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, -9.9]])
    bubbles = Ellipsoids(centres, np.array([[1.0, 2.0, 1.0], [1.0, 1.0, 1.0], [0.1, 0.1, 0.1]]))
    furnace = Scene(
        (BALL, Body("bubbles", bubbles)),
        (Medium("ball and not bubbles", GLASS),),
        (Environment(1.0),),
        tracer_scenes.CAMERA,
    )
    answer = tracer.radiance(furnace, *tracer_scenes.rays_at((-11.0,) * 3, (11.0,) * 3, 3000, seed=6), cutoff=1e-3)
    assert answer.leaks.sum() == 0
    np.testing.assert_allclose(answer.radiance[:, 0] + answer.left_out[:, 0], 1.0, rtol=0.0, atol=1e-9)


@pytest.mark.skipif(not native.available(), reason="the native tracer is not built")
def test_a_film_of_air_a_thousand_times_as_wide_as_thick_is_crossed_where_the_closed_form_says():
    film = Ellipsoids([(0.0, 0.0, 0.0)], [(5.0, 5.0, 0.005)])
    scene = scene_of([Body("film", film)], "ball and not film")
    radius = np.array([0.0, 1.0, 3.0, 4.9, 4.999])
    for r in radius:
        path = native.follow(scene, (r, 0.0, 50.0), (0.0, 0.0, -1.0))
        assert [crossing.body for crossing in path[:2]] == ["ball", "film"]
    straight = Scene(
        (BALL, Body("film", film)), (Medium("film", 1.0, (1.0, 1.0, 1.0)),), (Environment(1.0),), tracer_scenes.CAMERA
    )
    origins = np.column_stack([radius, 0.0 * radius, 50.0 + 0.0 * radius])
    answer = native.radiance(straight, origins, np.tile((0.0, 0.0, -1.0), (len(radius), 1)))
    thickness = 0.01 * np.sqrt(1.0 - (radius / 5.0) ** 2)
    np.testing.assert_allclose(answer.radiance[:, 0], np.exp(-thickness), rtol=0.0, atol=1e-12)


@pytest.mark.skipif(not native.available(), reason="the native tracer is not built")
def test_two_paths_through_two_bubbles_are_two_paths():
    """An image that interpolated between them would show one large bubble."""
    centres = np.array([(x, 0.0, z) for x in (-0.6, 0.6) for z in (-0.6, 0.6)])
    bubbles = Ellipsoids(centres, np.full((4, 3), 0.5))
    together = scene_of([Body("bubbles", bubbles)], "ball and not bubbles")
    bodies = [Body(f"bubble_{k}", Ellipsoid(centre, (0.5,) * 3)) for k, centre in enumerate(centres)]
    apart = scene_of(bodies, "ball and not (" + " or ".join(body.name for body in bodies) + ")")
    camera = Telecentric((0.0, -50.0, 0.0), (0.0, 0.0, 0.0), 15.6)
    images = [render(replace(scene, camera=camera, size=(13, 13)), tolerance=0.05) for scene in (together, apart)]
    np.testing.assert_allclose(images[0].pixels, images[1].pixels, rtol=0.0, atol=1e-6)


def test_ellipsoids_that_touch_are_named():
    centres, semi_axes, rotations = field(100)
    centres = np.concatenate([centres, centres[6:7] + 0.01])
    with pytest.raises(InputError, match=r"^ellipsoids 7 and 101 touch or overlap \(the first lies at"):
        Ellipsoids(centres, np.concatenate([semi_axes, semi_axes[6:7]]), np.concatenate([rotations, rotations[6:7]]))


def test_ellipsoids_are_told_apart_where_their_boxes_are_not():
    """Two needles side by side, askew: their boxes overlap, and they touch when they are as thick as their distance."""
    turned = np.array([[1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, np.sqrt(2.0)]]) / np.sqrt(2.0)
    centres = np.array([[0.0, 0.0, 0.0], 1.0 * turned[:, 1]])
    for thickness, touching in ((0.499999, 0), (0.500001, 1)):
        pairs = touching_pairs(centres, np.array([[20.0, thickness, thickness]] * 2), np.array([turned] * 2))
        assert len(pairs) == touching


@pytest.mark.parametrize("seed", range(5))
def test_the_contact_function_is_what_points_on_the_surfaces_say(seed):
    rng = np.random.default_rng(seed)
    arms = turns(40, rng) * rng.uniform(0.2, 2.0, (40, 1, 3))
    between = rng.normal(size=(20, 3)) * 2.0
    contact = contact_function(between, arms[:20], arms[20:])
    # Grown by the factor they touch: of the second's surface the point deepest in the first lies on it.
    azimuth, height = np.meshgrid(np.linspace(0, 2 * np.pi, 721), np.linspace(-1, 1, 361))
    sphere = np.stack([np.sqrt(1 - height**2) * np.cos(azimuth), np.sqrt(1 - height**2) * np.sin(azimuth), height], -1)
    for k, squared in enumerate(contact):
        factor = np.sqrt(squared)
        points = between[k] + factor * sphere.reshape(-1, 3) @ arms[20 + k].T
        deepest = np.linalg.norm(points @ np.linalg.inv(arms[k]).T, axis=1).min()
        assert deepest == pytest.approx(factor, rel=2e-3)


def test_touching_pairs_are_those_of_brute_force():
    rng = np.random.default_rng(8)
    count = 400
    centres, semi_axes = rng.uniform(0.0, 10.0, (count, 3)), rng.uniform(0.05, 0.6, (count, 3))
    rotations = turns(count, rng)
    first, second = np.triu_indices(count, 1)
    arms = rotations * semi_axes[:, None, :]
    touching = contact_function(centres[second] - centres[first], arms[first], arms[second]) <= 1.0
    expected = np.column_stack([first, second])[touching]
    assert len(expected) > 50
    np.testing.assert_array_equal(touching_pairs(centres, semi_axes, rotations), expected)


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ((np.zeros((0, 3)), np.zeros((0, 3))), "there is none"),
        (([(0.0, 0.0, 0.0)], [(1.0, 0.0, 1.0)]), "above 0, got 0 of ellipsoid 1"),
        (([(0.0, 0.0, np.nan)], [(1.0, 1.0, 1.0)]), "centres_mm"),
        (([(0.0, 0.0, 0.0)], [(1.0, 1.0, 1.0)], [2.0 * np.eye(3)]), "orthonormal"),
    ],
)
def test_ellipsoids_that_cannot_be_are_refused_by_name(values, word):
    with pytest.raises(InputError, match=word):
        Ellipsoids(*values)
