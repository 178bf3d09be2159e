import struct

import numpy as np
import pytest

from glassworkbench.errors import InputError
from glassworkbench.glass import find_glass
from glassworkbench.images import Image
from glassworkbench.scene import Ellipsoid, Environment, Mesh, Panel, Pinhole, Revolved, Telecentric
from glassworkbench.scene.file import read_meridian, read_scene
from glassworkbench.scene.meshes import read_mesh

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]

CYLINDER = """# a cylinder of radius 10 and height 30
0,0,3,0,7,0,10,0
10,0,10,10,10,20,10,30
10,30,7,30,3,30,0,30
"""

SCENE = """
[image]
size = [48, 64]
[camera]
kind = "pinhole"
origin = [0, -1000, 150]
target = [0, 0, 150]
vertical_fov_deg = 18.18
[[body]]
name = "glass"
meridian = "cylinder.csv"
[[body]]
name = "seed"
ellipsoid = { centre = [0, 9, 15], semi_axes = [0.5, 0.5, 1] }
[[medium]]
where = "glass and not seed"
glass = "emerald"
[[light]]
kind = "panel"
origin = [-100, 100, -50]
u = [200, 0, 0]
v = [0, 0, 400]
radiance = 1.0
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "cylinder.csv").write_text(CYLINDER)
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path


def changed(folder, old, new):
    text = SCENE.replace(old, new)
    assert text != SCENE
    (folder / "scene.toml").write_text(text)
    return folder / "scene.toml"


def test_a_scene_file_gives_what_it_says(folder):
    scene = read_scene(folder / "scene.toml")
    assert scene.size == (48, 64)
    assert isinstance(scene.camera, Pinhole)
    assert np.isclose(scene.camera.vertical_field_of_view_rad, np.radians(18.18))
    assert [body.name for body in scene.bodies] == ["glass", "seed"]
    assert isinstance(scene.bodies[0].surface, Revolved)
    assert isinstance(scene.bodies[1].surface, Ellipsoid)
    assert np.array_equal(scene.media[0].absorption_per_mm, find_glass("emerald").rgb_absorption_per_mm())
    assert isinstance(scene.lights[0], Panel)
    assert scene.brightest() == 1.0


def test_a_meridian_keeps_its_points_and_weights(folder):
    plain = read_meridian(folder / "cylinder.csv")
    assert plain.shape == (3, 4, 3)
    assert plain[1, 2].tolist() == [10.0, 20.0, 1.0]
    (folder / "weighted.csv").write_text("0,-5,1, 2,-5,.8, 5,-2,.8, 5,0,1\n5,0,1, 5,2,.8, 2,5,.8, 0,5,1\n")
    assert read_meridian(folder / "weighted.csv")[0, 1].tolist() == [2.0, -5.0, 0.8]


def test_a_placement_turns_and_then_moves(folder):
    placed = 'meridian = "cylinder.csv"\nplacement = { position = [1, 2, 3], axis = [0, 1, 0], angle_deg = 90 }'
    scene = read_scene(changed(folder, 'meridian = "cylinder.csv"', placed))
    assert np.allclose(scene.bodies[0].surface.axis, (1, 0, 0))
    assert np.allclose(scene.bodies[0].surface.base_mm, (1, 2, 3))


def test_an_environment_is_read_from_an_image(folder):
    light = np.random.default_rng(7).random((4, 8, 3))
    Image(light, np.zeros((4, 8)), np.zeros((4, 8))).save(folder / "sky.exr")
    path = folder / "scene.toml"
    path.write_text(SCENE[: SCENE.index("[[light]]")] + '[[light]]\nkind = "environment"\nimage = "sky.exr"\n')
    lights = read_scene(path).lights
    assert isinstance(lights[0], Environment)
    assert np.allclose(lights[0].radiance, light, atol=1e-7)


def test_a_telecentric_camera_has_a_height(folder):
    path = changed(folder, '"pinhole"', '"telecentric"')
    path.write_text(path.read_text().replace("vertical_fov_deg = 18.18", "height = 320"))
    camera = read_scene(path).camera
    assert isinstance(camera, Telecentric)
    assert camera.height_mm == 320.0


def test_a_step_body_comes_from_the_reader_that_is_given(folder):
    path = changed(folder, 'meridian = "cylinder.csv"', 'step = "x.step"')
    asked = []
    surface = Revolved(read_meridian(folder / "cylinder.csv"))
    scene = read_scene(path, lambda step: asked.append(step) or surface)
    assert asked == [folder / "x.step"]
    assert scene.bodies[0].surface is surface
    with pytest.raises(InputError, match="FreeCAD"):
        read_scene(path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("vertical_fov_deg", "vertical_fov", "'vertical_fov' is not known; did you mean 'vertical_fov_deg'"),
        ('"pinhole"', '"pinhol"', "did you mean 'pinhole'"),
        ("[image]\nsize = [48, 64]", "[image]\nsize = [48, -64]", "48x-64 pixels"),
        ("[image]\nsize = [48, 64]", "[image]\nsize = [48.5, 64]", "whole numbers"),
        ('"emerald"', '"emrald"', "did you mean 'emerald'"),
        ("glass and not seed", "glass and not sed", "no body is named 'sed'"),
        ("cylinder.csv", "nowhere.csv", "there is no such file"),
        ('kind = "panel"', 'kind = "pannel"', "did you mean 'panel'"),
        ("[[light]]", "[light]", r"write \[\[light\]\]"),
        ("[200, 0, 0]", '"wide"', "panel u_mm: expected numbers"),
        ('name = "seed"', 'name = "glass"', "used twice"),
        ("ellipsoid = {", 'mesh = "x.ply"\nellipsoid = {', "mesh and ellipsoid"),
        ("radiance = 1.0", "radiance = nan", "finite"),
        ("origin = [0, -1000, 150]\n", "", "'origin' is missing"),
    ],
)
def test_a_faulty_scene_file_is_told_in_one_sentence(folder, old, new, message):
    path = changed(folder, old, new)
    with pytest.raises(InputError, match=message) as caught:
        read_scene(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_a_meridian_with_a_short_row_names_the_line(folder):
    (folder / "cylinder.csv").write_text(CYLINDER.replace("10,30,7,30,3,30,0,30", "10,30,7"))
    with pytest.raises(InputError, match="line 4 has 3 numbers"):
        read_meridian(folder / "cylinder.csv")


def ply(form, with_normals=False):
    columns = ["x", "y", "z", "nx", "ny", "nz"] if with_normals else ["x", "y", "z"]
    head = f"ply\nformat {form} 1.0\ncomment cube\nelement vertex 8\n"
    head += "".join(f"property float {column}\n" for column in columns)
    head += "element face 6\nproperty uchar flag\nproperty list uchar int vertex_indices\nend_header\n"
    rows = np.hstack([CUBE, CUBE - 0.5]) if with_normals else CUBE
    if form == "ascii":
        text = "".join(" ".join(f"{x:g}" for x in row) + "\n" for row in rows)
        return (head + text + "".join("1 4 " + " ".join(map(str, quad)) + "\n" for quad in QUADS)).encode()
    order = "<" if "little" in form else ">"
    data = b"".join(struct.pack(f"{order}{len(row)}f", *row) for row in rows)
    return head.encode() + data + b"".join(struct.pack(f"{order}BB4i", 1, 4, *quad) for quad in QUADS)


def stl(binary):
    triangles = [CUBE[[quad[0], quad[k], quad[k + 1]]] for quad in QUADS for k in (1, 2)]
    if binary:
        facets = b"".join(struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in triangles)
        return b"solid, but binary".ljust(80) + struct.pack("<I", 12) + facets
    corners = ["".join("vertex {:g} {:g} {:g}\n".format(*corner) for corner in triangle) for triangle in triangles]
    return ("solid\n" + "".join(f"facet normal 0 0 0\nouter loop\n{c}endloop\nendfacet\n" for c in corners)).encode()


def obj():
    lines = ["v {:g} {:g} {:g}".format(*v) for v in CUBE]
    return "\n".join(lines + ["f " + " ".join(str(v - 8) for v in quad) for quad in QUADS]).encode()


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("ascii.ply", ply("ascii")),
        ("little.ply", ply("binary_little_endian")),
        ("big.ply", ply("binary_big_endian")),
        ("binary.stl", stl(True)),
        ("text.stl", stl(False)),
        ("from_the_end.obj", obj()),
    ],
)
def test_a_cube_keeps_its_size_and_its_sharp_edges_in_every_format(tmp_path, name, data):
    (tmp_path / name).write_bytes(data)
    mesh = read_mesh(tmp_path / name)
    assert len(mesh.triangles) == 12
    a, b, c = (mesh.vertices_mm[mesh.triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    assert np.isclose(np.einsum("ij,ij->", a, cross) / 6.0, 1.0)
    for k in range(3):
        assert np.allclose(mesh.normals[mesh.triangles[:, k]], cross)


def test_normals_of_the_file_are_kept(tmp_path):
    (tmp_path / "cube.ply").write_bytes(ply("binary_little_endian", with_normals=True))
    mesh = read_mesh(tmp_path / "cube.ply")
    assert np.allclose(mesh.normals, (CUBE - 0.5) / np.sqrt(0.75))


def test_a_fine_sphere_gets_smooth_normals(tmp_path):
    polar, around = np.meshgrid(np.linspace(0, np.pi, 25), np.linspace(0, 2 * np.pi, 48, endpoint=False), indexing="ij")
    points = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1)
    points[0], points[-1] = (0, 0, 1), (0, 0, -1)
    number = np.arange(25 * 48).reshape(25, 48)
    right = np.roll(number, -1, axis=1)
    quads = np.stack([number[:-1], number[1:], right[1:], right[:-1]], axis=-1).reshape(-1, 4) + 1
    lines = ["v {} {} {}".format(*p) for p in points.reshape(-1, 3)] + ["f {} {} {} {}".format(*q) for q in quads]
    (tmp_path / "sphere.obj").write_text("\n".join(lines))
    mesh = read_mesh(tmp_path / "sphere.obj")
    assert isinstance(mesh, Mesh)
    assert len(mesh.vertices_mm) == 23 * 48 + 2
    assert np.abs(mesh.normals - mesh.vertices_mm).max() < 0.01


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("cut.ply", ply("binary_little_endian")[:-20]),
        ("cut_text.ply", ply("ascii")[:-20]),
        ("cut.stl", stl(True)[:-20]),
        ("empty.obj", b""),
        ("out_of_range.obj", b"v 0 0 0\nf 1 2 3"),
        ("open.obj", obj()[: obj().rindex(b"f")]),
        ("nothing.ply", b"ply"),
        ("cube.step", b""),
    ],
)
def test_a_damaged_mesh_is_refused_by_name(tmp_path, name, data):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=name) as caught:
        read_mesh(tmp_path / name)
    assert "\n" not in str(caught.value)
