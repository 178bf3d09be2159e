"""The whole path of one ray through a scene, from where it starts to the light that it ends at, as a polyline."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from glassworkbench.scene import Body, Ellipsoid, Medium, Panel, Scene
from glassworkbench.scene.validate import finite_array, unit_vector
from glassworkbench.tracer import native, reference
from glassworkbench.tracer.extent import box_mm
from glassworkbench.tracer.result import Crossing

ROOM = 2.0
"""The path is shown out to so many times the farthest that anything lies from the middle of the bodies."""


@dataclass(frozen=True, eq=False)
class RayPath:
    """A ray's path: refracted at every interface, reflected where reflection is total.

    Parameters
    ----------
    points_mm : array (n, 3)
        Where it starts, its interfaces, and where it ends.
    crossings : tuple of Crossing
        The n - 2 interfaces.
    panel : int or None
        Which of the scene's lights it ends at; None where it leaves the scene.
    """

    points_mm: np.ndarray
    crossings: tuple[Crossing, ...]
    panel: int | None

    def is_reflected(self) -> np.ndarray:
        """Tell of each leg (n - 1,) whether it begins with a total reflection."""
        return np.array([False, *(crossing.reflectance >= 1.0 for crossing in self.crossings)])


def ray_path(scene: Scene, origin: np.ndarray, direction: np.ndarray) -> RayPath:
    """Return the path of one ray.

    Parameters
    ----------
    scene : Scene
    origin, direction : array (3,)
        In mm; the direction of any length above 0.

    Raises
    ------
    InputError
        If a number is not finite, the direction has no length, or the scene has as many bodies as it may: one more
        is put around it to see where the path leaves.
    """
    origin, direction = finite_array(origin, (3,), "origin"), unit_vector(direction, "direction")
    low, high = box_mm(scene) if scene.bodies else (origin, origin)
    middle = 0.5 * (low + high)
    panels = [light for light in scene.lights if isinstance(light, Panel)]
    corners = [panel.origin_mm + i * panel.u_mm + j * panel.v_mm for panel in panels for i in (0, 1) for j in (0, 1)]
    reach = ROOM * max(1.0, *(np.linalg.norm(point - middle) for point in (low, origin, *corners)))
    name = "around" + "_" * max((len(body.name) for body in scene.bodies), default=0)
    # Air inside a sphere around all: its other number makes leaving it an interface.
    around = replace(
        scene,
        bodies=(*scene.bodies, Body(name, Ellipsoid(middle, (reach,) * 3))),
        media=(*scene.media, Medium(name, 1.0)),
        lights=(),
    )
    follow = native.follow if native.available() else reference.follow
    crossings = follow(around, origin, direction)
    points, panel = [origin], None
    inner = []
    for crossing in crossings:
        panel, point = _first_panel(scene, points[-1], crossing.point_mm)
        points.append(point)
        if panel is not None or crossing.body == name:
            break
        inner.append(_in_scene(crossing, len(around.media)))
    return RayPath(np.array(points), tuple(inner), panel)


def _in_scene(crossing: Crossing, around: int) -> Crossing:
    """Return a crossing in which the air inside the sphere is air again."""
    before, after = (0 if medium == around else medium for medium in (crossing.medium_before, crossing.medium_after))
    return replace(crossing, medium_before=before, medium_after=after)


def _first_panel(scene: Scene, start: np.ndarray, end: np.ndarray) -> tuple[int | None, np.ndarray]:
    """Return the first panel between two points, as its number among the lights, and where; else None and the end."""
    first, number = 1.0, None
    for k, light in enumerate(scene.lights):
        if not isinstance(light, Panel):
            continue
        # start + t (end - start) = origin + u s + v r
        matrix = np.column_stack([start - end, light.u_mm, light.v_mm])
        if abs(np.linalg.det(matrix)) == 0.0:
            continue
        t, u, v = np.linalg.solve(matrix, start - light.origin_mm)
        if 0.0 < t < first and 0.0 <= u <= 1.0 and 0.0 <= v <= 1.0:
            first, number = t, k
    return number, start + first * (end - start)
