"""Surfaces that cross themselves: OCC calls them valid, the check does not."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold.self_intersection import intersections, self_intersections
from glassworkbench.mold.tessellation import tessellate
from glassworkbench.scene import Mesh


def turned(profile, steps=48):
    """The body that a closed polyline (r, z) from axis to axis turns through."""
    profile = np.asarray(profile, dtype=float)
    angle = 2 * np.pi * np.arange(steps) / steps
    rings = [np.column_stack([r * np.cos(angle), r * np.sin(angle), np.full(steps, z)]) for r, z in profile]
    k, after = np.arange(steps), (np.arange(steps) + 1) % steps
    triangles = []
    for row in range(len(rings) - 1):
        low, high = row * steps, (row + 1) * steps
        triangles.append(np.column_stack([low + k, low + after, high + after]))
        triangles.append(np.column_stack([low + k, high + after, high + k]))
    return Mesh(np.concatenate(rings), np.concatenate(triangles))


FOLDED_HEEL = [(0, 0), (24, 0), (30, 4), (27, -1), (28, 20), (28, 60), (0, 60)]


def test_a_heel_that_folds_over_itself_passes_occ_and_is_found_here():
    points = [FreeCAD.Vector(r, 0, z) for r, z in FOLDED_HEEL]
    face = Part.Face(Part.makePolygon([*points, points[0]]))
    solid = face.revolve(FreeCAD.Vector(), FreeCAD.Vector(0, 0, 1), 360)
    assert solid.isValid()
    places = self_intersections(turned(FOLDED_HEEL))
    # The line from (24, 0) to (30, 4) meets that from (27, -1) to (28, 20) on a circle.
    along = np.linalg.solve(np.array([[6.0, -1.0], [4.0, -21.0]]), np.array([3.0, -1.0]))[0]
    assert len(places)
    assert np.hypot(places[:, 0], places[:, 1]) == pytest.approx(np.full(len(places), 24 + 6 * along), abs=0.2)
    assert places[:, 2] == pytest.approx(np.full(len(places), 4 * along), abs=0.2)


@pytest.mark.parametrize(
    "mesh",
    [
        turned([(0, 0), (24, 0), (30, 4), (28, 20), (28, 60), (0, 60)]),
        tessellate(Part.makeBox(10, 10, 10), 0.1),
        tessellate(Part.makeTorus(20, 6), 0.05),
        tessellate(Part.makeCylinder(30, 100).cut(Part.makeCylinder(27, 97, FreeCAD.Vector(0, 0, 3))), 0.05),
    ],
    ids=["turned", "box", "torus", "beaker"],
)
def test_a_sound_body_has_none(mesh):
    assert len(self_intersections(mesh)) == 0


def test_two_bodies_in_one_mesh_cross_where_they_overlap():
    one = tessellate(Part.makeSphere(10), 0.1)
    count = len(one.vertices_mm)
    both = Mesh(
        np.concatenate([one.vertices_mm, one.vertices_mm + np.array([12.0, 0, 0])]),
        np.concatenate([one.triangles, one.triangles + count]),
    )
    places = self_intersections(both)
    assert places[:, 0] == pytest.approx(np.full(len(places), 6.0), abs=0.2)
    assert np.hypot(places[:, 1], places[:, 2]) == pytest.approx(np.full(len(places), 8.0), abs=0.2)


def test_a_cavity_crosses_the_outside_or_does_not():
    outer = tessellate(Part.makeCylinder(30, 100), 0.05)
    assert len(intersections(outer, tessellate(Part.makeCylinder(27, 97, FreeCAD.Vector(0, 0, 3)), 0.05))) == 0
    pierced = intersections(outer, tessellate(Part.makeCylinder(27, 97, FreeCAD.Vector(4, 0, 3)), 0.05))
    assert len(pierced)
    # x^2 + y^2 = 30^2 and (x - 4)^2 + y^2 = 27^2.
    assert pierced[:, 0].min() == pytest.approx(187 / 8, abs=0.1)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_pairs_are_those_of_a_search_through_all(seed):
    """Sides through triangles, by signs of volumes: another formula, and every pair."""
    random = np.random.default_rng(seed)
    sets = [tetrahedra(random, 12), tetrahedra(random, 9)]
    corners = [mesh.vertices_mm[mesh.triangles] for mesh in sets]
    expected = sum(crosses(p, q) for p in corners[0] for q in corners[1])
    assert len(intersections(*sets)) == expected


def tetrahedra(random, count):
    vertices = (random.normal(size=(count, 1, 3)) * 2 + random.normal(size=(count, 4, 3))).reshape(-1, 3)
    faces = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]])
    return Mesh(vertices, (4 * np.arange(count)[:, None, None] + faces).reshape(-1, 3))


def crosses(p, q):
    def volume(a, b, c, d):
        return np.dot(np.cross(b - a, c - a), d - a)

    def pierces(triangle, other):
        a, b, c = other
        for k in range(3):
            s, e = triangle[k], triangle[(k + 1) % 3]
            if volume(a, b, c, s) * volume(a, b, c, e) < 0:
                signs = [volume(s, e, a, b), volume(s, e, b, c), volume(s, e, c, a)]
                if min(signs) > 0 or max(signs) < 0:
                    return True
        return False

    return pierces(p, q) or pierces(q, p)
