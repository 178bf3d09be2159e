"""The workbench in a real FreeCAD window, under a virtual screen of its own and with a user folder of its own."""

import json
import os
import re
import shutil
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

from glassworkbench.images import files, read_image

CHECKOUT = Path(__file__).resolve().parent.parent
SECONDS = 90
FREECAD = shutil.which("freecad") or shutil.which("FreeCAD")

pytestmark = pytest.mark.skipif(
    not (FREECAD and shutil.which("xvfb-run") and shutil.which("import")),
    reason="needs FreeCAD's window, xvfb-run and ImageMagick's import",
)


def run_in_window(macro, folder):
    """Run a macro in FreeCAD's window; return the facts it found, its output, and FreeCAD's exit code."""
    home = folder / "home"
    settings = home / "user.cfg"
    environment = os.environ | {
        "FREECAD_USER_HOME": str(home),
        "HOME": str(home),
        "WINDOW_TEST_FOLDER": str(folder),
        "WINDOW_TEST_CHECKOUT": str(CHECKOUT),
        "GLASSWORKBENCH_GLASSES": str(folder / "glasses"),
        "QTWEBENGINE_DISABLE_SANDBOX": "1",
    }
    home.mkdir()
    mods = home / "Mod"
    mods.mkdir()
    (mods / "GlassWorkbench").symlink_to(CHECKOUT)
    settings.write_text(SETTINGS)
    process = subprocess.Popen(
        ["xvfb-run", "-a", "-s", "-screen 0 1280x900x24", FREECAD, str(macro)],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    try:
        output, _ = process.communicate(timeout=SECONDS)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        output, _ = process.communicate()
        pytest.fail(f"the window was not done in {SECONDS} s:\n{output}")
    facts_file = folder / "facts.json"
    assert facts_file.exists(), f"the macro ended early:\n{output}"
    return json.loads(facts_file.read_text()), output, process.returncode


SETTINGS = """<?xml version="1.0" encoding="UTF-8" standalone="no" ?>
<FCParameters><FCParamGroup Name="Root"><FCParamGroup Name="BaseApp"><FCParamGroup Name="Preferences">
<FCParamGroup Name="General"><FCText Name="AutoloadModule">PartWorkbench</FCText></FCParamGroup>
<FCParamGroup Name="Mod"><FCParamGroup Name="Start"><FCBool Name="ShowOnStartup" Value="0"/></FCParamGroup>
</FCParamGroup></FCParamGroup></FCParamGroup></FCParamGroup></FCParameters>
"""
"""Without the start page, which differs between versions and wants the network."""


@pytest.fixture(scope="module")
def main_job(tmp_path_factory):
    folder = tmp_path_factory.mktemp("window")
    facts, output, code = run_in_window(CHECKOUT / "tests" / "window" / "main_job.py", folder)
    assert "error" not in facts, facts["error"] + output
    return {**facts, "output": output, "exit_code": code, "folder": folder}


def test_the_workbench_shows_with_icon_menu_and_toolbar(main_job):
    assert main_job["workbench_icon"]
    assert "&Glass" in main_job["menu"]
    assert list(main_job["toolbar"]) == ["Make container…", "Edit container…", "Glass…", "Show wall", "Render…"]
    assert all(main_job["toolbar"].values()), "a command has no icon"


def test_commands_are_active_when_they_can_do_something(main_job):
    assert not main_job["active_without_selection"]
    assert main_job["active_with_solid"]
    assert not main_job["render_active_with_solid"]


def test_a_wall_that_cannot_be_is_told_in_a_dialog_and_changes_nothing(main_job):
    assert "neck" in main_job["dialog_of_bad_wall"]
    assert "\n" not in main_job["dialog_of_bad_wall"]
    assert main_job["objects_after_bad_wall"] == 0
    assert main_job["undo_after_bad_wall"] == 0


def test_make_container_hollows_the_solid_in_one_step_of_undo(main_job):
    container = main_job["container"]
    assert container["valid"]
    assert container["fault"] == ""
    assert container["minimum_wall"] == pytest.approx(3.0, rel=0.02)
    assert container["weight_grams"] == pytest.approx(container["volume"] / 1000.0 * 2.5, rel=0.01)
    assert 700.0 < container["capacity_ml"] < 850.0
    assert main_job["undo_names"] == ["Make container"]
    assert main_job["mold_hidden"]
    assert main_job["undone"]
    assert main_job["redone"] == container


def test_a_file_of_glasses_joins_the_list_and_the_folder(main_job):
    assert main_job["glass_added"] == "heavy_blue"
    assert (main_job["folder"] / "glasses" / "own.toml").is_file()
    assert "'heavy_blue' is in the catalogue already" in main_job["dialog_of_added_twice"]
    assert main_job["glass_after_adding_and_cancel"] == "flint"


def test_the_glass_shows_while_choosing_and_cancel_takes_it_back(main_job):
    assert main_job["live_colour_differs"]
    assert main_job["transmission_shown"]
    assert main_job["glass_after_cancel"] == "flint"
    assert main_job["colour_after_cancel"]


def test_the_chosen_glass_colours_the_3d_view_in_one_step_of_undo(main_job):
    red, green, blue = main_job["colour"]
    assert main_job["glass"] == "emerald"
    assert green > 1.3 * max(red, blue)
    assert 30 <= main_job["transparency"] <= 80
    assert main_job["undo_after_glass"] == ["Set glass", "Make container"]


def test_the_3d_view_shows_the_wall_in_colours(main_job):
    picture = pixels_of(main_job["folder"] / "wall.png").astype(float)
    # Most of a wall of 3 mm everywhere has the colour of the middle of the scale, a bluish green.
    red, green, blue = np.moveaxis(picture[..., :3], -1, 0)
    assert np.mean((green > 1.5 * red) & (blue > 1.5 * red) & (green > 60)) > 0.1
    assert main_job["display_mode_of_wall"] == "Wall"
    assert main_job["display_mode_after_wall"] == "Flat Lines"


def test_a_legend_stands_beside_the_wall_and_goes_with_it(main_job):
    with_wall, without = (pixels_of(main_job["folder"] / f"{name}.png").astype(int) for name in ("wall", "no_wall"))
    # The bar's lower end is violet, its upper one yellow; both stand in the leftmost tenth of the view.
    left = with_wall[:, :60]
    red, green, blue = np.moveaxis(left, -1, 0)
    violet, yellow = (blue > 60) & (green < 30) & (red > 50), (red > 200) & (green > 190) & (blue < 90)
    assert violet.any()
    assert yellow.any()
    assert np.flatnonzero(yellow.any(axis=1)).max() < np.flatnonzero(violet.any(axis=1)).min()
    red, green, blue = np.moveaxis(without[:, :60], -1, 0)
    assert not ((red > 200) & (green > 190) & (blue < 90)).any()


def test_freecad_stays_usable_while_a_picture_gets_better(main_job):
    assert main_job["made_while_running"]
    assert main_job["longest_pause"] < 1.0
    assert main_job["passes"] >= 1
    assert main_job["active_view_is_3d"]
    assert "99 %" in main_job["status"]


def test_the_window_shows_green_glass(main_job):
    screen = pixels_of(main_job["folder"] / "window.png")
    left, top, width, height = main_job["canvas"]
    canvas = screen[top : top + height, left : left + width]
    rows, columns = main_job["picture_size"]
    shown = min(width, round(height * columns / rows))
    picture = canvas[:, (width - shown) // 2 : (width + shown) // 2]
    red, green, blue = np.moveaxis(picture.astype(float), 2, 0)
    is_green = (green > 1.15 * red) & (green > 1.15 * blue) & (green > 30)
    assert 0.05 < is_green.mean() < 0.6, "the bottle covers a part of the picture"
    middle, edge = is_green[:, shown // 3 : -shown // 3], is_green[:, : shown // 10]
    assert middle.mean() > 0.2
    assert edge.mean() < 0.02
    assert green[is_green].std() > 10.0, "glass is not evenly coloured"


def test_the_saved_pictures_are_what_the_window_shows(main_job):
    folder, (rows, columns) = main_job["folder"], main_job["picture_size"]
    saved = read_image(folder / "saved.exr")
    assert saved.pixels.shape == (rows, columns, 3)
    assert saved.metadata["glass"] == "emerald"
    assert saved.metadata["wall"] == "3"
    np.testing.assert_array_equal(pixels_of(folder / "saved.png"), saved.display())


def test_a_click_in_the_picture_draws_the_ray_in_the_3d_view(main_job):
    with_ray, without = (pixels_of(main_job["folder"] / f"{name}.png").astype(int) for name in ("ray", "no_ray"))
    changed = np.abs(with_ray - without).max(axis=2) > 60
    assert 100 < changed.sum() < 20000, "a line, and nothing else"
    assert re.match(r"The ray meets ([4-9]|\d\d) surfaces", main_job["ray"]["status"])
    assert main_job["ray"]["mode"] == "Ray"


def test_a_drag_over_the_picture_refines_that_part_alone(main_job):
    refined = main_job["refined"]
    assert refined["started"]
    assert refined["errors"][1] < 0.5 * refined["errors"][0]
    assert refined["rest_is_same"]
    rows, columns = main_job["picture_size"]
    assert refined["part"] == pytest.approx([columns * 3 / 8, rows / 2, columns / 4, rows / 8], abs=3)


def test_another_wall_recomputes(main_job):
    assert main_job["thicker"]["minimum_wall"] == pytest.approx(4.0, rel=0.02)
    assert main_job["thicker"]["weight_grams"] > 1.2 * main_job["container"]["weight_grams"]
    assert main_job["thicker"]["volume"] > 1.2 * main_job["container"]["volume"]


def test_a_failed_recompute_keeps_the_shape_and_says_why(main_job):
    assert "60 mm" in main_job["too_thick"]["fault"]
    assert main_job["too_thick"]["shape_kept"]
    assert main_job["undone_too_thick"] == {"fault": "", "wall": 3.0}
    assert main_job["too_thick"]["fault"] in main_job["report_view"]


def test_save_close_and_reopen_keep_the_container_alive(main_job):
    assert main_job["reopened"] == main_job["thicker"] | {
        "volume": pytest.approx(main_job["thicker"]["volume"], rel=1e-4)
    }
    assert main_job["recomputed_after_reopen"] == 0
    assert main_job["thinner_after_reopen"]["volume"] == pytest.approx(main_job["container"]["volume"], rel=1e-4)


def test_cancel_stops_soon_and_closing_the_window_leaves_no_thread(main_job):
    assert main_job["cancel_seconds"] < 2.0
    assert main_job["status_after_cancel"] == "Cancelled"
    assert main_job["thread_ended_with_window"]


def test_nothing_is_traced_back_and_freecad_ends_well(main_job):
    assert "Traceback" not in main_job["report_view"] + main_job["output"]
    assert main_job["exit_code"] == 0


def pixels_of(path):
    """The picture as uint8 (h, w, 3)."""
    values, *_ = files.read(path)
    return np.rint(255.0 * values[:, :, :3]).astype(np.uint8)
