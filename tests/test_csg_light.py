"""Light through containers without a solid of their own: the same as through the solid that they stand for."""

import json
from itertools import pairwise

import numpy as np
import pytest

from glassworkbench.cli import main
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.images import read_image
from glassworkbench.mold import exact_surface, tessellate
from glassworkbench.scene import ContainerGeometry, Revolved
from glassworkbench.staging import station
from glassworkbench.tracer import native, render
from glassworkbench.wall.turning.bezier import line

pytestmark = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")

HEIGHT, MOUTH = 50.0, 60.0
OUTER = ((0.0, 0.0), (16.0, 0.0), (22.0, 8.0), (22.0, HEIGHT), (0.0, HEIGHT))
"""The corners of a tumbler's outside, turned about z; the inside below reaches past the mouth."""
INNER = ((0.0, 5.0), (13.0, 5.0), (19.0, 12.0), (19.0, MOUTH), (0.0, MOUTH))
NECKED = ((0.0, 0.0), (22.0, 0.0), (22.0, 35.0), (14.0, 42.0), (14.0, HEIGHT), (0.0, HEIGHT))
SIZE = 24, 32


def revolved(corners):
    return Revolved(np.array([line(np.array(a), np.array(b)) for a, b in pairwise(corners)]))


def turned_solid(corners):
    points = [FreeCAD.Vector(r, 0.0, z) for r, z in corners]
    face = Part.Face(Part.makePolygon([*points, points[0]]))
    return face.revolve(FreeCAD.Vector(0, 0, 0), FreeCAD.Vector(0, 0, 1), 360.0)


def seen(outer, cavity):
    geometry = ContainerGeometry(outer, cavity, (-22.0, -22.0, 0.0), (22.0, 22.0, HEIGHT), HEIGHT)
    return station("studio", geometry, "emerald", size=SIZE)


@pytest.fixture(scope="module")
def solid_image():
    """The image of the solid alone, outside and inside one surface of patches."""
    solid = turned_solid(OUTER).cut(turned_solid(INNER))
    assert len(solid.Solids) == 1
    return render(seen(exact_surface(solid), None), tolerance=0.02)


def outer_mesh():
    return tessellate(turned_solid(OUTER), 0.01)


def inner_mesh():
    return tessellate(turned_solid(INNER), 0.01)


PAIRS = {
    "revolved minus revolved": lambda: (revolved(OUTER), revolved(INNER)),
    "mesh minus revolved": lambda: (outer_mesh(), revolved(INNER)),
    "patches minus mesh": lambda: (exact_surface(turned_solid(OUTER)), inner_mesh()),
    "patches minus revolved": lambda: (exact_surface(turned_solid(OUTER)), revolved(INNER)),
    "mesh minus mesh": lambda: (outer_mesh(), inner_mesh()),
}


@pytest.mark.parametrize("pair", PAIRS)
def test_an_outside_minus_a_body_looks_like_the_solid(solid_image, pair):
    image = render(seen(*PAIRS[pair]()), tolerance=0.02)
    assert image.report["leaks"] == solid_image.report["leaks"] == 0
    difference = np.abs(image.pixels - solid_image.pixels).max(axis=2)
    assert np.mean(difference <= image.certificate + solid_image.certificate) >= 0.99
    assert difference.mean() < 0.01
    hit = np.isfinite(solid_image.depth_mm)
    assert np.mean(hit == np.isfinite(image.depth_mm)) > 0.995
    both = hit & np.isfinite(image.depth_mm)
    assert np.percentile(np.abs(image.depth_mm[both] - solid_image.depth_mm[both]), 99) < 0.05


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A mold as STEP and as STL, and the container that `hollow` makes of it, as STEP."""
    folder = tmp_path_factory.mktemp("csg")
    mold = turned_solid(NECKED)
    mold.exportStep(str(folder / "mold.step"))
    mold.copy().exportStl(str(folder / "mold.stl"), 0.01)
    command = ["--quiet", "hollow", str(folder / "mold.step"), "--wall", "3", "--method", "revolved"]
    assert main([*command, "-o", str(folder / "container.step")]) == 0
    return folder


def rendered(*arguments, folder, name):
    output, report = folder / f"{name}.exr", folder / f"{name}.json"
    command = [
        "--quiet",
        "render",
        *map(str, arguments),
        "--size",
        "24x32",
        "--glass",
        "emerald",
        "--tolerance",
        "0.05",
    ]
    assert main([*command, "-o", str(output), "--report", str(report)]) == 0
    return read_image(output), json.loads(report.read_text())


@pytest.mark.parametrize("ending", ["step", "stl"])
def test_a_csg_container_is_rendered_from_the_command_line(files, ending):
    solid, _ = rendered(files / "container.step", folder=files, name="solid")
    mold = files / f"mold.{ending}"
    image, report = rendered(mold, "--wall", "3", "--method", "csg", folder=files, name=f"csg_{ending}")
    assert report["leaks"] == 0
    difference = np.abs(image.pixels - solid.pixels).max(axis=2)
    # Each method has its own meridian of the inside, some micrometres from the other's.
    assert np.mean(difference <= image.certificate + solid.certificate + 0.01) >= 0.97
    assert difference.mean() < 0.02
