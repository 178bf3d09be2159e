"""The lofted cavity: against closed forms, brute force, and OCC's own evaluation of the surface."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import mold_from_shape, tessellate
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.lofting.half_planes import aligned
from glassworkbench.wall.lofting.loft_surface import LoftSurface, chord_parameters
from glassworkbench.wall.measuring.outside import outside
from glassworkbench.wall.measuring.volumes import mesh_volume
from glassworkbench.wall.methods.lofted import lofted

UP = FreeCAD.Vector(0, 0, 1)


def uniform(thickness):
    return AskedThickness(lambda points, _: np.full(len(points), thickness), thickness, thickness)


def rounded_box(width, depth, height, radius):
    box = Part.makeBox(width, depth, height, FreeCAD.Vector(-width / 2, -depth / 2, 0))
    return box.makeFillet(radius, [edge for edge in box.Edges if abs(edge.tangentAt(edge.FirstParameter).z) > 0.99])


def hollowed(shape, asked):
    mold = mold_from_shape(shape, "test")
    wall = outside(mold, asked.at)
    return lofted(mold, asked, wall, 60.0), wall


def points_inside(candidate, below):
    """The centres of the cavity's triangles, with their areas, and the vertices, as points that are measured."""
    mesh = candidate.inside
    a, b, c = (mesh.vertices_mm[mesh.triangles[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    keep = np.max([a[:, 2], b[:, 2], c[:, 2]], axis=0) < below
    return mesh.vertices_mm[mesh.triangles[keep]], area[keep]


def share_off(candidate, wall, tolerance, below):
    """The share by area of the triangles with a corner that is off, and the thinnest deviation."""
    corners, area = points_inside(candidate, below)
    off = wall.clearance(corners.reshape(-1, 3)).clearance_mm.reshape(-1, 3)
    return float(area[np.abs(off).max(axis=1) > tolerance].sum() / area.sum()), float(off.min())


def test_a_box_with_round_edges_gets_a_box_with_rounder_edges():
    candidate, wall = hollowed(rounded_box(40, 60, 100, 8), uniform(3.0))
    volume = (34 * 54 - (4 - np.pi) * 5**2) * 97
    assert mesh_volume(candidate.inside).volume_mm3 == pytest.approx(volume, rel=1e-3)
    off, thinnest = share_off(candidate, wall, 0.06, 96.0)
    assert off < 0.01
    assert thinnest > -0.05 * 3.0
    assert candidate.solid.isValid()
    assert candidate.solid.isClosed()
    assert len(candidate.solid.Solids) == 1


def test_a_wall_thicker_than_the_fillet_leaves_a_crease_and_is_not_thinner_there():
    candidate, wall = hollowed(rounded_box(36, 50, 80, 2), uniform(5.0))
    off, thinnest = share_off(candidate, wall, 0.1, 74.0)
    assert off < 0.01
    assert thinnest > -0.05 * 5.0
    assert mesh_volume(candidate.inside).volume_mm3 == pytest.approx(26 * 40 * 75, rel=2e-3)


def test_the_cavity_reaches_past_the_mouth_and_inside_ends_level_with_it():
    candidate, _ = hollowed(rounded_box(40, 60, 90, 8), uniform(3.0))
    assert candidate.inside.vertices_mm[:, 2].max() == pytest.approx(90.0, abs=1e-9)
    assert candidate.cavity.vertices_mm[:, 2].max() > 92.0
    assert np.isclose(candidate.inside.vertices_mm[:, 2], 90.0, atol=1e-9).sum() > 100


def test_a_wall_that_varies_about_a_round_body_keeps_its_distance_everywhere():
    """The vertical part is that of a cylinder whose thickness depends on the angle alone: a problem in the plane."""
    radius, height = 30.0, 120.0
    body = Part.makeCylinder(radius, height - radius, FreeCAD.Vector(0, 0, radius), UP).fuse(
        Part.makeSphere(radius, FreeCAD.Vector(0, 0, radius), UP, -90, 0)
    )

    def around(angle):
        return 3.0 * (1.0 + 0.3 * np.cos(2.0 * angle))

    asked = AskedThickness(lambda points, _: around(np.arctan2(points[:, 1], points[:, 0])), 2.1, 3.9)
    candidate, _ = hollowed(body.removeSplitter(), asked)
    points = candidate.inside.vertices_mm
    points = points[(points[:, 2] > 50.0) & (points[:, 2] < 115.0)][::7]
    turn = np.linspace(0.0, 2.0 * np.pi, 7200, endpoint=False)
    circle = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    clearance = np.array([(np.linalg.norm(circle - point, axis=1) - around(turn)).min() for point in points[:, :2]])
    assert len(points) > 300
    assert np.abs(clearance).max() < 0.02
    outer = np.pi * radius**2 * (height - radius / 3.0)
    glass = mesh_volume(tessellate(candidate.solid, 0.1)).volume_mm3
    assert glass == pytest.approx(outer - mesh_volume(candidate.inside).volume_mm3, rel=1e-3)


def test_walls_that_meet_say_where_and_how_thick_they_may_be():
    with pytest.raises(InputError, match=r"at height .* at most 1[01]\.\d\d mm"):
        hollowed(rounded_box(22, 60, 100, 4), uniform(11.5))


def test_a_neck_that_closes_is_named():
    outline = [(0, 0), (30, 0), (30, 60), (8, 70), (8, 90), (14, 95), (14, 100), (0, 100)]
    wire = Part.makePolygon([FreeCAD.Vector(r, 0, z) for r, z in [*outline, outline[0]]])
    bottle = Part.Face(wire).revolve(FreeCAD.Vector(), UP, 360)
    with pytest.raises(InputError, match=r"at height [6789]\d\.\d mm .* at most 8\.00 mm"):
        hollowed(Part.Solid(bottle.Shells[0]), uniform(9.0))


def test_a_second_curve_in_a_half_plane_is_refused_with_its_place():
    arm = Part.makeBox(40, 18, 60, FreeCAD.Vector(20, -9, 20))
    jug = Part.makeCylinder(30, 100).fuse(arm).cut(Part.makeBox(14, 18, 24, FreeCAD.Vector(32, -9, 38)))
    with pytest.raises(GlassWorkbenchError, match=r"at angle .* more than one curve at height"):
        hollowed(jug, uniform(2.0))


def test_a_mold_that_is_a_mesh_gets_a_cavity_without_a_solid():
    mold, asked = mold_from_shape(rounded_box(40, 60, 100, 8), "test"), uniform(3.0)
    mold = replace(mold, solid=None, upright=None, mesh=tessellate(mold.upright, 0.05))
    wall = outside(mold, asked.at)
    candidate = lofted(mold, asked, wall, 60.0)
    assert candidate.solid is None
    assert share_off(candidate, wall, 0.06, 96.0)[0] < 0.01


def spheroid(columns=40, rows=30, squeeze=0.6):
    """A grid on the lower part of a spheroid, and its function."""

    def place(polar, turn):
        return np.stack(
            [
                20.0 * np.sin(polar) * np.cos(turn),
                squeeze * 20.0 * np.sin(polar) * np.sin(turn),
                20.0 - 20.0 * np.cos(polar),
            ],
            axis=-1,
        )

    polar, turn = np.meshgrid(np.linspace(0, 1.8, rows), 2 * np.pi * np.arange(columns) / columns, indexing="ij")
    return place(polar, turn)


def test_between_its_points_the_surface_is_exact_to_fourth_order():
    def worst(columns, rows):
        points = spheroid(columns, rows)
        surface = LoftSurface(*chord_parameters(points), points)
        u, v = np.linspace(0, surface.u[-1], 157), np.linspace(surface.v[3], surface.v[-4], 91)
        x, y, z = np.moveaxis(surface.at(u, v), -1, 0)
        return np.abs(np.sqrt(x**2 + (y / 0.6) ** 2 + (z - 20.0) ** 2) - 20.0).max()

    coarse, fine = worst(32, 24), worst(64, 48)
    assert coarse < 5e-3
    assert fine < coarse / 10.0


def test_occ_sees_the_surface_that_the_mesh_is_made_of():
    points = spheroid()
    points[12:, 5] *= 1.2  # A ridge that counts as a crease.
    surface = LoftSurface(*chord_parameters(points), points)
    face = surface.face()
    random = np.random.default_rng(5)
    u, v = random.uniform(0, surface.u[-1], 20), random.uniform(surface.v[0], surface.v[-1], 20)
    ours, normals = surface.with_normals(u, v)
    for i in range(20):
        for j in range(20):
            assert np.linalg.norm(np.array(face.Surface.value(u[j], v[i])) - ours[i, j]) < 1e-9
            theirs = np.array(face.Surface.normal(u[j], v[i]))
            assert abs(theirs @ normals[i, j]) == pytest.approx(1.0, abs=1e-9)


def test_the_mesh_of_a_spheroid_has_its_volume_and_its_normals():
    points = spheroid(squeeze=1.0)
    surface = LoftSurface(*chord_parameters(points), points)
    mesh = surface.mesh(np.linspace(0, surface.u[-1], 121)[:-1], np.linspace(0, surface.v[-1], 81))
    depth = 20.0 - 20.0 * np.cos(1.8)
    assert mesh_volume(mesh).volume_mm3 == pytest.approx(np.pi * depth**2 * (20.0 - depth / 3.0), rel=1e-4)
    curved = mesh.vertices_mm[:, 2] < depth - 1e-6
    away = mesh.vertices_mm[curved] - [0, 0, 20.0]
    assert np.einsum("ij,ij->i", away / 20.0, mesh.normals[curved]).min() > 1.0 - 1e-5


def test_rows_follow_heel_shoulder_and_neck_of_every_curve():
    """Two profiles of different widths: each row holds the same corner of both."""

    def curve(width, step=0.05):
        corners = np.array([[0, 0], [width, 0], [width, 60], [10, 70], [10, 90.01]])
        pieces = [
            np.linspace(a, b, int(np.linalg.norm(b - a) / step), endpoint=False) for a, b in itertools.pairwise(corners)
        ]
        return np.vstack([*pieces, corners[-1]])

    grid = aligned([curve(20.0), curve(40.0)], 90.0, 400)
    for at in ((0, [20.0, 0.0], [40.0, 0.0]), (1, [20.0, 60.0], [40.0, 60.0])):
        _, narrow, wide = at
        rows = [int(np.linalg.norm(grid[:, k] - corner, axis=1).argmin()) for k, corner in enumerate((narrow, wide))]
        assert abs(rows[0] - rows[1]) <= 8
    assert np.allclose(grid[-1], [[10.0, 90.0], [10.0, 90.0]], atol=1e-6)
