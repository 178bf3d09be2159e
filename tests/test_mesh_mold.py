"""Meshes are molds: they stand as the solid does, are mended where a sentence says so, and refused with the place."""

from pathlib import Path

import numpy as np
import pytest

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import outside_mesh, read_mold
from glassworkbench.mold.measures import signed_volume
from glassworkbench.mold.mesh_mold import mold_from_mesh

MOLDS = Path(__file__).resolve().parent.parent / "examples" / "molds"
TURN = FreeCAD.Placement(FreeCAD.Vector(3, 4, 5), FreeCAD.Rotation(FreeCAD.Vector(1, 2, 0.3), 40))


def triangles_of(solid, deviation_mm=0.1):
    """Return the triangles (m, 3, 3) of a solid, each with its own corners as an STL has them."""
    vertices, triangles = solid.tessellate(deviation_mm)
    return np.array([tuple(vertex) for vertex in vertices])[np.array(triangles)]


def write_stl(path, corners):
    facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    facets = np.zeros(len(corners), facet)
    facets["corners"] = corners
    path.write_bytes(bytes(80) + len(corners).to_bytes(4, "little") + facets.tobytes())


def write_obj(path, corners):
    lines = ["v " + " ".join(map(repr, corner.tolist())) for corner in corners.reshape(-1, 3)]
    lines += [f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}" for k in range(len(corners))]
    path.write_text("\n".join(lines))


def write_ply(path, corners):
    header = f"ply\nformat ascii 1.0\nelement vertex {3 * len(corners)}\n"
    header += "".join(f"property double {name}\n" for name in "xyz")
    header += f"element face {len(corners)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [" ".join(map(repr, corner.tolist())) for corner in corners.reshape(-1, 3)]
    rows += [f"3 {3 * k} {3 * k + 1} {3 * k + 2}" for k in range(len(corners))]
    path.write_text(header + "\n".join(rows))


def mold_of(corners, **options):
    return mold_from_mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), "mesh", **options)


def can(holes=()):
    """Return the triangles of a can of 20 by 60 without those whose numbers are in `holes`."""
    return np.delete(triangles_of(Part.makeCylinder(20, 60), 0.02), list(holes), axis=0)


@pytest.mark.parametrize("write", [write_stl, write_obj, write_ply], ids=["stl", "obj", "ply"])
@pytest.mark.parametrize("name", ["wine_bottle", "perfume_flacon", "wine_glass"])
def test_a_mesh_stands_as_its_solid_does(tmp_path, name, write):
    asked = read_mold(MOLDS / f"{name}.step")
    solid = asked.solid.copy()
    solid.transformShape(TURN.toMatrix(), True, False)
    path = tmp_path / f"mold{Path('.' + write.__name__[-3:])}"
    write(path, triangles_of(solid))
    mold = read_mold(path)
    assert (mold.solid, mold.upright, mold.path) == (None, None, path)
    got, wanted = mold.anatomy, asked.anatomy
    assert got.finish_face == 0
    assert got.axis == pytest.approx(tuple(TURN.Rotation.multVec(FreeCAD.Vector(0, 0, 1))), abs=1e-6)
    assert got.base_point_mm == pytest.approx(tuple(TURN.Base), abs=1e-3)
    assert got.height_mm == pytest.approx(wanted.height_mm, abs=1e-3)
    assert got.push_up_mm == pytest.approx(wanted.push_up_mm, abs=0.02)
    assert got.finish_outer_radius_mm == pytest.approx(wanted.finish_outer_radius_mm, abs=0.15)
    assert list(got.regions) == list(wanted.regions)
    assert got.departure_mm == pytest.approx(wanted.departure_mm, abs=0.5)


def test_the_mesh_is_upright_outward_and_knows_its_mouth():
    mold = mold_of(can())
    mesh, faces = outside_mesh(mold, 0.1)
    assert mesh is mold.mesh
    assert signed_volume(mesh.vertices_mm, mesh.triangles) == pytest.approx(np.pi * 400 * 60, rel=5e-3)
    mouth = mesh.vertices_mm[mesh.triangles[faces == -1]]
    assert mouth[:, :, 2] == pytest.approx(60.0, abs=1e-6)
    areas = 0.5 * np.linalg.norm(np.cross(mouth[:, 1] - mouth[:, 0], mouth[:, 2] - mouth[:, 0]), axis=1)
    assert areas.sum() == pytest.approx(np.pi * 400, rel=5e-3)
    assert set(faces) == {0, -1}
    assert mold.repairs == ()


def test_triangles_that_face_the_other_way_are_turned_and_told():
    corners = can()
    corners[10:15] = corners[10:15, ::-1]
    mold = mold_of(corners)
    assert signed_volume(mold.mesh.vertices_mm, mold.mesh.triangles) > 0.0
    assert mold.repairs == (f"5 of its {len(corners)} triangles faced inward and were turned",)


def test_an_inside_out_mesh_is_turned_and_told():
    mold = mold_of(can()[:, ::-1])
    assert signed_volume(mold.mesh.vertices_mm, mold.mesh.triangles) > 0.0
    assert mold.repairs == ("it was inside out: all its triangles were turned outward",)


def test_doubled_triangles_are_dropped_and_told():
    corners = can()
    mold = mold_of(np.concatenate([corners, corners[3:6], corners[7:8, [0, 0, 1]]]))
    assert mold.repairs == ("4 triangles without area, or there twice, were dropped",)


def small_hole():
    """Return a sphere's triangles, flat at the top, and the number of a small one on its side."""
    corners = triangles_of(Part.makeSphere(30).common(Part.makeBox(80, 80, 55, FreeCAD.Vector(-40, -40, -35))), 0.01)
    widths = np.linalg.norm(np.ptp(corners, axis=1), axis=1)
    middles = corners.mean(axis=1)
    return corners, int(np.flatnonzero((widths < 1.5) & (middles[:, 2] < 0.0))[0])


def test_a_small_hole_is_filled_and_told_with_its_place():
    corners, number = small_hole()
    mold = mold_of(np.delete(corners, number, axis=0))
    assert len(mold.repairs) == 1
    assert mold.repairs[0].startswith("a hole was filled, the widest of ")
    place = np.array([float(word) for word in mold.repairs[0].split("(")[1].split(")")[0].split(",")])
    assert np.linalg.norm(corners[number] - place, axis=1).min() < 1e-3


def test_a_large_hole_is_refused_with_its_place_or_closed_when_asked():
    corners = can()
    top = np.all(corners[:, :, 2] > 59.9, axis=1)
    with pytest.raises(InputError, match=r"hole 56.* mm wide near \(.*, 60\.000\) mm; .*close_open_shell=True"):
        mold_of(corners[~top])
    mold = mold_of(corners[~top], close_open_shell=True)
    assert signed_volume(mold.mesh.vertices_mm, mold.mesh.triangles) == pytest.approx(np.pi * 400 * 60, rel=5e-3)
    assert "filled" in mold.repairs[0]


def test_a_large_hole_that_is_not_flat_is_refused_even_then():
    corners = can()
    middles = corners.mean(axis=1)
    missing = (middles[:, 0] > 5) & (np.abs(middles[:, 2] - 30) < 29.9)
    with pytest.raises(InputError, match=r"it has a hole .* near \(.*\) mm; close it"):
        mold_of(corners[~missing], close_open_shell=True)


def test_an_edge_of_three_triangles_is_refused_with_its_place():
    corners = can()
    start, end, _ = corners[7]
    x, y, z = 0.5 * (start + end)
    fin = np.array([[start, end, [35, 35, 30]]])
    with pytest.raises(InputError, match="more than two triangles meet in an edge") as caught:
        mold_of(np.concatenate([corners, fin]))
    assert f"near ({x:.3f}, {y:.3f}, {z:.3f}) mm" in str(caught.value)


def test_a_surface_that_crosses_itself_is_refused_with_its_place():
    corners = triangles_of(Part.makeBox(40, 40, 90))
    pin = np.argwhere(np.all(np.abs(corners - [40, 40, 90]) < 1e-9, axis=2))
    for triangle, corner in pin:
        corners[triangle, corner] = [-30, 20, 70]
    with pytest.raises(InputError, match=r"crosses itself in \d+ places, the longest of them near \("):
        mold_of(corners)


def test_two_surfaces_are_refused_with_the_place_of_one():
    ball = triangles_of(Part.makeSphere(5, FreeCAD.Vector(0, 0, 30)))
    with pytest.raises(InputError, match=r"not joined, one of them near \("):
        mold_of(np.concatenate([can(), ball]))


def test_a_mesh_without_a_flat_mouth_is_refused():
    with pytest.raises(InputError, match="mouth cannot be found"):
        mold_of(triangles_of(Part.makeSphere(30)))


def test_the_outside_of_a_hollow_mesh_is_a_mold():
    tumbler = Part.makeCylinder(30, 90).cut(Part.makeCylinder(27, 90, FreeCAD.Vector(0, 0, 4)))
    corners = triangles_of(tumbler, 0.02)
    with pytest.raises(InputError, match="already hollow"):
        mold_of(corners)
    mold = mold_of(corners, outer_shell=True)
    assert signed_volume(mold.mesh.vertices_mm, mold.mesh.triangles) == pytest.approx(np.pi * 900 * 90, rel=5e-3)
    assert mold.anatomy.axis == pytest.approx([0, 0, 1], abs=1e-9)
    assert np.any(outside_mesh(mold, 1.0)[1] == -1)


def test_metres_are_told_and_scaled(tmp_path):
    path = tmp_path / "can.stl"
    write_stl(path, can() / 1000.0)
    with pytest.raises(InputError, match="scale_to_mm=1000"):
        read_mold(path)
    assert read_mold(path, scale_to_mm=1000).anatomy.height_mm == pytest.approx(60, abs=1e-3)


def test_what_is_for_solids_is_refused_for_a_mesh(tmp_path):
    path = tmp_path / "can.stl"
    write_stl(path, can())
    with pytest.raises(InputError, match="block=True"):
        read_mold(path, block=True)
    with pytest.raises(InputError, match="finish_height_mm"):
        read_mold(path, finish_height_mm=50)


def test_a_damaged_mesh_is_refused(tmp_path):
    path = tmp_path / "can.stl"
    path.write_bytes(b"solid nothing")
    with pytest.raises(InputError, match="not a mesh that can be read"):
        read_mold(path)
