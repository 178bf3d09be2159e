"""What a good closed mesh is, checked by brute force."""

import numpy as np


def welded(mesh):
    points, place = np.unique(mesh.vertices_mm, axis=0, return_inverse=True)
    return points, place.reshape(-1)[mesh.triangles]


def euler_characteristic(mesh):
    """Vertices - edges + triangles; fails where an edge has not just two triangles, running along it oppositely."""
    points, triangles = welded(mesh)
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert np.all(directed[:, 0] != directed[:, 1])
    assert len(np.unique(directed, axis=0)) == len(directed)
    assert np.array_equal(np.unique(directed, axis=0), np.unique(directed[:, ::-1], axis=0))
    return len(points) - len(directed) // 2 + len(triangles)


def crossings(mesh):
    """How many sides of triangles pass through the inside of triangles that share no corner with them."""
    points, triangles = welded(mesh)
    sides = np.unique(
        np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), 1), axis=0
    )
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    found = 0
    for start, end in sides:
        p, q = points[start], points[end]
        near = np.all((low <= np.maximum(p, q)) & (high >= np.minimum(p, q)), axis=1)
        near &= ~np.any((triangles == start) | (triangles == end), axis=1)
        for k in np.flatnonzero(near):
            before, after = normal[k] @ (p - a[k]), normal[k] @ (q - a[k])
            if before * after >= 0.0:
                continue
            x = p + (q - p) * before / (before - after)
            shares = [normal[k] @ np.cross(v - u, x - u) for u, v in ((a[k], b[k]), (b[k], c[k]), (c[k], a[k]))]
            found += min(shares) > 1e-9 * (normal[k] @ normal[k])
    return found


def share_across_creases(mesh):
    """The share of the area in triangles that are more than 8 degrees off a normal at one of their corners."""
    corners = mesh.vertices_mm[mesh.triangles]
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(facets, axis=1)
    agree = np.einsum("ij,ikj->ik", facets / area[:, None], mesh.normals[mesh.triangles]).min(axis=1)
    return float(area[agree < 0.99].sum() / area.sum())
