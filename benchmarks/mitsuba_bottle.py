"""Renders the peers' bottle with Mitsuba 3 in its own Python: a path tracer with analytic absorption, no roulette.

Called by peers.py: mitsuba_bottle.py KIND FOLDER SAMPLES...; writes FOLDER/mitsuba_KIND_SAMPLES.npy and prints a line
of JSON for each.
"""

import json
import sys
import time
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np
import peers_scene as peers

mi.set_variant("llvm_ad_rgb")
ROWS, SECTORS, DEPTH = 12, 514, 32
"""Rows of triangles in a meridian segment and sectors around: a million triangles; the longest path."""


class AbsorbingPath(mi.SamplingIntegrator):
    """Follows one path from dielectric to dielectric, weakened by exp(-absorbance) inside."""

    def sample(self, scene, sampler, ray, medium=None, active=True):
        """Return what a ray sees, as Mitsuba asks its integrators."""
        context = mi.BSDFContext()
        absorption = mi.Color3f(*peers.ABSORPTION_PER_MM)

        @dr.syntax
        def walk(ray, depth, seen, weight, active, sampler, scene, context, absorption):
            while active:
                met = scene.ray_intersect(ray, active)
                is_glass = met.is_valid() & (met.shape.emitter() == None)  # noqa: E711
                is_inside = dr.dot(met.n, ray.d) > 0
                weight = dr.select(is_glass & is_inside, weight * dr.exp(-absorption * met.t), weight)
                seen += dr.select(active, weight * met.emitter(scene).eval(met, active), 0.0)
                active = active & is_glass & (depth < DEPTH)
                way, factor = met.bsdf().sample(context, met, sampler.next_1d(active), sampler.next_2d(active), active)
                ray = met.spawn_ray(met.to_world(way.wo))
                weight = dr.select(active, weight * factor, weight)
                active &= dr.max(weight) != 0
                depth += 1
            return seen, depth

        start = (mi.Ray3f(ray), mi.UInt32(0), mi.Spectrum(0.0), mi.Spectrum(1.0), mi.Bool(active))
        seen, depth = walk(*start, sampler, scene, context, absorption)
        return seen, depth > 0, []


mi.register_integrator("absorbing_path", lambda properties: AbsorbingPath(properties))


def write_mesh(path):
    """Write the bottle as a mesh with the meridian's own normals."""
    segments = peers.meridian()
    t = (np.arange(ROWS) / ROWS)[:, None]
    ends = np.ones((1, 1))
    points, tangents = [], []
    for k, segment in enumerate(segments):
        at = t if k + 1 < len(segments) else np.concatenate([t, ends])
        values = np.concatenate([(1 - at) ** 3, 3 * at * (1 - at) ** 2, 3 * at**2 * (1 - at), at**3], axis=1)
        slopes = np.concatenate([(1 - at) ** 2, 2 * at * (1 - at), at**2], axis=1)
        points.append(values @ segment)
        tangents.append(slopes @ np.diff(segment, axis=0))
    points, tangents = np.concatenate(points), np.concatenate(tangents)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    angle = 2.0 * np.pi * np.arange(SECTORS) / SECTORS
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(SECTORS)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    vertices = (points[:, 0, None, None] * ring + points[:, 1, None, None] * up).reshape(-1, 3)
    normals = (tangents[:, 1, None, None] * ring - tangents[:, 0, None, None] * up).reshape(-1, 3)
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(len(points) - 1), np.arange(SECTORS), indexing="ij"))
    k = (j + 1) % SECTORS
    a, b, c, d = i * SECTORS + j, i * SECTORS + k, (i + 1) * SECTORS + k, (i + 1) * SECTORS + j
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    corners = vertices[faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    faces = faces[area > 1e-12]
    mesh = mi.Mesh("bottle", len(vertices), len(faces), has_vertex_normals=True)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = vertices.astype(np.float32).ravel()
    parameters["vertex_normals"] = normals.astype(np.float32).ravel()
    parameters["faces"] = faces.astype(np.uint32).ravel()
    parameters.update()
    mesh.write_ply(str(path))


def light(kind):
    """Return the panel, or the sky as Mitsuba turns it: its maps have y up."""
    transform = mi.ScalarTransform4f()
    if kind == "panel":
        origin, u, v = (np.array(edge) for edge in peers.PANEL)
        turned = transform.translate(list(origin + 0.5 * (u + v))) @ transform.rotate((1, 0, 0), 90)
        return {
            "type": "rectangle",
            "to_world": turned @ transform.scale((0.5 * np.linalg.norm(u), 0.5 * np.linalg.norm(v), 1.0)),
            "bsdf": {"type": "twosided", "black": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}},
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}},
        }
    height, width = peers.MAP_SIZE
    polar = ((np.arange(height) + 0.5) / height * np.pi)[:, None]
    azimuth = (np.arange(width) + 0.5) / width * 2.0 * np.pi
    flat = np.sin(polar)
    across, along = np.sin(azimuth) * flat, np.cos(azimuth) * flat
    directions = np.stack([across, along, np.broadcast_to(np.cos(polar), across.shape)], axis=2)
    image = peers.sky(directions).astype(np.float32)
    return {"type": "envmap", "bitmap": mi.Bitmap(image), "to_world": transform.rotate((1, 0, 0), 90)}


def main(kind, folder, counts):
    """Render and time."""
    write_mesh(folder / "bottle.ply")
    origin, target = peers.CAMERAS[kind]
    film = {"type": "hdrfilm", "width": peers.WIDTH, "height": peers.HEIGHT, "rfilter": {"type": "box"}}
    scene = mi.load_dict(
        {
            "type": "scene",
            "bottle": {
                "type": "ply",
                "filename": str(folder / "bottle.ply"),
                "bsdf": {"type": "dielectric", "int_ior": peers.REFRACTIVE_INDEX, "ext_ior": 1.0},
            },
            "light": light(kind),
            "sensor": {
                "type": "perspective",
                "fov": float(np.degrees(peers.FIELD_OF_VIEW_RAD)),
                "fov_axis": "y",
                "to_world": mi.ScalarTransform4f().look_at(origin=origin, target=target, up=(0, 0, 1)),
                "film": {**film, "pixel_format": "rgb", "component_format": "float32"},
                "sampler": {"type": "multijitter", "sample_count": 16},
            },
            "integrator": {"type": "absorbing_path"},
        }
    )
    np.array(mi.render(scene, spp=1, seed=99))
    for count in counts:
        started = time.process_time()
        image = np.array(mi.render(scene, spp=count, seed=count))
        seconds = time.process_time() - started
        np.save(folder / f"mitsuba_{kind}_{count}.npy", image)
        print(json.dumps({"samples": count, "cpu_seconds": seconds}), flush=True)


main(sys.argv[1], Path(sys.argv[2]), [int(count) for count in sys.argv[3:]])
