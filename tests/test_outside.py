"""The outer point that decides about the wall: against closed forms, brute force, and the two searches compared."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glassworkbench.errors import InputError
from glassworkbench.scene import Mesh
from glassworkbench.spatial import nearest
from glassworkbench.wall.measuring.outside import outside_of_mesh


def tube(radius=30.0, height=100.0, sectors=96, levels=2):
    """A round can, its side and bottom with exact normals, and the mask of its mouth."""
    angle = 2.0 * np.pi * np.arange(sectors) / sectors
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(sectors)])
    k, after = np.arange(sectors), (np.arange(sectors) + 1) % sectors
    rows = np.linspace(0.0, height, levels)
    vertices = [radius * ring + [0, 0, z] for z in rows]
    normals = [ring for _ in rows]
    triangles = []
    for level in range(levels - 1):
        low, high = level * sectors, (level + 1) * sectors
        triangles += [np.column_stack([low + k, low + after, high + after])]
        triangles += [np.column_stack([low + k, high + after, high + k])]
    count = levels * sectors
    for z, up in ((0.0, -1.0), (height, 1.0)):
        vertices += [radius * ring + [0, 0, z], [[0, 0, z]]]
        normals += [np.tile([0, 0, up], (sectors + 1, 1))]
        fan = np.column_stack([count + k, count + after, np.full(sectors, count + sectors)])
        triangles.append(fan if up > 0 else fan[:, ::-1])
        count += sectors + 1
    mesh = Mesh(np.concatenate(vertices), np.concatenate(triangles), np.concatenate(normals))
    return mesh, np.arange(len(mesh.triangles)) >= len(mesh.triangles) - sectors


def outside(thickness_at, **size):
    mesh, mouth = tube(**size)
    height = mesh.vertices_mm[:, 2].max()
    return outside_of_mesh(mesh, np.zeros(len(mesh.triangles), dtype=int), mouth, height, thickness_at)


def test_a_coarse_mesh_stands_for_the_round_surface():
    wall = outside(lambda points, _: np.full(len(points), 2.5))
    random = np.random.default_rng(1)
    angle, depth = random.uniform(0, 2 * np.pi, 400), random.uniform(0.5, 8.0, 400)
    points = np.column_stack([(30 - depth) * np.cos(angle), (30 - depth) * np.sin(angle), random.uniform(20, 80, 400)])
    found = wall.clearance(points)
    # 96 facets of a circle of 30 mm are 0.016 mm off. What is left grows with the depth, as the foot slips along them.
    assert np.abs(found.clearance_mm - (depth - 2.5)).max() < 3e-3
    assert np.abs(np.hypot(*found.feet_mm[:, :2].T) - 30.0).max() < 1e-4


def test_where_the_thickness_grows_steadily_the_wall_is_a_cone():
    """Over a plane with the slope g of t, |p - s| - t(s) is lowest at d sqrt(1 - g^2) - t(foot)."""
    slope = 0.2
    wall = outside(lambda points, _: 2.0 + slope * points[:, 2] / 10.0, sectors=720)
    g = slope / 10.0
    points = np.array([[25.0, 0.0, 50.0], [28.0, 0.0, 30.0]])
    expected = (30.0 - points[:, 0]) * np.sqrt(1 - g**2) - (2.0 + g * points[:, 2])
    assert np.allclose(wall.clearance(points).clearance_mm, expected, atol=1e-4)


def test_a_thick_floor_decides_where_the_thin_side_is_nearer():
    wall = outside(lambda points, _: np.where(points[:, 2] < 1.0, 6.0, 2.0))
    found = wall.clearance(np.array([[26.0, 0.0, 5.0]]))
    assert found.clearance_mm[0] == pytest.approx(-1.0, abs=1e-6)
    assert wall.distance(np.array([[26.0, 0.0, 5.0]])).distance_mm[0] == pytest.approx(4.0, abs=1e-3)


def test_the_wall_goes_straight_on_above_the_mouth():
    wall = outside(lambda points, _: np.full(len(points), 3.0))
    above = wall.clearance(np.array([[20.0, 0.0, 103.0], [0.0, 0.0, 101.0]]))
    assert above.clearance_mm == pytest.approx([7.0, 27.0], abs=1e-2)
    assert wall.collar.any()
    # The collar is no glass: measured distances end at the rim.
    assert wall.distance(np.array([[30.0, 0.0, 104.0]])).distance_mm[0] == pytest.approx(4.0, abs=1e-3)


def test_the_collar_stands_on_the_rim_alone_also_where_the_thickness_varies():
    wall = outside(lambda points, _: 2.0 + 0.3 * np.sin(points[:, 2]))
    assert len(wall.corners_mm) > 2000
    assert wall.corners_mm[wall.collar][:, :, 2].min() == 100.0
    assert wall.lip_height_mm == 100.0


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_both_searches_find_the_same_lowest_place(seed):
    random = np.random.default_rng(seed)
    corners = random.normal(size=(60, 1, 3)) * 10 + random.normal(size=(60, 3, 3))
    normals = random.normal(size=(60, 3, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    triangles = nearest.NearestTriangles(corners, 0.2 * normals, random.uniform(0, 3, (60, 3)))
    points = random.normal(size=(40, 3)) * 12
    native, plain = triangles.search(points), nearest._NumpySearch(triangles)(points)
    assert np.allclose(native.clearance_mm, plain.clearance_mm, rtol=0, atol=1e-12)


def test_no_point_of_a_flat_triangle_lies_lower_than_the_one_found():
    random = np.random.default_rng(3)
    flat = np.zeros((50, 3, 3))
    corners, thickness = random.normal(size=(50, 3, 3)) * 4, random.uniform(0, 2, (50, 3))
    points = random.normal(size=(30, 3)) * 6
    found = nearest.NearestTriangles(corners, flat, thickness).search(points)
    shares = random.dirichlet([0.7, 0.7, 0.7], 4000)
    places = np.einsum("sk,mkx->smx", shares, corners).reshape(-1, 3)
    offsets = np.einsum("sk,mk->sm", shares, thickness).ravel()
    sampled = (np.linalg.norm(points[:, None] - places, axis=2) - offsets).min(axis=1)
    assert np.all(found.clearance_mm <= sampled + 1e-12)
    assert np.all(found.clearance_mm >= sampled - 0.2)


def test_no_triangles_and_numbers_that_are_none_are_refused():
    with pytest.raises(InputError, match="triangles"):
        nearest.NearestTriangles(np.zeros((0, 3, 3)), np.zeros((0, 3, 3)))
    with pytest.raises(InputError, match="finite"):
        nearest.NearestTriangles(np.full((1, 3, 3), np.nan), np.zeros((1, 3, 3)))
