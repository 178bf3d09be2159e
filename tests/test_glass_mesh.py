"""The glass of a mold that is a mesh: one closed mesh, whose volume is outside minus inside."""

import importlib

import numpy as np
import pytest
from meshed_molds import ball_bottomed, mesh_mold

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import Part
from glassworkbench.mold import mold_from_shape
from glassworkbench.mold.tessellation import outside_mesh
from glassworkbench.wall import container as wall_container
from glassworkbench.wall import hollow
from glassworkbench.wall.glass_mesh import glass_mesh
from glassworkbench.wall.measuring.outside import is_mouth
from glassworkbench.wall.measuring.volumes import mesh_volume


@pytest.fixture(scope="module")
def container():
    return hollow(mesh_mold(ball_bottomed(20.0, 50.0)), 3.0)


def test_a_container_of_a_mesh_is_written_as_closed_stl(container, tmp_path):
    path = tmp_path / "tube.stl"
    container.save(path)
    written = importlib.import_module("Mesh").Mesh(str(path))
    expected = np.pi * (20**2 - 17**2) * 30 + 2 / 3 * np.pi * (20**3 - 17**3)
    assert written.isSolid()
    assert written.Volume == pytest.approx(expected, rel=0.01)


def test_the_rim_of_a_container_of_a_mesh_is_level(container):
    mold = container.mold
    outer, faces = outside_mesh(mold, 0.05)
    glass = glass_mesh(outer, is_mouth(mold, faces), container.inside)
    top = np.all(glass.vertices_mm[glass.triangles][:, :, 2] > 50.0 - 1e-9, axis=1)
    corners = glass.vertices_mm[glass.triangles[top]]
    up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert np.all(up >= 0.0)
    assert 0.5 * up.sum() == pytest.approx(np.pi * (20**2 - 17**2), rel=0.01)
    assert mesh_volume(glass).volume_mm3 > 0.0


def test_a_lofted_solid_is_written_from_the_meshes_that_were_measured(tmp_path, monkeypatch):
    mold = mold_from_shape(Part.makeCylinder(30, 100), "jar", up=(0, 0, 1))
    container = hollow(mold, 3.0, method="lofted")
    monkeypatch.setattr(wall_container, "STL_SECONDS", 0.0)
    container.save(tmp_path / "jar.stl")
    written = importlib.import_module("Mesh").Mesh(str(tmp_path / "jar.stl"))
    assert written.isSolid()
    assert not written.hasSelfIntersections()
    assert written.Volume == pytest.approx(np.pi * (30**2 * 100 - 27**2 * 97), rel=5e-3)


def test_the_mesh_of_a_solid_is_given_up_after_its_time(tmp_path, monkeypatch):
    mold = mold_from_shape(Part.makeCylinder(30, 100), "jar", up=(0, 0, 1))
    container = hollow(mold, 3.0, method="revolved")
    monkeypatch.setattr(wall_container, "STL_SECONDS", 0.0)
    with pytest.raises(GlassWorkbenchError, match=r"jar\.stl: could not be written \(it did not finish within 0 s"):
        container.save(tmp_path / "jar.stl")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", [".step", ".brep", ".FCStd"])
def test_a_container_of_a_mesh_is_no_cad_solid(container, tmp_path, ending):
    with pytest.raises(GlassWorkbenchError, match="as STL only"):
        container.save(tmp_path / f"tube{ending}")
    assert list(tmp_path.iterdir()) == []
