"""The macro that the README shows, run by FreeCAD as a user's FreeCAD runs it."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

import glassworkbench as gw
from glassworkbench.images import read_image

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
