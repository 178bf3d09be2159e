"""A mold's anatomy, exact meridian and mesh, compared with OCC's own surfaces and with closed forms."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import (
    core_meridian,
    inspect,
    mold_from_shape,
    outer_meridian,
    outside_mesh,
    read_mold,
    tessellate,
)
from glassworkbench.mold.meridian import chain, face_profiles, points
from glassworkbench.mold.silhouette import find_regions
from glassworkbench.scene import Revolved

ROOT = Path(__file__).resolve().parent.parent
MOLDS = ROOT / "examples" / "molds"
CONTAINERS = ROOT.parent / "shared" / "molds"
REVOLVED = ("wine_bottle", "beer_bottle", "wine_glass")
EXAMPLES = (*REVOLVED, "whisky_flask", "perfume_flacon", "jar")


def vector(array) -> FreeCAD.Vector:
    return FreeCAD.Vector(*(float(x) for x in array))


def distances_to_meridian(flat, meridian) -> np.ndarray:
    """Distance (n,) of points (r, z) to rational cubics: Newton on the foot from each segment's nearest sample."""
    dense = 32
    nearest = np.full(len(flat), np.inf)
    for segment in meridian:
        gaps = np.linalg.norm(flat[:, None] - points(segment[None], dense), axis=2)
        near = gaps.min(axis=1) < 2.0 * np.linalg.norm(np.diff(segment[:, :2], axis=0), axis=1).sum() / dense + 0.01
        places, u = flat[near], gaps[near].argmin(axis=1) / dense
        weighted = np.column_stack([segment[:, :2] * segment[:, 2:], segment[:, 2]])
        for _ in range(30):
            basis = np.stack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3], axis=1)
            slope = np.stack([-3 * (1 - u) ** 2, 3 * (1 - u) * (1 - 3 * u), 3 * u * (2 - 3 * u), 3 * u**2], axis=1)
            place, velocity = basis @ weighted, slope @ weighted
            foot = place[:, :2] / place[:, 2:]
            tangent = (velocity[:, :2] - foot * velocity[:, 2:]) / place[:, 2:]
            step = np.einsum("ij,ij->i", places - foot, tangent) / np.einsum("ij,ij->i", tangent, tangent)
            u = np.clip(u + step, 0.0, 1.0)
        nearest[near] = np.minimum(nearest[near], np.linalg.norm(places - foot, axis=1))
    return nearest


@pytest.mark.parametrize("name", REVOLVED)
def test_meridian_lies_on_the_solid_and_the_solid_on_the_meridian(name):
    mold = read_mold(MOLDS / f"{name}.step")
    meridian = outer_meridian(mold)
    shell = mold.upright.Shells[0]
    for turn, (r, z) in enumerate(points(meridian, 7)):
        place = Part.Vertex(r * math.cos(turn), r * math.sin(turn), z)
        assert shell.distToShape(place)[0] < 1e-9

    nodes = tessellate(mold.upright, 1.0).vertices_mm
    flat = np.column_stack([np.hypot(nodes[:, 0], nodes[:, 1]), nodes[:, 2]])
    assert distances_to_meridian(flat, meridian).max() < 1e-9


@pytest.mark.parametrize("name", REVOLVED)
def test_meridian_makes_a_revolved_surface_from_base_to_finish(name):
    mold = read_mold(MOLDS / f"{name}.step")
    surface = Revolved(outer_meridian(mold))
    assert surface.meridian[0, 0, :2] == pytest.approx([0.0, mold.anatomy.push_up_mm])
    assert surface.meridian[-1, 3, :2] == pytest.approx([0.0, mold.anatomy.height_mm])
    assert mold.anatomy.is_revolved


def test_every_kind_of_revolved_face_gives_its_exact_profile():
    ring = Part.makeTorus(10, 2, vector([0, 0, 40]), vector([0, 0, 1]))
    body = (
        Part.makeCylinder(10, 40).fuse(Part.makeSphere(10)).fuse(ring).fuse(Part.makeCone(8, 5, 20, vector([0, 0, 40])))
    )
    mold = mold_from_shape(body.removeSplitter(), "pawn")
    meridian = outer_meridian(mold)
    assert mold.anatomy.height_mm == pytest.approx(70, abs=1e-9)
    flat = points(meridian, 16)
    z = flat[:, 1] - 10
    ball = z < 0
    assert np.hypot(flat[ball, 0], z[ball]) == pytest.approx(10, abs=1e-9)
    cone = (z > 42.1) & (z < 60 - 1e-9)
    assert flat[cone, 0] == pytest.approx(8 - 3 * (z[cone] - 40) / 20, abs=1e-9)


def test_free_form_faces_that_are_revolved_give_the_same_meridian():
    solid = read_mold(MOLDS / "wine_glass.step").solid
    meridian = chain(face_profiles(solid.toNurbs().Faces))
    exact = outer_meridian(mold_from_shape(solid, "glass"))
    assert distances_to_meridian(points(meridian, 5), exact).max() < 1e-9


def test_a_profile_of_high_degree_is_followed_closely():
    curve = Part.BezierCurve()
    curve.setPoles([vector([r, 0, z]) for r, z in [(20, 0), (24, 10), (18, 25), (30, 40), (12, 60), (10, 80)]])
    edges = [Part.makeLine(vector([0, 0, 0]), vector([20, 0, 0])), curve.toShape()]
    edges.append(Part.makeLine(vector([10, 0, 80]), vector([0, 0, 80])))
    shell = Part.Wire(edges).revolve(FreeCAD.Vector(), vector([0, 0, 1]), 360)
    mold = mold_from_shape(Part.makeSolid(Part.makeShell(shell.Faces)), "vase", up=(0, 0, 1))
    shell = mold.upright.Shells[0]
    gaps = [shell.distToShape(Part.Vertex(r, 0, z))[0] for r, z in points(outer_meridian(mold), 5)]
    assert max(gaps) < 2e-6


@pytest.mark.parametrize(
    "turned",
    [
        FreeCAD.Placement(vector([0, 0, 0]), FreeCAD.Rotation(vector([1, 0, 0]), -90)),
        FreeCAD.Placement(vector([120, -40, 7]), FreeCAD.Rotation(vector([1, 2, 3]), 71)),
        FreeCAD.Placement(vector([5, 6, 7]), FreeCAD.Rotation(vector([1, 0, 0]), 180)),
    ],
)
@pytest.mark.parametrize("name", ["wine_bottle", "whisky_flask", "wine_glass"])
def test_the_axis_is_found_wherever_the_container_lies(name, turned):
    standing = read_mold(MOLDS / f"{name}.step")
    shape = standing.solid.copy()
    shape.transformShape(turned.toMatrix(), True, False)
    mold = mold_from_shape(shape, name)
    assert mold.anatomy.axis == pytest.approx(tuple(turned.Rotation.multVec(vector([0, 0, 1]))), abs=1e-9)
    assert mold.anatomy.base_point_mm == pytest.approx(tuple(turned.Base), abs=1e-3)
    assert mold.anatomy.height_mm == pytest.approx(standing.anatomy.height_mm, abs=1e-3)
    upright = np.array([[*vertex.Point, 1.0] for vertex in mold.upright.Vertexes])
    cad = np.array([tuple(vertex.Point) for vertex in mold.solid.Vertexes])
    assert np.abs((upright @ mold.placement.T)[:, :3] - cad).max() < 1e-9


@pytest.mark.parametrize("name", EXAMPLES)
def test_regions_cover_the_height_without_gaps(name):
    anatomy = read_mold(MOLDS / f"{name}.step").anatomy
    heights = list(anatomy.regions.values())
    assert heights[0][0] == 0.0
    assert heights[-1][1] == pytest.approx(anatomy.height_mm)
    assert all(low < high for low, high in heights)
    assert all(below[1] == above[0] for below, above in itertools.pairwise(heights))


def test_regions_of_a_bordeaux_lie_where_its_drawing_has_them():
    regions = read_mold(MOLDS / "wine_bottle.step").anatomy.regions
    assert list(regions) == ["base", "heel", "body", "shoulder", "neck", "finish"]
    assert regions["heel"][1] == pytest.approx(6, abs=1.5)
    assert 190 < regions["body"][1] < 210
    assert 222 < regions["shoulder"][1] < 240
    assert regions["neck"][1] == pytest.approx(283.5, abs=1.5)


OUTLINES = {
    "a ring below the shoulder": [(26, 0), (30, 4), (30, 128), (30.2, 130), (30.2, 138), (10, 190), (10, 240)],
    "a taper": [(43, 0), (47, 5), (57, 107), (56, 115), (20, 150), (15, 253)],
    "a cup": [(24, 0), (24, 3), (27, 3.1), (38, 83)],
    "a bowl": [(45, 0), (46, 4), (65, 13), (78, 23), (86, 34), (92, 47), (98, 51)],
    "a flaring neck": [(10, 0), (15, 5), (20, 14), (21.7, 23), (20, 34), (12, 49), (7, 66), (10, 78), (15, 85)],
}


def regions_of(outline):
    radii, heights = np.array(outline, dtype=float).T
    levels = heights[-1] * (np.arange(400) + 0.5) / 400
    return find_regions(levels, np.interp(levels, heights, radii), None)


@pytest.mark.parametrize("name", OUTLINES)
def test_the_heel_ends_at_the_bend_however_the_body_goes_on(name):
    regions = regions_of(OUTLINES[name])
    width = 2.0 * max(radius for radius, _ in OUTLINES[name])
    assert {"base", "heel", "body"} <= set(regions)
    assert regions["base"][1] < 0.07 * width
    assert regions["heel"][1] < 0.26 * width
    assert regions["body"][0] == regions["heel"][1]


def test_a_body_that_tapers_or_has_a_ring_is_one_from_its_heel_to_its_shoulder():
    assert regions_of(OUTLINES["a ring below the shoulder"])["body"] == pytest.approx((4, 139), abs=2)
    assert regions_of(OUTLINES["a taper"])["body"] == pytest.approx((5, 115), abs=2)


def test_a_neck_that_flares_to_its_mouth_begins_below_its_waist():
    regions = regions_of(OUTLINES["a flaring neck"])
    assert regions["neck"][0] < 66 < regions["neck"][1]


def test_only_the_wine_glass_has_a_stem():
    stems = {name: read_mold(MOLDS / f"{name}.step").anatomy.stem_top_mm for name in EXAMPLES}
    assert 85 < stems.pop("wine_glass") < 97
    assert set(stems.values()) == {0.0}


def test_the_core_of_a_threaded_jar_passes_under_its_thread():
    mold = read_mold(MOLDS / "jar.step")
    assert not mold.anatomy.is_revolved
    assert mold.is_nearly_round
    assert mold.anatomy.departure_mm == pytest.approx(1.5, abs=1e-3)
    assert mold.anatomy.departure_at_mm[2] == pytest.approx(105.5, abs=0.5)
    core = core_meridian(mold, 0.25)
    threaded = (core[:, 1] > 100) & (core[:, 1] < 110)
    assert core[threaded, 0] == pytest.approx(31.0, abs=1e-9)
    assert np.linalg.norm(np.diff(core, axis=0), axis=1).max() <= 0.25 + 1e-9
    with pytest.raises(InputError, match=r"departs from a body of revolution by 1\.5 mm"):
        outer_meridian(mold)


@pytest.mark.parametrize("name", ["whisky_flask", "perfume_flacon"])
def test_bodies_that_are_not_round_have_no_core(name):
    mold = read_mold(MOLDS / f"{name}.step")
    assert not mold.is_nearly_round
    assert core_meridian(mold) is None
    assert mold.anatomy.departure_mm > 5


def test_departure_of_a_square_prism_is_its_corners():
    mold = mold_from_shape(Part.makeBox(40, 40, 100, vector([-20, -20, 0])), "prism")
    assert mold.anatomy.departure_mm == pytest.approx(20 * math.sqrt(2) - 20, abs=1e-6)


@pytest.mark.parametrize("name", EXAMPLES)
def test_meshes_are_closed_and_lie_on_the_solid(name):
    mold = read_mold(MOLDS / f"{name}.step")
    mesh = tessellate(mold.upright, 0.2)
    assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(1.0, abs=1e-9)
    shell = mold.upright.Shells[0]
    chosen = np.random.default_rng(2).choice(len(mesh.vertices_mm), 60, replace=False)
    for place in mesh.vertices_mm[chosen]:
        assert shell.distToShape(Part.Vertex(*place.tolist()))[0] < 1e-6
    corners = mesh.vertices_mm[mesh.triangles]
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets /= np.linalg.norm(facets, axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", facets, mesh.normals[mesh.triangles[:, 0]]).min() > 0.5


@pytest.mark.parametrize("name", ["jar", "perfume_flacon"])
def test_triangles_of_the_outside_know_the_face_they_lie_on(name):
    mold = read_mold(MOLDS / f"{name}.step")
    mesh, faces = outside_mesh(mold, 0.1)
    assert set(faces) == set(range(1, len(mold.upright.Faces) + 1))
    middles = mesh.vertices_mm[mesh.triangles].mean(axis=1)
    for triangle in np.random.default_rng(5).choice(len(faces), 60, replace=False):
        face = mold.upright.Faces[faces[triangle] - 1]
        assert face.distToShape(Part.Vertex(*middles[triangle].tolist()))[0] < 0.11
    mouth = faces == mold.anatomy.finish_face
    assert mesh.vertices_mm[mesh.triangles[mouth], 2] == pytest.approx(mold.anatomy.finish_height_mm)


def test_a_sphere_mesh_carries_the_spheres_own_normals():
    mesh = tessellate(Part.makeSphere(25), 0.1)
    assert mesh.normals == pytest.approx(mesh.vertices_mm / 25, abs=1e-6)


def test_a_hollow_container_meshes_closed():
    outer, inner = Part.makeCylinder(30, 90), Part.makeCylinder(27, 90, vector([0, 0, 4]))
    mesh = tessellate(outer.cut(inner), 0.01)
    a, b, c = (mesh.vertices_mm[mesh.triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    assert volume == pytest.approx(math.pi * (30**2 * 90 - 27**2 * 86), rel=2e-3)


def test_the_user_can_overrule_axis_and_finish():
    shape = Part.makeCylinder(20, 60).fuse(Part.makeSphere(20, vector([0, 0, 60])))
    mold = mold_from_shape(shape, "dome", up=(0, 0, 1), finish_height_mm=70)
    assert mold.anatomy.height_mm == pytest.approx(70, abs=1e-9)
    assert mold.anatomy.finish_height_mm == pytest.approx(70, abs=1e-9)
    upside_down = mold_from_shape(Part.makeCylinder(20, 60), "can", up=(0, 0, -1))
    assert upside_down.anatomy.axis == pytest.approx([0, 0, -1])


def test_inspect_tells_what_a_file_holds():
    found = inspect(MOLDS / "jar.step")
    assert found["solids"] == 1
    assert found["unit"] == "millimetre"
    assert found["hollow"] is False
    assert found["entities"]["MANIFOLD_SOLID_BREP"] == 1
    assert found["entities"]["TOROIDAL_SURFACE"] == found["faces"]["Toroid"]
    assert found["mesh_volume_mm3"] == pytest.approx(read_mold(MOLDS / "jar.step").solid.Volume, rel=2e-5)
    assert found["faults"] == []


@pytest.mark.parametrize(
    ("name", "height_mm"),
    [("osk00_bottle.step", 253), ("besumit_day02_beverage_bottle.step", 240), ("myfreecad_vase.step", 85)],
)
def test_inspect_sees_that_real_containers_are_hollow(name, height_mm):
    path = CONTAINERS / name
    if not path.exists():
        pytest.skip("the real containers are not beside this checkout")
    found = inspect(path)
    assert found["hollow"] is True
    assert found["axis"] == pytest.approx([0, 0, 1], abs=1e-9)
    assert found["height_mm"] == pytest.approx(height_mm, rel=1e-3)


def test_the_outer_shell_of_a_hollow_container_is_its_mold():
    outer, inner = Part.makeCylinder(30, 90), Part.makeCylinder(27, 90, vector([0, 0, 4]))
    container = outer.cut(inner)
    with pytest.raises(InputError, match="already hollow"):
        mold_from_shape(container, "tumbler")
    mold = mold_from_shape(container, "tumbler", outer_shell=True)
    assert mold.anatomy.axis == pytest.approx([0, 0, 1])
    assert mold.solid.Volume == pytest.approx(outer.Volume, rel=1e-9)
