"""The inside as a level set: against closed forms, where faces vanish and walls merge, and CAD against mesh."""

import json
from pathlib import Path

import numpy as np
import pytest
from mesh_checks import crossings, euler_characteristic, share_across_creases
from meshed_molds import as_mesh, ball_bottomed, cells_mesh, mesh_mold, uniform

from glassworkbench.cli import main
from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import mold_from_shape, read_mold, tessellate
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.levels.faceted import faceted_solid, fewer_facets
from glassworkbench.wall.measuring.measure import measure_wall
from glassworkbench.wall.measuring.outside import outside
from glassworkbench.wall.measuring.volumes import mesh_volume
from glassworkbench.wall.methods.inner_mesh import cavity_mesh, inner_mesh

EXAMPLES = Path(__file__).resolve().parent.parent / "examples" / "molds"


def hollowed(mold, thickness, step=2.0):
    """The cavity's mesh, its notes, and the outside it keeps its distance from."""
    at = uniform(thickness)
    wall = outside(mold, at)
    mesh, notes = cavity_mesh(mold, AskedThickness(at, thickness, thickness), wall, step, 0.01 * thickness)
    return mesh, notes, wall


def off_the_wall(mesh, wall, samples=3000):
    """|clearance| and distance of points spread over the mesh by area, its lid left out."""
    random = np.random.default_rng(5)
    corners = mesh.vertices_mm[mesh.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    points = np.einsum(
        "ij,ijk->ik",
        random.dirichlet([1.0, 1.0, 1.0], samples),
        corners[random.choice(len(area), samples, p=area / area.sum())],
    )
    points = points[points[:, 2] < wall.finish_height_mm - 1e-6]
    return np.abs(wall.clearance(points).clearance_mm), wall.distance(points).distance_mm


def test_a_ball_bottomed_cylinder_keeps_its_shape():
    mesh, notes, _ = hollowed(mesh_mold(ball_bottomed(20.0, 50.0)), 3.0)
    r, z = np.hypot(*mesh.vertices_mm[:, :2].T), mesh.vertices_mm[:, 2]
    side, lid = (z > 20.0) & (z < 50.0), z == 50.0
    assert np.abs(np.hypot(r, z - 20.0)[z < 20.0] - 17.0).max() < 5e-3
    assert np.abs(r[side] - 17.0).max() < 5e-3
    assert lid.any()
    assert z.max() == 50.0
    expected = np.pi * 17.0**2 * 30.0 + 2.0 / 3.0 * np.pi * 17.0**3
    assert mesh_volume(mesh).volume_mm3 == pytest.approx(expected, rel=1e-3)
    assert euler_characteristic(mesh) == 2
    assert not notes


def test_a_box_keeps_sharp_edges_and_corners():
    mesh, _, _ = hollowed(mesh_mold(cells_mesh([-20, 20], [-15, 15], [0, 60], [[[1]]])), 5.0, step=3.0)
    assert mesh_volume(mesh).volume_mm3 == pytest.approx(30 * 20 * 55, rel=1e-3)
    for corner in ([15, 10, 5], [-15, -10, 5], [15, -10, 60]):
        assert np.linalg.norm(mesh.vertices_mm - corner, axis=1).min() < 1e-3
    assert euler_characteristic(mesh) == 2
    assert crossings(mesh) == 0
    # A few triangles cross a crease bluntly, as the tolerance allows.
    assert share_across_creases(mesh) < 0.01


def test_a_pit_narrower_than_the_grid_does_not_thin_the_wall():
    """Each pushes a cap into the cavity that lies between the vertices of a grid as wide."""
    pitted = Part.makeCylinder(20, 40)
    for k in range(8):
        pit = Part.makeCylinder(0.1, 5, FreeCAD.Vector(19.8, 0, 10 + 2.3 * k), FreeCAD.Vector(1, 0, 0))
        pit.rotate(FreeCAD.Vector(), FreeCAD.Vector(0, 0, 1), 47.0 * k)
        pitted = pitted.cut(pit)
    mesh, _, wall = hollowed(mold_from_shape(pitted, "can", up=(0, 0, 1)), 2.0, step=1.8)
    assert measure_wall(mesh, wall).thinner_than_asked_max < 0.03
    assert crossings(mesh) == 0


@pytest.mark.parametrize(("thickness", "floor"), [(4.0, 4.0), (11.0, 10.0 + np.sqrt(11.0**2 - 10.0**2))])
def test_the_bottom_of_a_step_vanishes_when_the_wall_is_thick(thickness, floor):
    """Between side walls 20 mm apart the foot is solid; the floor then rests on circles about the step's edges."""
    full = np.zeros((3, 1, 2), dtype=bool)
    full[1], full[:, :, 1] = True, True
    mesh, _, wall = hollowed(mesh_mold(cells_mesh([-20, -10, 10, 20], [-30, 30], [0, 10, 60], full)), thickness)
    # Where the two circles meet, the cavity ends in a groove narrower than the grid, which is not followed to its end.
    lowest = mesh.vertices_mm[:, 2].min()
    assert floor - 1e-3 < lowest < floor + (1.0 if thickness > 10.0 else 1e-3)
    off, distance = off_the_wall(mesh, wall)
    assert np.percentile(off, 99) < 0.02 * thickness
    assert distance.min() > 0.95 * thickness
    assert euler_characteristic(mesh) == 2
    assert crossings(mesh) == 0


@pytest.mark.parametrize(("thickness", "reaches"), [(2.0, 38.0), (3.0, 10.0 - np.sqrt(3.0**2 - 2.5**2))])
def test_a_thin_web_between_two_boxes_is_hollow_or_solid(thickness, reaches):
    """Where the web stays solid, its end still lets the cavity reach a little into it, to a circle's depth."""
    full = np.zeros((3, 3, 2), dtype=bool)
    full[0], full[1, 1, 0], full[2, :, 0] = True, True, True
    xs, ys, zs = [-10, 10, 20, 40], [-10, -2.5, 2.5, 10], [0, 20, 40]
    mesh, notes, wall = hollowed(mesh_mold(cells_mesh(xs, ys, zs, full)), thickness, step=0.7)
    assert mesh.vertices_mm[:, 0].max() == pytest.approx(reaches, abs=0.15)
    assert bool(notes) == (thickness > 2.5)
    off, distance = off_the_wall(mesh, wall)
    assert np.percentile(off, 99) < 0.02 * thickness
    assert distance.min() > 0.95 * thickness
    assert euler_characteristic(mesh) == 2


def test_a_wall_without_room_is_refused_with_place_and_remedy():
    mold = mesh_mold(cells_mesh([-20, -8, 8, 20], [-20, -8, 8, 20], [0, 50, 90], _bottle()))
    with pytest.raises(InputError, match=r"10 mm fills the container at height [5-8]\d\.\d mm, .* 8\.0\d mm fits"):
        hollowed(mold, 10.0)
    with pytest.raises(InputError, match="fills the container"):
        hollowed(mold, 30.0)


def _bottle():
    full = np.zeros((3, 3, 2), dtype=bool)
    full[:, :, 0], full[1, 1, 1] = True, True
    return full


@pytest.fixture(scope="module")
def flacon():
    mold = read_mold(EXAMPLES / "perfume_flacon.step")
    return mold, *hollowed(mold, 2.0, step=2.2)


def test_a_flask_as_mesh_gets_the_inside_of_the_flask_as_cad(flacon):
    mold, inside, _, wall = flacon
    of_mesh, _, _ = hollowed(as_mesh(mold, tessellate(mold.upright, 0.05)), 2.0, step=2.2)
    off, distance = off_the_wall(of_mesh, wall)
    assert np.percentile(off, 99) < 0.04
    assert distance.min() > 0.95 * 2.0
    assert mesh_volume(of_mesh).volume_mm3 == pytest.approx(mesh_volume(inside).volume_mm3, rel=1e-3)
    assert euler_characteristic(of_mesh) == euler_characteristic(inside) == 2


def test_a_solid_is_sewn_of_the_outside_and_fewer_facets(flacon):
    mold, inside, _, wall = flacon
    points, triangles = fewer_facets(inside, wall.finish_height_mm, 1500)
    assert len(triangles) <= 1500
    (solid,) = faceted_solid(mold.upright, mold.anatomy.finish_face, points.tolist(), triangles.tolist())
    assert solid.isValid()
    glass = mesh_volume(tessellate(mold.upright, 0.05)).volume_mm3 - mesh_volume(inside).volume_mm3
    assert mesh_volume(tessellate(solid, 0.05)).volume_mm3 == pytest.approx(glass, rel=2e-2)


def test_the_tracers_cavity_reaches_past_the_mouth_and_a_mesh_has_no_solid():
    mold = mesh_mold(cells_mesh([-20, 20], [-15, 15], [0, 60], [[[1]]]))
    at = uniform(5.0)
    made = inner_mesh(mold, AskedThickness(at, 5.0, 5.0), outside(mold, at), 2.0)
    assert made.inside.vertices_mm[:, 2].max() == 60.0
    assert made.cavity.vertices_mm[:, 2].max() == 65.0
    assert mesh_volume(made.cavity).volume_mm3 == pytest.approx(30 * 20 * 60, rel=1e-3)
    assert euler_characteristic(made.cavity) == 2
    assert made.solid is None
    assert "STL only" in made.notes[-1]
    assert made.facets_off_mm == 0.0


def test_a_note_says_how_far_flat_facets_may_be_off(tmp_path, capsys):
    path, out, told = (str(tmp_path / name) for name in ("can.brep", "out.brep", "report.json"))
    Part.makeCylinder(20, 50).exportBrep(path)
    assert main(["hollow", path, "--wall", "3", "--method", "inner_mesh", "-o", out, "--report", told]) == 0
    off = json.loads(Path(told).read_text())["solid"]["facets_off_mm"]
    # A chord of the round inside, and no worse than the corner of the floor lets it be.
    assert 1e-4 < off < 0.5
    assert f"flat facets, up to {off:.2g} mm off" in capsys.readouterr().err


def test_too_little_time_is_told_before_any_is_spent():
    mold = mesh_mold(cells_mesh([-20, 20], [-15, 15], [0, 60], [[[1]]]))
    at = uniform(0.2)
    with pytest.raises(GlassWorkbenchError, match="needs a grid that takes about"):
        inner_mesh(mold, AskedThickness(at, 0.2, 0.2), outside(mold, at), 1e-3)
