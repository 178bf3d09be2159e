"""The outside of a container that is already hollow becomes one closed solid with a flat finish."""

from pathlib import Path

import numpy as np
import pytest

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import mold_from_shape, outside_mesh, read_mold
from glassworkbench.mold.measures import crossings_on_axis
from glassworkbench.wall.asking.thickness_text import parse_thickness

CONTAINERS = Path(__file__).resolve().parents[2] / "shared" / "molds"
UP = FreeCAD.Vector(0, 0, 1)
RADIUS, HEIGHT, WALL, BASE = 30.0, 90.0, 3.0, 4.0


def tumbler(height=HEIGHT):
    inner = Part.makeCylinder(RADIUS - WALL, height, FreeCAD.Vector(0, 0, BASE))
    return Part.makeCylinder(RADIUS, height).cut(inner)


def round_rimmed():
    """Return a tumbler whose rim is half a torus, so that no flat face parts its inside from its outside."""
    lip = Part.makeTorus(RADIUS - 0.5 * WALL, 0.5 * WALL, FreeCAD.Vector(0, 0, HEIGHT))
    return tumbler().fuse(lip).removeSplitter()


def turned(shape):
    shape = shape.copy()
    shape.rotate(FreeCAD.Vector(5, 6, 7), FreeCAD.Vector(1, 2, 0), 70)
    return shape


def assert_one_closed_solid_with_a_flat_finish(mold):
    solid = mold.solid
    assert solid.isValid()
    assert len(solid.Shells) == 1
    assert solid.Shells[0].isClosed()
    finish = mold.upright.Faces[mold.anatomy.finish_face - 1]
    assert finish.Surface.isPlanar()
    assert finish.isInside(FreeCAD.Vector(0, 0, mold.anatomy.height_mm), 1e-4, True)


@pytest.mark.parametrize("place", [lambda shape: shape, turned])
def test_a_round_rim_is_parted_where_it_is_highest(place):
    mold = mold_from_shape(place(round_rimmed()), "tumbler", outer_shell=True)
    assert_one_closed_solid_with_a_flat_finish(mold)
    assert mold.repairs == ()
    assert mold.anatomy.is_revolved
    lip = 0.5 * WALL
    crest = RADIUS - lip
    quarter = 0.25 * np.pi * lip**2 * 2.0 * np.pi * (crest + 4.0 * lip / (3.0 * np.pi))
    asked = np.pi * (RADIUS**2 * HEIGHT + crest**2 * lip) + quarter
    assert mold.solid.Volume == pytest.approx(asked, rel=1e-6)
    assert mold.anatomy.height_mm == pytest.approx(HEIGHT + lip, abs=1e-9)


def test_a_rim_that_is_not_level_is_cut_flat_and_that_is_told():
    slope = Part.makeBox(200, 200, 50, FreeCAD.Vector(-100, -100, HEIGHT))
    slope.rotate(FreeCAD.Vector(0, 0, HEIGHT), FreeCAD.Vector(1, 0, 0), 1)
    mold = mold_from_shape(tumbler(HEIGHT + 5).cut(slope), "tumbler", outer_shell=True)
    assert_one_closed_solid_with_a_flat_finish(mold)
    assert "cut flat" in mold.repairs[0]
    assert mold.solid.Volume == pytest.approx(np.pi * RADIUS**2 * mold.anatomy.height_mm, rel=1e-9)
    assert mold.anatomy.height_mm > HEIGHT - 2.0


def test_a_thread_that_runs_out_in_the_rim_stays_outside():
    lug = Part.makeBox(6, 8, 10, FreeCAD.Vector(RADIUS - 1.5, -4, HEIGHT - 10))
    mold = mold_from_shape(tumbler().fuse(lug), "jar", outer_shell=True)
    assert_one_closed_solid_with_a_flat_finish(mold)
    assert mold.solid.Volume == pytest.approx(tumbler().fuse(lug).Volume + np.pi * 27**2 * (HEIGHT - BASE), rel=1e-9)


def test_an_inside_that_is_joined_to_the_outside_below_the_rim_is_refused():
    hole = Part.makeCylinder(3, 100, FreeCAD.Vector(0, 0, 40), FreeCAD.Vector(1, 0, 0))
    with pytest.raises(InputError, match="joined apart from the rim"):
        mold_from_shape(tumbler().cut(hole), "tumbler", outer_shell=True)
    with pytest.raises(InputError, match="joined apart from the rim"):
        mold_from_shape(round_rimmed().cut(hole), "tumbler", outer_shell=True)


@pytest.mark.parametrize(
    ("name", "height_mm"),
    [
        ("osk00_bottle.step", 253),
        ("besumit_day02_beverage_bottle.step", 240),
        ("myfreecad_vase.step", 85),
        ("occt_bottle.brep", 55),
    ],
)
def test_the_outside_of_a_real_container_is_a_mold(name, height_mm):
    path = CONTAINERS / name
    if not path.exists():
        pytest.skip("the real containers are not beside this checkout")
    mold = read_mold(path, outer_shell=True)
    assert_one_closed_solid_with_a_flat_finish(mold)
    assert mold.anatomy.height_mm == pytest.approx(height_mm, abs=1e-3)
    mesh, faces = outside_mesh(mold, 0.1)
    assert np.any(faces == mold.anatomy.finish_face)
    # Nothing of the inside is left: on the way down from the mouth nothing is met before the base.
    assert crossings_on_axis(mesh.vertices_mm, mesh.triangles) == pytest.approx([0.0, height_mm], abs=1e-3)


def kinds_in_file(mold, shape):
    """Return the areas of the mold's faces beside those of the file's faces that they are said to be."""
    numbered = zip(mold.solid.Faces, mold.file_faces, strict=True)
    return [(face.Area, shape.Faces[number - 1].Area) for face, number in numbered if number]


def test_the_faces_of_an_outer_shape_keep_the_numbers_of_the_file():
    container = turned(tumbler())
    mold = mold_from_shape(container, "tumbler", outer_shell=True)
    finish = mold.anatomy.finish_face
    assert sorted(mold.file_faces) == sorted(set(mold.file_faces) - {0})
    rim = container.Faces[mold.file_faces[finish - 1] - 1]
    assert rim.Area == pytest.approx(np.pi * (RADIUS**2 - (RADIUS - WALL) ** 2))
    areas = [pair for number, pair in enumerate(kinds_in_file(mold, container), start=1) if number != finish]
    assert len(areas) == 2
    for own, in_file in areas:
        assert own == pytest.approx(in_file)


def test_a_wall_by_face_of_an_outer_shape_counts_the_files_faces():
    container = tumbler()
    base = next(n for n, face in enumerate(container.Faces, start=1) if abs(face.CenterOfMass.z) < 1e-9)
    mold = mold_from_shape(container, "tumbler", outer_shell=True)
    asked = parse_thickness(f"Face{base}=5 else=2").on(mold)
    assert [asked.by_face.thicknesses_mm[k] for k, n in enumerate(mold.file_faces, start=1) if n == base] == [5.0]
    inside = next(n for n in range(1, len(container.Faces) + 1) if n not in mold.file_faces)
    with pytest.raises(InputError, match="no such face outside"):
        parse_thickness(f"Face{inside}=5 else=2").on(mold)
