"""Molds that are meshes, for tests of what hollows them."""

import dataclasses

import numpy as np

from glassworkbench.mold.anatomy import Anatomy
from glassworkbench.mold.mold import Mold
from glassworkbench.scene import Mesh


def as_mesh(mold, mesh):
    """The same mold, known by a mesh alone."""
    anatomy = dataclasses.replace(mold.anatomy, finish_face=0)
    return Mold(None, None, mold.placement, anatomy, mold.name, mesh=mesh)


def mesh_mold(mesh, name="block"):
    """A mold that is an upright mesh whose flat top is its mouth."""
    low, high = mesh.vertices_mm.min(axis=0), mesh.vertices_mm.max(axis=0)
    radius = float(np.hypot(*mesh.vertices_mm[:, :2].T).max())
    width = float((high - low)[:2].min())
    anatomy = Anatomy(
        axis=np.array([0.0, 0.0, 1.0]),
        base_point_mm=np.zeros(3),
        height_mm=float(high[2]),
        finish_height_mm=float(high[2]),
        finish_outer_radius_mm=radius,
        finish_face=0,
        maximum_radius_mm=radius,
        smallest_width_mm=width,
        bearing_radius_mm=0.5 * width,
        push_up_mm=0.0,
        departure_mm=1.0,
        departure_at_mm=np.zeros(3),
        stem_top_mm=0.0,
        regions={"body": (0.0, float(high[2]))},
    )
    return Mold(None, None, np.eye(4), anatomy, name, mesh=mesh)


def cells_mesh(xs, ys, zs, full):
    """The closed mesh around the cells of a rectangular grid that are full (nx, ny, nz), flat on each side."""
    full = np.pad(np.asarray(full, dtype=bool), 1)
    lines = [np.asarray(values, dtype=float) for values in (xs, ys, zs)]
    corners = []
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1, 1):
            for cell in np.argwhere(full & ~np.roll(full, -side, axis=axis)) - 1:
                low = np.array([lines[k][cell[k]] for k in range(3)])
                high = np.array([lines[k][cell[k] + 1] for k in range(3)])
                p = low.copy()
                p[axis] = (low if side < 0 else high)[axis]
                q, r, s = p.copy(), p.copy(), p.copy()
                q[i], r[i], r[j], s[j] = high[i], high[i], high[j], high[j]
                quad = [p, q, r, s] if side > 0 else [p, s, r, q]
                corners += [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
    corners = np.array(corners)
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets /= np.linalg.norm(facets, axis=1, keepdims=True)
    both = np.concatenate([corners, np.repeat(facets[:, None], 3, axis=1)], axis=2).reshape(-1, 6)
    both, place = np.unique(both, axis=0, return_inverse=True)
    return Mesh(both[:, :3], place.reshape(-1, 3), both[:, 3:])


def ball_bottomed(radius, height, around=96, rows=24):
    """A cylinder with a hemisphere below it, its top flat, with exact normals."""
    polar = np.linspace(-0.5 * np.pi, 0.0, rows)
    profile = [(radius * np.cos(t), radius * (1 + np.sin(t)), np.cos(t), np.sin(t)) for t in polar]
    profile[0] = (0.0, 0.0, 0.0, -1.0)
    profile += [(radius, height, 1.0, 0.0), (radius, height, 0.0, 1.0), (0.0, height, 0.0, 1.0)]
    angle = 2 * np.pi * np.arange(around) / around
    vertices = np.array([[r * np.cos(a), r * np.sin(a), z] for r, z, _, _ in profile for a in angle]) + 0.0
    normals = np.array([[n * np.cos(a), n * np.sin(a), m] for _, _, n, m in profile for a in angle])
    triangles = []
    k, after = np.arange(around), (np.arange(around) + 1) % around
    for row in range(len(profile) - 1):
        if profile[row][:2] == profile[row + 1][:2]:
            continue
        low, high = row * around, (row + 1) * around
        if profile[row][0] > 0.0:
            triangles.append(np.column_stack([low + k, low + after, high + after]))
        if profile[row + 1][0] > 0.0:
            triangles.append(np.column_stack([low + k, high + after, high + k]))
    return Mesh(vertices, np.concatenate(triangles), normals)


def uniform(thickness):
    """A thickness that is the same everywhere, as `AskedThickness` takes it."""
    return lambda points, faces: np.full(len(points), float(thickness))
