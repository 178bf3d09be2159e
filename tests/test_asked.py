"""A thickness as data, applied to real molds: what is asked at each point of their outside."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import mold_from_shape, outside_mesh, read_mold
from glassworkbench.wall.asking.thickness_text import parse_thickness
from glassworkbench.wall.asking.underside import underside_of

MOLDS = "examples/molds"


@pytest.fixture(scope="module")
def bottle():
    return read_mold(f"{MOLDS}/wine_bottle.step")


@pytest.fixture(scope="module")
def flacon():
    return read_mold(f"{MOLDS}/perfume_flacon.step")


@pytest.fixture(scope="module")
def jar():
    return read_mold(f"{MOLDS}/jar.step")


@pytest.fixture(scope="module")
def flask():
    """An oval flask, 80 by 40 mm, with a flat standing ring, a push-up of 6 mm and a round neck."""
    body = Part.Face(Part.Wire(Part.Ellipse(FreeCAD.Vector(), 40.0, 20.0).toShape())).extrude(FreeCAD.Vector(0, 0, 60))
    pushed = Part.Face(Part.Wire(Part.Ellipse(FreeCAD.Vector(), 36.0, 16.0).toShape()))
    pushed = pushed.extrude(FreeCAD.Vector(0, 0, 6))
    neck = Part.makeCylinder(12.0, 40.0, FreeCAD.Vector(0, 0, 60))
    return mold_from_shape(body.cut(pushed).fuse(neck).removeSplitter(), "flask")


@cache
def points_of(mold):
    """Centres of the outside's triangles with their outward normals, faces, and radii; the mouth left out."""
    mesh, faces = outside_mesh(mold, 0.05)
    corners = mesh.vertices_mm[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    keep = faces != mold.anatomy.finish_face
    points = corners.mean(axis=1)[keep]
    return points, normals[keep], faces[keep], np.hypot(points[:, 0], points[:, 1])


@pytest.mark.parametrize("text", ["2.5", "0:5 40:2 300:3", "0:5 300:3 linear"])
def test_a_thickness_over_height_is_the_same_asked_at_points(bottle, text):
    points, _, faces, _ = points_of(bottle)
    asked = parse_thickness(text).on(bottle)
    thickness = asked.at(points, faces)
    assert np.array_equal(thickness, asked.over_height.at(points[:, 2]))
    assert asked.minimum_mm <= thickness.min()
    assert thickness.max() <= asked.maximum_mm


def test_the_underside_has_the_bases_thickness_and_no_outer_point_of_the_heel_has(bottle):
    points, normals, faces, radii = points_of(bottle)
    thickness = parse_thickness("base=5 heel=4 body=2").on(bottle).at(points, faces)
    inside_ring = (radii < bottle.anatomy.bearing_radius_mm) & (points[:, 2] < 25.0)
    assert inside_ring.sum() > 1000
    assert np.all(thickness[inside_ring] == 5.0)
    assert points[inside_ring, 2].max() > 20.0
    heel = (normals[:, 2] > -0.5) & ~inside_ring & (points[:, 2] < 30.0)
    assert heel.sum() > 100
    assert np.all(thickness[heel] < 5.0)


def test_a_body_that_narrows_upward_is_not_taken_for_the_underside_it_stands_around():
    outline = [(0, 12), (20, 8), (30, 0), (24, 100), (0, 100)]
    wire = Part.makePolygon([FreeCAD.Vector(r, 0, z) for r, z in [*outline, outline[0]]])
    mold = mold_from_shape(
        Part.Face(wire).revolve(FreeCAD.Vector(), FreeCAD.Vector(0, 0, 1), 360.0), "beaker", up=(0, 0, 1)
    )
    points, normals, _, _ = points_of(mold)
    assert np.array_equal(underside_of(mold).holds(points), normals[:, 2] < -0.2)


def test_the_ring_of_an_oval_is_oval(flask):
    points, normals, _, _ = points_of(flask)
    held = underside_of(flask).holds(points)
    ceiling = (normals[:, 2] < -0.9) & (points[:, 2] > 1.0)
    outer_side = np.hypot(points[:, 0] / 40.0, points[:, 1] / 20.0) > 0.99
    assert np.all(held[ceiling])
    assert not np.any(held[outer_side & (points[:, 2] > 0.5)])
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    rim = np.column_stack([40.0 * np.cos(angle), 20.0 * np.sin(angle), 0.0 * angle])
    assert np.allclose(underside_of(flask).ring_radius(rim), np.hypot(rim[:, 0], rim[:, 1]), rtol=0.005)


def test_a_grid_over_height_and_angle_follows_the_angle(bottle):
    text = " ".join(f"{z}@{angle}:{t}" for z in (0, 300) for angle, t in ((0, 2), (90, 3), (180, 4), (270, 3)))
    asked = parse_thickness(text).on(bottle)
    angle = np.radians([0.0, 90.0, 180.0, -90.0, 360.0])
    side = np.column_stack([38.0 * np.cos(angle), 38.0 * np.sin(angle), np.full(5, 100.0)])
    assert asked.at(side, np.zeros(5, int)) == pytest.approx([2.0, 3.0, 4.0, 3.0, 2.0], abs=1e-12)
    assert (asked.minimum_mm, asked.maximum_mm) == (2.0, 4.0)
    assert asked.over_height is None


def test_a_grid_has_one_thickness_on_the_axis_and_no_step_at_the_ring(bottle):
    asked = parse_thickness("0@0:2 0@180:4 300@0:2 300@180:4").on(bottle)
    angle = np.linspace(0.0, 2.0 * np.pi, 60)
    around = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    none = np.zeros(60, int)
    on_axis = asked.at(1e-6 * around + [0.0, 0.0, 22.0], none)
    assert on_axis == pytest.approx(3.0, abs=1e-9)
    ring = underside_of(bottle).ring_radius(around)[:, None]
    inside, outside_ring = asked.at((1 - 1e-6) * ring * around, none), asked.at((1 + 1e-6) * ring * around, none)
    assert np.abs(inside - outside_ring).max() < 1e-6


def test_a_grid_starts_from_its_mean_where_a_stem_opens_into_the_bowl():
    glass = read_mold(f"{MOLDS}/wine_glass.step")
    asked = parse_thickness("0@0:1 0@180:2 215@0:1 215@180:2").on(glass)
    points, _, faces, _ = points_of(glass)
    thickness, height = asked.at(points, faces), points[:, 2]
    assert np.all(thickness[height < glass.anatomy.stem_top_mm] == 1.5)
    bowl = height > glass.anatomy.stem_top_mm + 25.0
    assert thickness[bowl].min() < 1.01
    assert thickness[bowl].max() > 1.99


def test_a_mold_that_is_a_mesh_has_regions_and_a_bore_but_no_faces(flacon):
    mesh, _ = outside_mesh(flacon, 0.1)
    scanned = replace(flacon, solid=None, upright=None, mesh=mesh, anatomy=replace(flacon.anatomy, finish_face=0))
    points, none = mesh.vertices_mm, np.zeros(len(mesh.vertices_mm), int)
    for text in ("body=2 base=3", "2 bore=9", "0@0:2 0@90:3 108@0:2 108@90:3"):
        wanted = parse_thickness(text)
        expected = wanted.on(flacon).at(points, none)
        assert np.abs(wanted.on(scanned).at(points, none) - expected).max() < 0.02
    with pytest.raises(InputError, match="is a mesh and has no CAD faces"):
        parse_thickness("Face1=3 else=2").on(scanned)


def test_a_grid_must_reach_from_base_to_finish(bottle):
    with pytest.raises(InputError, match="covers heights 0 to 250"):
        parse_thickness("0@0:2 0@180:4 250@0:2 250@180:4").on(bottle)


def test_faces_that_meet_smoothly_blend_over_three_walls(bottle):
    # Face9 is the cylinder of the body from 6 to 178 mm, tangent to its neighbours; 6 mm each side of an edge.
    asked = parse_thickness("Face9=2 else=4").on(bottle)
    z = np.linspace(6.2, 177.8, 500)
    on_body = np.column_stack([0.0 * z, np.full(500, 38.0), z])
    share = np.minimum(np.minimum(z - 6.0, 178.0 - z) / 6.0, 1.0)
    expected = 2.0 + 2.0 * (0.5 - 0.25 * (3.0 * share - share**3))
    assert np.abs(asked.at(on_body, np.full(500, 9)) - expected).max() < 1e-4
    points, _, faces, _ = points_of(bottle)
    thickness = asked.at(points, faces)
    far = (points[:, 2] < 0.1) | (points[:, 2] > 185.0)
    assert np.all(thickness[far & (faces != 9)] == 4.0)
    edge = np.array([[38.0, 0.0, 6.0]])
    assert asked.at(edge, np.array([8])) == pytest.approx(asked.at(edge, np.array([9])), abs=1e-3)


def test_faces_step_across_a_sharp_edge(flask):
    points, normals, faces, _ = points_of(flask)
    side = int(faces[np.argmax(np.abs(normals[:, 2]) < 0.01)])
    asked = parse_thickness(f"Face{side}=4 else=2").on(flask)
    assert np.array_equal(asked.at(points, faces), np.where(faces == side, 4.0, 2.0))


def test_a_blend_passes_through_a_face_that_is_narrower_than_itself():
    box = Part.makeBox(60.0, 60.0, 90.0, FreeCAD.Vector(-30, -30, 0))
    upright = [edge for edge in box.Edges if abs(edge.tangentAt(edge.FirstParameter).z) > 0.9]
    mold = mold_from_shape(box.makeFillet(2.0, upright), "square jar", up=(0, 0, 1))
    front = next(k for k, face in enumerate(mold.upright.Faces, 1) if face.CenterOfMass.x > 29.9)
    asked = parse_thickness(f"Face{front}=5 else=3").on(mold)
    points, normals, faces, _ = points_of(mold)
    thickness = asked.at(points, faces)
    assert np.all(thickness[np.abs(normals[:, 2]) > 0.9] == 3.0)
    # Around the corner, on the flat side, the blend is not over yet: 7.5 mm to the edge of the front.
    beyond = next(k for k, face in enumerate(mold.upright.Faces, 1) if face.CenterOfMass.y > 29.9)
    x = np.linspace(-26.0, 28.0, 300)
    distance = np.hypot(28.0 - x, 2.0), np.hypot(30.0 - x, 2.0)
    on_side = np.column_stack([x, np.full(300, 30.0), np.full(300, 45.0)])
    share = np.minimum(distance[1] / 7.5, 1.0)
    expected = 3.0 + 2.0 * (0.5 - 0.25 * (3.0 * share - share**3))
    assert np.abs(asked.at(on_side, np.full(300, beyond)) - expected).max() < 1e-6


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Face99=4 else=2", "wine_bottle has no such face outside; its faces are 1 to 17"),
        ("Face18=4 else=2", "closes the mouth"),
        ("body=2 stem=3", "the mold has no stem; it has finish, neck, shoulder, body"),
        ("3 bore=40", "leaves no glass in the finish, which is only .* mm wide outside; ask for a narrower bore"),
    ],
)
def test_what_a_mold_does_not_have_is_refused_in_one_sentence(bottle, text, words):
    with pytest.raises(InputError, match=words) as caught:
        parse_thickness(text).on(bottle)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("mold", "diameter"), [("bottle", 18.5), ("flacon", 9.0), ("jar", 50.0)])
def test_a_bore_makes_the_inside_of_the_finish_a_cylinder(request, mold, diameter):
    """Brute force: the ball that an outer point keeps free touches the cylinder, and none reaches into it."""
    mold = request.getfixturevalue(mold)
    asked = parse_thickness(f"2 bore={diameter}").on(mold)
    mesh, _ = outside_mesh(mold, 0.3)
    low, high, radius = asked.bore.full_from_mm, mold.anatomy.finish_height_mm, asked.bore_radius_mm
    centres = mesh.vertices_mm[(mesh.normals[:, 2] < 0.35) & (mesh.vertices_mm[:, 2] > asked.bore.none_below_mm - 20.0)]
    thickness = asked.at(centres, np.zeros(len(centres), int))
    # Where the outside widens below the finish, the balls there are wide, and may reach a little way up.
    touching = centres[centres[:, 2] > low + 0.2 * (high - low)]
    across = touching[:, :2] / np.hypot(touching[:, 0], touching[:, 1])[:, None]
    touched = np.column_stack([radius * across, touching[:, 2]])[:: max(1, len(touching) // 300)]
    assert len(touched) > 20
    clearance = np.linalg.norm(touched[:, None] - centres, axis=2) - thickness
    assert np.abs(clearance.min(axis=1)).max() < 1e-9


def test_a_bore_blends_into_the_wall_below_the_finish(bottle):
    asked, without = parse_thickness("3 bore=18.5").on(bottle), parse_thickness("3").on(bottle)
    z = np.linspace(250.0, 290.0, 400)
    side = np.column_stack([np.full(400, 14.0), 0.0 * z, z])
    none = np.zeros(400, int)
    thickness = asked.at(side, none)
    assert np.all(thickness[z < asked.bore.none_below_mm] == without.at(side, none)[z < asked.bore.none_below_mm])
    assert thickness[z > asked.bore.full_from_mm] == pytest.approx(14.0 - 9.25)
    assert np.all(np.diff(thickness) >= 0.0)
    assert np.diff(thickness).max() / (z[1] - z[0]) < 0.3
    assert bottle.anatomy.regions["neck"][0] <= asked.bore.none_below_mm < asked.bore.full_from_mm


def test_a_bore_leaves_the_range_of_the_wall_true(bottle):
    asked = parse_thickness("0@0:2 0@180:4 300@0:2 300@180:4 bore=26").on(bottle)
    points, normals, faces, _ = points_of(bottle)
    thickness = asked.at(points, faces)[normals[:, 2] < 0.3]
    # The facets' centres lie up to 0.05 mm under the surface.
    assert asked.minimum_mm - 0.05 <= thickness.min() < 1.0
    assert thickness.max() <= asked.maximum_mm
    assert asked.bore_radius_mm == 13.0


@pytest.mark.parametrize("name", ["wine_bottle_over_height", "wine_bottle_leaning_parison"])
def test_the_example_tables_fit_the_wine_bottle(bottle, name):
    points, _, faces, _ = points_of(bottle)
    thickness = parse_thickness(f"@examples/walls/{name}.csv bore=18.5").on(bottle).at(points, faces)
    assert np.min(thickness[points[:, 2] < 280.0]) > 1.9
    assert thickness.max() < 6.0
