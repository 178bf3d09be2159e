"""The map of the wall: its values against known walls, and its picture."""

import builtins
from pathlib import Path

import numpy as np
import pytest

from glassworkbench.cli import main
from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import mold_from_shape, read_mold
from glassworkbench.mold.tessellation import tessellate
from glassworkbench.wall import hollow
from glassworkbench.wall.measuring.map_picture import save_picture
from glassworkbench.wall.measuring.outside import outside
from glassworkbench.wall.measuring.wall_map import wall_map

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def beside():
    """The map of a can whose cavity stands half a millimetre beside the axis, over a floor of 4 mm."""
    mold = mold_from_shape(Part.makeCylinder(30, 100), "can", up=(0, 0, 1))
    inside = tessellate(Part.makeCylinder(27, 96, FreeCAD.Vector(0.5, 0, 4)), 0.02)
    return wall_map(mold, inside, outside(mold, lambda points, faces: np.full(len(points), 3.0)))


def test_thickness_is_that_of_the_wall_behind_each_point(beside):
    points, thickness = beside.corners_mm.reshape(-1, 3), beside.thickness_mm.ravel()
    side = (np.hypot(points[:, 0], points[:, 1]) > 29.9) & (points[:, 2] > 5.0) & np.isfinite(thickness)
    expected = np.hypot(points[side, 0] - 0.5, points[side, 1]) - 27.0
    assert side.sum() > 1000
    assert np.abs(thickness[side] - expected).max() < 5e-3
    floor = np.hypot(points[:, 0], points[:, 1]) < 26.0
    assert thickness[floor & (points[:, 2] < 1e-9)] == pytest.approx(4.0, abs=1e-3)


def test_over_the_mouth_there_is_no_wall(beside):
    centres = beside.corners_mm.mean(axis=1)
    assert np.all(np.isnan(beside.thickness_mm[centres[:, 2] > 100.0 - 1e-6]))
    assert np.linalg.norm(np.diff(beside.corners_mm, axis=1), axis=2).max() < 0.012 * 100 + 1e-9


def test_over_height_it_reaches_from_the_thinnest_to_the_thickest_wall(beside):
    profile = beside.over_height
    middle = (profile.heights_mm > 10.0) & (profile.heights_mm < 95.0)
    assert profile.got_mm[middle, 0] == pytest.approx(2.5, abs=0.02)
    assert profile.got_mm[middle, 1] == pytest.approx(3.5, abs=0.02)
    assert profile.asked_mm[np.isfinite(profile.asked_mm)] == pytest.approx(3.0)
    low, high = beside.span_mm()
    assert low == pytest.approx(2.5, abs=0.05)
    # The floor is 4 mm thick, and the heel's corner 5 mm away from the inside.
    assert 4.0 <= high < 5.0


def test_a_level_floor_has_its_wall_at_its_height_and_nothing_is_told_below(beside):
    profile = beside.over_height
    there = np.isfinite(profile.got_mm[:, 0])
    assert np.array_equal(there, np.isfinite(profile.asked_mm[:, 1]))
    lowest = np.flatnonzero(there)[0]
    assert profile.edges_mm[lowest] <= 4.0 <= profile.edges_mm[lowest + 1]
    assert profile.got_mm[lowest, 1] == pytest.approx(4.0, abs=1e-3)


def test_got_meets_asked_where_the_wall_steps_at_a_sharp_edge():
    box = Part.makeBox(60, 60, 100, FreeCAD.Vector(-30, -30, 0)).fuse(Part.makeCylinder(14, 130)).removeSplitter()
    mold = mold_from_shape(box, "square", up=(0, 0, 1))
    side = 1 + next(i for i, face in enumerate(mold.upright.Faces) if abs(face.CenterOfMass.x + 30) < 1e-6)
    profile = hollow(mold, f"Face{side}=5 else=2").map().over_height
    there = np.isfinite(profile.got_mm[:, 0])
    assert np.abs(profile.got_mm - profile.asked_mm)[there].max() < 0.02
    middle = (profile.heights_mm > 5.0) & (profile.heights_mm < 95.0)
    assert profile.got_mm[middle] == pytest.approx(np.tile([2.0, 5.0], (middle.sum(), 1)), abs=0.02)


def test_what_stands_a_rounding_error_below_the_ground_is_wall():
    leaning = Part.makeCylinder(30, 100, FreeCAD.Vector(1, 2, 3), FreeCAD.Vector(2, 1, -1))
    mold = mold_from_shape(leaning, "can", up=(2, 1, -1))
    inside = tessellate(Part.makeCylinder(27, 97, FreeCAD.Vector(0, 0, 3)), 0.02)
    found = wall_map(mold, inside, outside(mold, lambda points, faces: np.full(len(points), 3.0)))
    assert found.corners_mm[:, :, 2].min() < 0.0
    assert np.all(np.isfinite(found.thickness_mm[found.corners_mm[:, :, 2].max(axis=1) < 90.0]))


@pytest.mark.parametrize("wall", ["3", "3 bore=18.5", "@examples/walls/wine_bottle_over_height.csv"])
def test_around_a_round_container_the_profile_is_one_line_up_to_the_finish(wall, monkeypatch):
    monkeypatch.chdir(ROOT)
    profile = hollow(read_mold("examples/molds/wine_bottle.step"), wall).map().over_height
    above_push_up = (profile.heights_mm > 30.0) & np.isfinite(profile.got_mm[:, 0])
    assert profile.heights_mm[above_push_up][-1] > 290.0
    # At the end of a bore two outer points decide alike, each with a thickness of its own.
    assert np.ptp(profile.asked_mm[above_push_up], axis=1).max() < 0.1
    assert np.abs(profile.got_mm - profile.asked_mm)[above_push_up].max() < 0.02
    neck = profile.got_mm[above_push_up & (profile.heights_mm > 200.0), 0]
    assert np.diff(neck).min() > -0.02


def test_the_picture_is_written_and_shows_more_than_paper(beside, tmp_path):
    path = tmp_path / "wall.png"
    save_picture(beside, "can", path)
    assert path.read_bytes()[1:4] == b"PNG"
    from matplotlib.image import imread

    pixels = imread(path)[:, :, :3]
    assert 0.1 < np.mean(np.ptp(pixels, axis=2) > 0.1) < 0.9


def test_without_matplotlib_the_user_reads_what_to_install(tmp_path, monkeypatch, capsys):
    real = builtins.__import__

    def without(name, *arguments, **options):
        if name.split(".")[0] == "matplotlib":
            raise ImportError(name)
        return real(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", without)
    mold = tmp_path / "can.brep"
    Part.makeCylinder(30, 100).exportBrep(str(mold))
    out = tmp_path / "out.step"
    assert main(["hollow", str(mold), "--wall", "3", "-o", str(out), "--map", str(tmp_path / "wall.png")]) == 2
    assert "python3-matplotlib" in capsys.readouterr().err
    assert not out.exists()


def test_a_picture_of_another_kind_is_refused(beside, tmp_path):
    with pytest.raises(InputError, match="bmp"):
        save_picture(beside, "can", tmp_path / "wall.bmp")


@pytest.mark.parametrize("fill", ["750", "full", "-3mm", "0ml"])
def test_a_fill_point_needs_a_unit(tmp_path, capsys, fill):
    mold = tmp_path / "can.brep"
    Part.makeCylinder(30, 100).exportBrep(str(mold))
    command = ["hollow", str(mold), "--wall", "3", "-o", str(tmp_path / "out.step"), f"--fill-point={fill}"]
    assert main(command) == 2
    assert "--fill-point" in capsys.readouterr().err
