"""Scenes on which the certificate is held against the truth, as different as glass gets; small images."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

import peers  # noqa: E402
import tracer_scenes  # noqa: E402

import glassworkbench as gw  # noqa: E402
from glassworkbench.scene import Body, Ellipsoid, Environment, Medium, Panel, Pinhole, Revolved, Scene  # noqa: E402
from glassworkbench.staging.sample import sample_container  # noqa: E402

SIZE = (72, 96)
FLINT, WATER = (1.52338, (0.0008, 0.0004, 0.0007)), (1.333, (0.0002, 0.0, 0.0))
CLEAR, GREEN = (1.52338, (0.0, 0.0, 0.0)), (1.52, (0.25, 0.06, 0.3))
"""Refractive indices and absorption per mm: the truths that are kept must not change with the catalogue."""


def example(name, wall="3"):
    return gw.hollow(gw.read_mold(ROOT / "examples" / "molds" / f"{name}.step"), wall).geometry()


def staged(station, geometry, *media, fill=None):
    scene = gw.station(station, geometry, gw.find_glass("flint"), fill=fill, size=SIZE)
    fixed = [Medium(medium.where, *numbers) for medium, numbers in zip(scene.media, media, strict=True)]
    return replace(scene, media=tuple(fixed))


def clear_tumbler():
    return staged("sidewall", sample_container(), CLEAR)


def filled_bottle():
    return staged("sidewall", example("wine_bottle"), FLINT, WATER, fill="water:180")


def flask_of_patches():
    return staged("studio", example("whisky_flask"), FLINT)


def dark_green_bottle():
    return staged("studio", example("wine_bottle"), GREEN)


def box_and_ball_of_triangles():
    camera = Pinhole((60.0, -300.0, 90.0), (0.0, 0.0, 0.0), 0.38)
    return replace(tracer_scenes.meshes(), camera=camera, size=SIZE)


def bubbles():
    """A paperweight with seeds and blisters from 0.1 to 6 mm before a panel with a lit surrounding."""
    rng = np.random.default_rng(8)
    outline = [
        tracer_scenes.line((0.0, -10.0), (30.0, -10.0)),
        tracer_scenes.line((30.0, -10.0), (30.0, 0.0)),
        tracer_scenes.arc((0.0, 0.0), 30.0, 0.0, 90.0),
    ]
    shapes = [Body("weight", Revolved(np.array(outline)))]
    for k, size in enumerate(np.geomspace(0.1, 6.0, 12)):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        centre = (14.0 * np.cos(2.4 * k), 14.0 * np.sin(2.4 * k), rng.uniform(-3.0, 14.0))
        shapes.append(Body(f"bubble_{k}", Ellipsoid(centre, size * rng.uniform(0.3, 1.0, 3), turn)))
    glass = Medium(" and not ".join(body.name for body in shapes), 1.52, (0.002, 0.001, 0.002))
    panel = Panel((-60.0, 60.0, -60.0), (120.0, 0.0, 0.0), (0.0, 0.0, 120.0), 1.0)
    camera = Pinhole((0.0, -400.0, 60.0), (0.0, 0.0, 12.0), 0.2)
    return Scene(shapes, (glass,), (panel, Environment((0.1, 0.12, 0.15))), camera, SIZE)


def panel_edge():
    """A block with a cylinder of air lying in it, before a panel whose edge lies level across the image."""
    air = tracer_scenes.cylinder(12.0, -60.0, 60.0, axis=(1.0, 0.0, 0.0))
    block = Body("block", tracer_scenes.box_mesh((-25.0, -20.0, -35.0), (25.0, 20.0, 35.0)))
    panel = Panel((-200.0, 90.0, 5.3), (400.0, 0.0, 0.0), (0.0, 0.0, 200.0), (1.0, 0.9, 0.8))
    camera = Pinhole((0.0, -500.0, 0.0), (0.0, 0.0, 0.0), 0.17)
    return Scene((block, Body("air", air)), (Medium("block and not air", 1.6),), (panel,), camera, SIZE)


SCENES = {
    "bottle before a panel": lambda: replace(peers.scene("panel"), size=SIZE),
    "bottle among soft boxes": lambda: replace(peers.scene("environment"), size=SIZE),
    "clear tumbler": clear_tumbler,
    "filled bottle": filled_bottle,
    "flask of patches": flask_of_patches,
    "triangles": box_and_ball_of_triangles,
    "bubbles": bubbles,
    "dark green bottle": dark_green_bottle,
    "panel's level edge": panel_edge,
}
