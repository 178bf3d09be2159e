"""An outside minus another body: a round inside in anything, and bodies that are given."""

import re
from pathlib import Path

import numpy as np
import pytest
from mesh_checks import euler_characteristic
from meshed_molds import as_mesh, ball_bottomed, cells_mesh, mesh_mold, uniform

from glassworkbench.errors import InputError
from glassworkbench.mold import read_mold, tessellate
from glassworkbench.mold.mesh_mold import mold_from_mesh
from glassworkbench.scene import ContainerGeometry, Ellipsoid, Revolved
from glassworkbench.wall import HollowingError, hollow
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.measuring.outside import outside
from glassworkbench.wall.measuring.volumes import mesh_volume
from glassworkbench.wall.methods.csg import csg, csg_with
from glassworkbench.wall.turning.bezier import line

EXAMPLES = Path(__file__).resolve().parent.parent / "examples" / "molds"


def made(mold, thickness):
    at = uniform(thickness)
    wall = outside(mold, at)
    return csg(mold, AskedThickness(at, thickness, thickness), wall, 10.0), wall


def box():
    return mesh_mold(cells_mesh([-20, 20], [-20, 20], [0, 60], [[[1]]]), "box")


def test_a_bottle_as_mesh_gets_a_revolved_inside_with_the_wall_asked():
    bottle = read_mold(EXAMPLES / "beer_bottle.step")
    mold = as_mesh(bottle, tessellate(bottle.upright, 0.1))
    candidate, wall = made(mold, 3.0)
    assert isinstance(candidate.cavity, Revolved)
    points = candidate.inside.vertices_mm
    below = points[points[:, 2] < wall.finish_height_mm - 1e-6]
    off = np.abs(wall.clearance(below).clearance_mm)
    assert np.percentile(off, 99) < 0.06
    assert wall.distance(below).distance_mm.min() > 0.95 * 3.0
    low, high = mold.mesh.vertices_mm.min(axis=0), mold.mesh.vertices_mm.max(axis=0)
    ContainerGeometry(mold.mesh, candidate.cavity, low, high, wall.finish_height_mm)


def test_a_mesh_too_coarse_for_a_round_inside_is_refused_with_its_departure_and_what_to_do():
    coarse = ball_bottomed(20.0, 50.0, around=12, rows=6)
    mold = mold_from_mesh(coarse.vertices_mm, coarse.triangles, "coarse", up=(0, 0, 1))
    told = rf"departs from that by up to {mold.anatomy.departure_mm:.2g} mm.*give a finer mesh or the CAD solid"
    with pytest.raises(HollowingError, match=told):
        hollow(mold, 3, method="csg")


def test_in_a_box_the_round_inside_is_the_cylinder_that_fits():
    candidate, _ = made(box(), 5.0)
    assert mesh_volume(candidate.inside).volume_mm3 == pytest.approx(np.pi * 15.0**2 * 55.0, rel=2e-3)
    assert candidate.inside.vertices_mm[:, 2].min() == pytest.approx(5.0, abs=1e-5)
    assert euler_characteristic(candidate.inside) == 2
    assert "STEP" in candidate.notes[-1]


def test_how_much_thicker_the_wall_of_a_round_inside_is_in_a_box_is_told():
    candidate, wall = made(box(), 5.0)
    corner = np.array([[15.0 * np.sqrt(0.5), 15.0 * np.sqrt(0.5), 30.0]])
    excess = float(wall.clearance(corner).clearance_mm[0])
    assert excess == pytest.approx(20.0 - 15.0 * np.sqrt(0.5) - 5.0)
    told = re.search(r"up to ([\d.]+) mm thicker", candidate.notes[0])
    assert float(told[1]) == pytest.approx(excess, rel=0.03)


def test_a_wall_that_fills_the_mouth_is_refused():
    with pytest.raises(InputError, match=r"where less than 20\.0"):
        made(box(), 21.0)


def test_a_mesh_that_reaches_past_the_mouth_is_cut_level_for_measuring():
    given = cells_mesh([-10, 12], [-9, 9], [6, 80], [[[1]]])
    candidate = csg_with(box(), given)
    assert candidate.cavity is given
    assert candidate.inside.vertices_mm[:, 2].max() == 60.0
    assert mesh_volume(candidate.inside).volume_mm3 == pytest.approx(22 * 18 * 54)
    assert euler_characteristic(candidate.inside) == 2


def test_a_mesh_that_ends_in_the_finish_plane_is_continued_past_it():
    candidate = csg_with(box(), cells_mesh([-10, 12], [-9, 9], [6, 60], [[[1]]]))
    assert candidate.cavity.vertices_mm[:, 2].max() == 65.0
    assert mesh_volume(candidate.inside).volume_mm3 == pytest.approx(22 * 18 * 54)


def test_a_revolved_body_is_taken_away_as_it_is():
    cylinder = np.array([line((0, 8), (10, 8)), line((10, 8), (10, 70)), line((10, 70), (0, 70))])
    candidate = csg_with(box(), Revolved(cylinder))
    assert isinstance(candidate.cavity, Revolved)
    assert mesh_volume(candidate.inside).volume_mm3 == pytest.approx(np.pi * 100 * 52, rel=3e-3)


def test_bodies_that_cannot_be_the_cavity_are_refused():
    with pytest.raises(InputError, match="below the mouth"):
        csg_with(box(), cells_mesh([-10, 10], [-9, 9], [6, 50], [[[1]]]))
    with pytest.raises(InputError, match="reaches out of box"):
        csg_with(box(), cells_mesh([-10, 10], [-9, 9], [-6, 80], [[[1]]]))
    with pytest.raises(InputError, match="a mesh or a body of revolution"):
        csg_with(box(), Ellipsoid(np.array([0.0, 0.0, 50.0]), np.array([5.0, 5.0, 30.0])))
