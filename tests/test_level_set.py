"""Grids near a zero level, and the surface between their nodes."""

import numpy as np
import pytest

from glassworkbench.wall.levels.cavity_nodes import joined, without_border
from glassworkbench.wall.levels.dual_surface import dual_surface, without_ambiguity
from glassworkbench.wall.levels.level_set import sampled


def test_few_nodes_are_evaluated_and_all_signs_are_right():
    asked = []

    def ball(points):
        asked.append(len(points))
        return 20.0 - np.linalg.norm(points - [0.1, 0.2, 0.3], axis=1)

    grid = sampled(ball, np.full(3, -24.0), np.full(3, 24.0), 1.0)
    nodes = np.argwhere(np.ones(grid.bound_mm.shape, dtype=bool))
    true = ball(grid.points(nodes)).reshape(grid.bound_mm.shape)
    assert np.array_equal(grid.bound_mm > 0.0, true > 0.0)
    assert np.all(np.abs(grid.bound_mm) <= np.abs(true) + 1e-12)
    assert sum(asked[:-1]) < 0.15 * grid.bound_mm.size


@pytest.mark.parametrize("seed", range(5))
def test_the_surface_around_any_nodes_is_closed_and_manifold(seed):
    random = np.random.default_rng(seed)
    some = without_border(random.random((12, 12, 12)) < 0.4)
    kept = without_ambiguity(some, random.random(some.shape))
    assert np.all(some | ~kept)
    quads = dual_surface(kept).quads
    directed = np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)])
    once = np.unique(directed, axis=0)
    assert len(once) == len(directed)
    assert np.array_equal(once, np.unique(directed[:, ::-1], axis=0))


def test_two_nodes_beside_each_other_make_a_box_turned_outward():
    inside = np.zeros((5, 4, 4), dtype=bool)
    inside[1:3, 1, 1] = True
    surface = dual_surface(inside)
    p, q, r, s = (surface.places[surface.quads[:, k]] for k in range(4))
    volume = sum(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() for a, b, c in ((p, q, r), (p, r, s))) / 6.0
    assert len(surface.quads) == 10
    assert volume > 0.0


def test_nodes_are_joined_along_edges_only():
    positive = np.zeros((6, 6, 6), dtype=bool)
    positive[1:4, 1, 1] = positive[4, 2, 1] = True
    seed = np.zeros_like(positive)
    seed[1, 1, 1] = True
    assert np.argwhere(joined(positive, seed)).tolist() == [[1, 1, 1], [2, 1, 1], [3, 1, 1]]
