"""Bodies of rational Bezier patches for the tracer's tests, made from numbers alone, and their tessellation."""

import numpy as np

from glassworkbench.scene import Mesh, Patches, Sheet

WELD_DECIMALS = 9


def quarter_arc(centre, radius, start_deg):
    """A quarter circle as one rational quadratic (r, z, weight)."""
    a, b = np.radians([start_deg, start_deg + 90.0])
    ends = np.array([[np.cos(a), np.sin(a)], [np.cos(b), np.sin(b)]])
    points = np.array([ends[0], ends[0] + ends[1], ends[1]]) * radius + np.array(centre)
    return np.column_stack([points, [1.0, np.sqrt(0.5), 1.0]])


def turned_sheets(meridian):
    """A meridian of Bezier segments (r, z, weight) turned about z: four sheets a segment, exact."""
    circle = np.array([[1.0, 0.0, 1.0], [1.0, 1.0, np.sqrt(0.5)], [0.0, 1.0, 1.0]])
    sheets = []
    for segment in meridian:
        for quarter in range(4):
            turn = np.linalg.matrix_power(np.array([[0.0, 1.0], [-1.0, 0.0]]), quarter)
            around = circle[:, :2] @ turn
            points = np.empty((3, len(segment), 4))
            points[..., :2] = around[:, None, :] * segment[None, :, :1]
            points[..., 2] = segment[:, 1]
            points[..., 3] = 1.0
            points *= circle[:, 2, None, None] * segment[:, 2, None]
            sheets.append(Sheet(points[None, None]))
    return sheets


def ball_patches(radius, pieces=8):
    """A sphere as eight rational biquadratic octants."""
    meridian = [quarter_arc((0.0, 0.0), radius, start) for start in (-90.0, 0.0)]
    return tessellated(turned_sheets(meridian), pieces, pieces)


def turned_patches(meridian, around=8, along=4):
    """The body of revolution of a meridian in the form that `Revolved` takes."""
    return tessellated(turned_sheets(meridian), around, along)


def pebble_patches(around=20, along=10, seed=4):
    """A closed free-form rational bicubic: six patches around, smooth over their joints and at two poles."""
    rng = np.random.default_rng(seed)
    heights = np.array([-12.0, -12.0, 12.0, 12.0])
    angles = np.arange(6) * np.pi / 3.0
    net = np.empty((6, 4, 4))
    for row, height in enumerate(heights):
        spread = 0.0 if row in (0, 3) else 1.0
        radius = spread * rng.uniform(20.0, 32.0, 6)
        net[:, row, 0] = radius * np.cos(angles) + 1.0
        net[:, row, 1] = radius * np.sin(angles) - 2.0
        net[:, row, 2] = height
        net[:, row, 3] = rng.uniform(0.7, 1.4, 6)
    net[:, :, :3] *= net[:, :, 3:]
    q0, q1, q2, q3 = (np.roll(net, -k, axis=0) for k in range(4))
    bezier = np.stack([(q0 + 4 * q1 + q2) / 6, (2 * q1 + q2) / 3, (q1 + 2 * q2) / 3, (q1 + 4 * q2 + q3) / 6], axis=1)
    # The poles stay one point each: their rows differ in weight only.
    sheet = Sheet(bezier[:, None], u_knots=np.arange(7.0), v_knots=(0.0, 1.0))
    return tessellated([sheet], around, along)


def tessellated(sheets, around, along):
    """Patches whose mesh has around x along cells of two triangles on each sheet, in the sheets' parameters."""
    points, uvs, triangles, numbers, count = [], [], [], [], 0
    for number, sheet in enumerate(sheets):
        u = np.linspace(sheet.u_knots[0], sheet.u_knots[-1], around + 1)
        v = np.linspace(sheet.v_knots[0], sheet.v_knots[-1], along + 1)
        uv = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
        a = (np.arange(around)[:, None] * (along + 1) + np.arange(along)).ravel()
        b, c, d = a + along + 1, a + along + 2, a + 1
        corners = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
        points.append(sheet.evaluate(uv)[0])
        uvs.append(uv)
        triangles.append(corners + count)
        numbers.append(np.full(len(corners), number))
        count += len(uv)
    points, uvs, triangles = np.concatenate(points), np.concatenate(uvs), np.concatenate(triangles)
    _, first, place = np.unique(np.round(points, WELD_DECIMALS) + 0.0, axis=0, return_index=True, return_inverse=True)
    corners = place.reshape(-1)[triangles]
    kept = np.all(corners != np.roll(corners, 1, axis=1), axis=1)
    mesh = Mesh(points[first], corners[kept])
    return Patches(sheets, mesh, np.concatenate(numbers)[kept], uvs[triangles[kept]])
