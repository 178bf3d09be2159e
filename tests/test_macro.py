"""The macro that the README shows, run by FreeCAD as a user's FreeCAD runs it."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import glassworkbench as gw
from glassworkbench.freecad import Part
from glassworkbench.images import read_image
from glassworkbench.mold import mold_from_shape
from glassworkbench.wall import FaceThickness, RegionalThickness, TabulatedThickness

ROOT = Path(__file__).resolve().parent.parent
MACRO = ROOT / "examples" / "macro.py"
FREECADCMD = shutil.which(os.environ.get("FREECADCMD", "freecadcmd"))


@pytest.mark.skipif(FREECADCMD is None, reason="freecadcmd is not installed")
def test_the_macro_runs_in_freecadcmd(tmp_path):
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    # -P stands for the workbench being in FreeCAD's Mod folder; FreeCAD 1.0 does not look at PYTHONPATH.
    done = subprocess.run(
        [FREECADCMD, "-P", str(ROOT), str(MACRO)],
        cwd=tmp_path,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=300,
    )
    picture = tmp_path / "bottle.png"
    assert picture.is_file(), done.stdout + done.stderr
    image = read_image(picture)
    assert image.pixels.shape == (320, 240, 3)
    assert image.metadata["glass"] == "emerald"
    # Emerald glass in the middle of the picture, the grey of the studio at its edge.
    assert image.pixels[150:250, 110:130, 1].mean() > 1.5 * image.pixels[150:250, 110:130, 0].mean()
    assert image.pixels[150:250, :5].std(axis=2).max() < 0.1


def test_the_readme_shows_the_macro():
    assert MACRO.read_text() in (ROOT / "README.md").read_text()


def test_every_name_of_the_macro_api_is_there():
    pytest.importorskip("glassworkbench.freecad")
    for name in gw.__all__:
        assert getattr(gw, name) is not None
    assert set(gw.__all__) <= set(dir(gw))


def test_the_macro_api_says_so_when_a_name_is_wrong():
    with pytest.raises(AttributeError, match="rendr"):
        gw.rendr  # noqa: B018


def test_no_room_hides_a_verb():
    rooms = {path.stem for path in (ROOT / "glassworkbench").iterdir()}
    assert not rooms & set(gw.__all__)


@pytest.fixture(scope="module")
def can():
    return mold_from_shape(Part.makeCylinder(30, 100), "can", up=(0, 0, 1))


@pytest.mark.parametrize("wall", [{"body": 2}, [1, 2], None, True, np.array([1.0, 2.0])])
def test_what_is_no_thickness_is_refused_in_one_sentence(can, wall):
    with pytest.raises(gw.InputError, match=r"^wall: .* is no thickness; give mm as a number"):
        gw.hollow(can, wall)


@pytest.mark.parametrize(
    "call",
    [
        lambda: gw.hollow("jar.step", 2),
        lambda: gw.read_mold(None),
        lambda: gw.read_mold(ROOT / "examples" / "molds" / "jar.step", scale_to_mm="x"),
        lambda: gw.inspect(5),
        lambda: gw.read_container(None),
        lambda: gw.read_scene(None),
        lambda: gw.read_image(None),
        lambda: gw.find_glass(None),
        lambda: gw.station("studio", None, "flint"),
        lambda: gw.render(None),
        lambda: gw.read_golden(None),
        lambda: gw.compare(None, None),
        lambda: RegionalThickness(3),
        lambda: RegionalThickness(("body",)),
        lambda: FaceThickness(3, 2.0),
        lambda: TabulatedThickness(1, 2),
    ],
)
def test_an_argument_of_another_kind_is_refused_in_one_sentence(call):
    with pytest.raises(gw.InputError, match=": "):
        call()
