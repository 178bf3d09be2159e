"""A CAD solid as the tracer takes it: on its exact faces, closed, and right at seams, poles and loose edges."""

from pathlib import Path

import numpy as np
import pytest
import tracer_scenes

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import exact_surface, read_mold
from glassworkbench.scene import Body, Medium, Mesh, Patches, Scene
from glassworkbench.staging import station
from glassworkbench.tracer import native
from glassworkbench.wall import container_from_shape, seen

ROOT = Path(__file__).resolve().parent.parent
SHARED = ROOT.parent / "shared" / "molds"

needs_native = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")


def seamed():
    """A ball on a cylinder: periodic seams and a pole."""
    return Part.makeCylinder(10.0, 30.0).fuse(Part.makeSphere(10.0, FreeCAD.Vector(0, 0, 30))).removeSplitter()


def bored():
    """A box with rounded edges and a hole: trimmed planes, concave seams, creases with curved edges."""
    box = Part.makeBox(40.0, 30.0, 20.0)
    rounded = box.makeFillet(4.0, box.Edges)
    return rounded.cut(Part.makeCylinder(6.0, 40.0, FreeCAD.Vector(20, 15, -5), FreeCAD.Vector(0, 0.3, 1)))


def dome():
    return Part.makeCone(12.0, 0.0, 25.0)


def bulging():
    """A lofted body: one face that closes on itself."""

    def section(z, width, depth):
        ellipse = Part.Ellipse(FreeCAD.Vector(0, 0, z), width, depth)
        return Part.Wire(ellipse.toShape())

    return Part.makeLoft([section(0, 15, 10), section(20, 18, 12), section(40, 9, 8)], True)


SHAPES = {"seamed": seamed, "bored": bored, "cone": dome, "lofted": bulging}


def scene_of(surface):
    media = (Medium("glass", 1.5, (0.02, 0.01, 0.03)),)
    return Scene((Body("glass", surface),), media, (tracer_scenes.sky(),), tracer_scenes.CAMERA)


def assert_hits_lie_on_the_faces(shape, surface, rays, sampled):
    """No leak, and the first hits as near to OCC's faces as floating point allows."""
    scene = scene_of(surface)
    origins, directions = tracer_scenes.rays_through(scene, rays, seed=51)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    answer = native.radiance(scene, origins, directions)
    assert answer.leaks.sum() == 0
    met = np.flatnonzero(np.isfinite(answer.depth_mm))[:sampled]
    assert len(met) == sampled
    points = origins[met] + answer.depth_mm[met, None] * directions[met]
    distances = [min(face.distToShape(Part.Vertex(*point))[0] for face in shape.Faces) for point in points]
    assert max(distances) < 1e-6


@needs_native
@pytest.mark.parametrize("name", SHAPES)
def test_hits_lie_on_the_faces_of_the_cad_program(name):
    shape = SHAPES[name]()
    surface = exact_surface(shape)
    assert len(surface.sheets) == len(shape.Faces)
    assert_hits_lie_on_the_faces(shape, surface, 10_000, 30)


@needs_native
def test_a_lofted_example_is_met_on_its_faces():
    upright = read_mold(ROOT / "examples" / "molds" / "perfume_flacon.step").upright
    assert_hits_lie_on_the_faces(upright, exact_surface(upright), 2_000, 10)


@needs_native
def test_a_thread_of_degree_twelve_with_loose_edges_is_met_on_its_faces():
    path = SHARED / "occt_bottle.brep"
    if not path.exists():
        pytest.skip("no shared molds")
    upright = read_mold(path, outer_shell=True).upright
    surface = exact_surface(upright)
    assert max(max(sheet.degrees) for sheet in surface.sheets) == 12
    assert surface.deviation_mm > 0.01
    assert_hits_lie_on_the_faces(upright, surface, 2_000, 10)


@pytest.mark.parametrize("name", SHAPES)
def test_triangles_face_outward_in_the_parameters_of_their_sheet(name):
    surface = exact_surface(SHAPES[name]())
    corners = surface.mesh.vertices_mm[surface.mesh.triangles]
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    uv = surface.uv_of_corner
    first, second = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    turn = np.sign(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    _, by_u, by_v = surface.evaluate(surface.sheet_of_triangle, uv.mean(axis=1))
    assert np.all(turn * np.einsum("ij,ij->i", np.cross(by_u, by_v), facets) > 0.0)


def test_a_box_around_patches_holds_what_bulges_out_between_their_corners():
    low, high = exact_surface(Part.makeSphere(10.0), 0.5).box_mm
    np.testing.assert_allclose(low, -10.0, atol=0.05)
    np.testing.assert_allclose(high, 10.0, atol=0.05)


def test_a_solid_without_exact_faces_is_traced_as_a_mesh_and_the_image_says_so(monkeypatch):
    def refuse(shape):
        raise GlassWorkbenchError("a face of type Odd could not be converted")

    outer, inner = Part.makeBox(60, 60, 100), Part.makeBox(52, 52, 100, FreeCAD.Vector(4, 4, 5))
    jar = outer.cut(inner)
    exact = container_from_shape(jar, "jar")
    assert isinstance(exact.outer, Patches)
    assert isinstance(exact.cavity, Patches)
    assert "notes" not in station("studio", exact, "flint").metadata
    monkeypatch.setattr(seen, "exact_surface", refuse)
    meshed = container_from_shape(jar, "jar")
    assert isinstance(meshed.outer, Mesh)
    assert isinstance(meshed.cavity, Mesh)
    told = station("studio", meshed, "flint").metadata["notes"]
    assert "the outside is traced as a mesh" in told
    assert "the cavity is traced as a mesh" in told
    assert "type Odd" in told
