import contextlib
import dataclasses
import fcntl
import json
import os
import pty
import re
import shutil
import signal
import struct
import subprocess
import termios
import time
from pathlib import Path

import numpy as np
import pytest

from glassworkbench import __version__
from glassworkbench.cli import main
from glassworkbench.images import read_image
from glassworkbench.scene.file import read_scene
from glassworkbench.tracer import checkpoint, render, rendering

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "bin" / "glassworkbench"
BALL = str(ROOT / "examples" / "scenes" / "ball_lens.toml")
TUMBLER = str(ROOT / "examples" / "scenes" / "tumbler.toml")
WINE_BOTTLE = str(ROOT / "examples" / "molds" / "wine_bottle.step")
VERBS = ("inspect", "hollow", "render", "accuracy", "compare", "glasses", "stations", "defects")
FREECADCMD = shutil.which("freecadcmd")


def told(capsys):
    """The one sentence on stderr, checked to be one, with nothing on stdout."""
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("glassworkbench: ")
    assert "Traceback" not in err
    return err


def run(*arguments, **environment):
    return subprocess.run(
        [PROGRAM, *arguments],
        env=os.environ | environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=300,
    )


def test_a_scene_file_becomes_an_image_in_every_format_asked(tmp_path, capsys):
    outputs = [tmp_path / "ball.png", tmp_path / "ball.exr"]
    arguments = [word for output in outputs for word in ("-o", str(output))]
    assert main(["render", BALL, *arguments, "--size", "40x40", "--report", str(tmp_path / "r.json")]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.startswith(", ".join(map(str, outputs)))
    image = read_image(outputs[1])
    assert image.pixels.shape == (40, 40, 3)
    assert image.metadata["scene"] == "ball_lens.toml"
    assert image.metadata["version"] == __version__
    # The ball turns the picture over: panel above beside it, below within it.
    assert image.pixels[5, 2, 0] == pytest.approx(1.0)
    assert image.pixels[35, 2, 0] == pytest.approx(0.15)
    assert image.pixels[10, 20, 0] < 0.3 < 0.8 < image.pixels[26, 20, 0]
    assert np.isclose(image.depth_mm[20, 20], 380.0, atol=0.5)
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["size"] == [40, 40]
    assert report["leaks"] == 0
    assert len(report["input"]["sha256"]) == 64
    assert {effect["name"] for effect in report["effects"]} >= {"absorption"}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ball.exr", "ball.png", "r.json"]


def test_json_answers_with_the_report_and_quiet_with_nothing(tmp_path, capsys):
    assert main(["render", BALL, "-o", str(tmp_path / "x.png"), "--size", "8x8", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["camera_rays"] > 0
    assert main(["--quiet", "render", BALL, "-o", str(tmp_path / "x.png"), "--size", "8x8"]) == 0
    assert capsys.readouterr().out == ""


def test_an_effect_is_switched_off(tmp_path, capsys):
    arguments = ["render", BALL, "-o", str(tmp_path / "x.png"), "--size", "8x8", "--json", "--effect", "absorption=off"]
    assert main(arguments) == 0
    (absorption,) = json.loads(capsys.readouterr().out)["effects"]
    assert absorption["on"] is False


def test_exposure_brightens_a_picture(tmp_path):
    for name, stops in (("dark", "-1"), ("bright", "1")):
        assert main(["render", BALL, "-o", f"{tmp_path}/{name}.png", "--size", "8x8", "--exposure", stops]) == 0
    dark, bright = (read_image(tmp_path / f"{name}.png") for name in ("dark", "bright"))
    assert dark.metadata["exposure"] == "-1"
    assert np.allclose(dark.pixels[7, 0], bright.pixels[7, 0], atol=0.01)


@pytest.mark.parametrize("verb", VERBS)
def test_help_of_each_verb_shows_an_example(capsys, verb):
    assert main([verb, "--help"]) == 0
    out, err = capsys.readouterr()
    assert f"Example: glassworkbench {verb}" in " ".join(out.split())
    assert err == ""


def test_help_names_every_verb_and_version_the_version(capsys):
    assert main(["--help"]) == 0
    out = capsys.readouterr().out
    assert all(f"  {verb} " in out for verb in VERBS)
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"GlassWorkbench {__version__}\n"


def test_catalogues_are_listed(capsys):
    assert main(["glasses"]) == 0
    assert "emerald" in capsys.readouterr().out
    assert main(["glasses", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert len(listed["glasses"][0]["absorption_per_mm"]) == 3
    assert "scatters" in listed["refused"]["opal"]
    assert main(["stations"]) == 0
    listed = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert listed[0] == "studio"
    assert {"sidewall", "dark_field", "gradient", "stripes", "base", "finish"} <= set(listed)


def test_one_glass_is_told_with_colour_density_index_and_sources(capsys):
    assert main(["glasses", "amber"]) == 0
    told = capsys.readouterr().out
    for part in ("n_d = 1.52338", "2.5 g/cm3", "L* ", "Fe2O3=0.3", "Rubin", "assumed"):
        assert part in told
    assert main(["glasses", "beer EBC=20", "--json"]) == 0
    (beer,) = json.loads(capsys.readouterr().out)["fillings"]
    assert beer["recipe"] == {"EBC": 20.0}
    assert main(["glasses", "ambre"]) == 2
    assert "did you mean 'amber'" in capsys.readouterr().err


def test_glasses_are_drawn(tmp_path, capsys):
    pictures = tmp_path / "swatches.png", tmp_path / "curves.svg"
    assert main(["glasses", "--swatches", str(pictures[0]), "--plot", str(pictures[1])]) == 0
    assert capsys.readouterr().out == ""
    assert all(path.stat().st_size > 10_000 for path in pictures)
    assert main(["glasses", "--swatches", str(tmp_path / "swatches.doc")]) == 2
    assert "the ending '.doc' is not known" in capsys.readouterr().err


def test_a_station_is_previewed(tmp_path, capsys):
    assert main(["stations", "--preview", "sidewall", "-o", str(tmp_path / "x.png")]) == 0
    drawn = read_image(tmp_path / "x.png")
    height, width = drawn.pixels.shape[:2]
    assert width > 2 * height > 800
    # The tumbler in the last third, dark at its edge on a bright panel.
    seen = drawn.pixels[height // 2, -width // 5 :].min(axis=1)
    assert seen.min() < 0.2 < 0.9 < seen.max()
    assert capsys.readouterr().out == ""


MOLD = ["render", WINE_BOTTLE, "-o", "{folder}/x.png", "--wall", "3"]
SCENE = ["render", BALL, "-o", "{folder}/x.png"]
HOLLOW = ["hollow", WINE_BOTTLE, "-o", "{folder}/x.step"]


def in_folder(word, folder):
    return word.replace("{folder}", str(folder)).replace("{name}", folder.name)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "arguments are required: VERB"),
        (["rendr"], "did you mean 'render'"),
        (["render"], "arguments are required"),
        ([*SCENE, "--tolerence", "0.1"], "did you mean '--tolerance'"),
        ([*SCENE, "more.toml"], "'more.toml' is one argument too many"),
        ([*MOLD, "--glass", "emrald"], "did you mean 'emerald'"),
        ([*MOLD, "--station", "sidewal"], "did you mean 'sidewall'"),
        ([*MOLD, "--fill", "watr"], "did you mean 'water'"),
        (["render", WINE_BOTTLE, "-o", "{folder}/x.png"], "as --wall 3"),
        ([*SCENE, "--wall", "3"], "--wall: the scene file"),
        ([*SCENE, "--defects", "seedy:1"], "--defects: the scene file"),
        ([*MOLD, "--defects", "sedy:1"], "did you mean 'seedy'"),
        ([*SCENE, "--size", "40"], "write width and height"),
        ([*SCENE, "--size", "0x40"], "0x40 pixels"),
        ([*SCENE, "--size=-4x40"], "write width and height"),
        ([*SCENE, "--size", "65536x65536"], "65536x65536 pixels"),
        ([*MOLD, "--size", "0x0"], "0x0 pixels"),
        ([*MOLD, "--size", "10x0"], "10x0 pixels"),
        ([*SCENE, "-o", "{folder}/x.png"], "two outputs have this name"),
        ([*SCENE, "-o", "{folder}/../{name}/x.png"], "two outputs have this name"),
        ([*SCENE, "--report", "{folder}/x.png"], "two outputs have this name"),
        (["render", "{folder}", "-o", "{folder}/x.png"], "it is a folder"),
        ([*SCENE, "--finish-height", "30"], "--finish-height: the scene file"),
        ([*SCENE, "--tolerance", "0"], "--tolerance: must be above 0"),
        ([*SCENE, "--tolerance", "nan"], "--tolerance: must be above 0"),
        ([*SCENE, "--tolerance", "small"], "--tolerance"),
        ([*SCENE, "--tolerance", "0.1", "--seconds", "3"], "not allowed with"),
        ([*SCENE, "--seconds", "-1"], "--seconds: must be above 0"),
        ([*SCENE, "--threads", "0"], "--threads: must be above 0"),
        ([*SCENE, "--exposure", "inf"], "--exposure"),
        ([*SCENE, "--effect", "absorbtion=off"], "did you mean 'absorption'"),
        ([*SCENE, "--effect", "absorption"], "NAME=on or NAME=off"),
        ([*SCENE, "--effects", "some"], "invalid choice"),
        (["render", BALL, "-o", "{folder}/x.bmp"], "'.bmp' is not known"),
        (["render", BALL, "-o", "{folder}/no/x.png"], "there is no folder"),
        (["render", BALL, "-o", "/proc/x.png"], "nothing can be written"),
        (["stations", "--preview", "studio"], "belong together"),
        (["stations", "--preview", "studi", "-o", "{folder}/x.png"], "did you mean 'studio'"),
        ([*SCENE, "--report", "{folder}/no/r.json"], "there is no folder"),
        (["render", "{folder}/missing.toml", "-o", "{folder}/x.png"], "there is no such file"),
    ],
)
def test_bad_input_is_told_in_one_sentence_and_leaves_nothing(tmp_path, capsys, arguments, message):
    assert main([in_folder(word, tmp_path) for word in arguments]) == 2
    assert message in told(capsys)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([*HOLLOW, "--wall", "0"], "above 0"),
        ([*HOLLOW, "--wall", "-1"], "above 0"),
        ([*HOLLOW, "--wall", "nan"], "finite"),
        ([*HOLLOW, "--wall", "thick"], "wall"),
        ([*HOLLOW, "--wall", "100"], "wall"),
        ([*HOLLOW, "--wall", "@missing.csv"], "missing.csv"),
        ([*HOLLOW, "--wall", "3", "--method", "revolve"], "did you mean 'revolved'"),
        (["hollow", WINE_BOTTLE, "--wall", "3", "-o", "{folder}/x.igs"], "'.igs' is not known"),
        (["hollow", "{folder}/missing.step", "--wall", "3", "-o", "{folder}/x.step"], "there is no such file"),
        (["render", "{folder}/missing.step", "--wall", "3", "-o", "{folder}/x.png"], "there is no such file"),
        (["render", WINE_BOTTLE, "--wall", "nan", "-o", "{folder}/x.png"], "finite"),
        ([*HOLLOW, "--wall", "3", "--scale", "0.001"], "--scale 1000"),
        ([*HOLLOW, "--wall", "3", "--scale", "nan"], "--scale: must be above 0"),
        ([*HOLLOW, "--wall", "3", "--tolerance", "0"], "--tolerance: must be above 0"),
        ([*HOLLOW, "--wall", "3", "--seconds", "0"], "--seconds: must be above 0"),
        ([*HOLLOW, "--wall", "3", "--finish-height", "-1"], "--finish-height: must be above 0"),
        ([*HOLLOW, "--wall", "3", "--finish-height", "5000"], "--finish-height"),
        ([*HOLLOW, "--wall", "1e-9"], "at least 0.01 mm"),
        ([*HOLLOW, "--wall", "3", "--report", "{folder}/x.step"], "two outputs have this name"),
        (["hollow", "{folder}", "--wall", "3", "-o", "{folder}/x.step"], "it is a folder"),
        (["inspect", "{folder}"], "it is a folder"),
        (["inspect", WINE_BOTTLE, "--scale", "0"], "--scale: must be above 0"),
        (["inspect", "{folder}/missing.step"], "there is no such file"),
    ],
)
def test_bad_molds_and_walls_are_told_in_one_sentence_and_leave_nothing(tmp_path, capsys, arguments, message):
    pytest.importorskip("glassworkbench.freecad")
    assert main([in_folder(word, tmp_path) for word in arguments]) == 2
    assert message in told(capsys)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["mold.step", "link.step"])
def test_an_input_is_never_overwritten(tmp_path, capsys, name):
    mold, link = tmp_path / "mold.step", tmp_path / "link.step"
    shutil.copy(WINE_BOTTLE, mold)
    link.symlink_to(mold)
    for output in (["-o", str(tmp_path / name)], ["-o", str(tmp_path / "x.step"), "--report", str(tmp_path / name)]):
        assert main(["hollow", str(mold), "--wall", "3", *output]) == 2
        assert "it is read from" in told(capsys)
    assert mold.read_bytes() == Path(WINE_BOTTLE).read_bytes()
    assert link.is_symlink()
    assert not (tmp_path / "x.step").exists()


def test_a_scene_is_never_overwritten(tmp_path, capsys):
    scene = Path(shutil.copy(BALL, tmp_path))
    assert main(["render", str(scene), "-o", str(tmp_path / "x.png"), "--report", str(scene)]) == 2
    assert "it is read from" in told(capsys)
    assert scene.read_bytes() == Path(BALL).read_bytes()


@pytest.mark.parametrize("more", ["", " linear", " bore=18.5"])
def test_a_table_of_the_wall_is_never_overwritten(tmp_path, capsys, more):
    table = tmp_path / "wall.csv"
    table.write_text("height_mm,thickness_mm\n0,3\n300,3\n")
    arguments = ["hollow", WINE_BOTTLE, "--wall", f"@{table}{more}", "-o", str(tmp_path / "x.step")]
    assert main([*arguments, "--report", str(table)]) == 2
    assert "it is read from" in told(capsys)
    assert table.read_text().startswith("height_mm")


@pytest.fixture
def dome(tmp_path):
    """A STEP file of a cylinder 60 mm high under half a ball of radius 20 mm, so without a mouth."""
    part = pytest.importorskip("glassworkbench.freecad").Part
    path = tmp_path / "dome.step"
    ball = part.makeSphere(20)
    ball.translate((0, 0, 60))
    part.makeCylinder(20, 60).fuse(ball).removeSplitter().exportStep(str(path))
    return path


def test_the_users_finish_height_cuts_a_mold_without_a_mouth(dome, capsys):
    assert main(["inspect", str(dome), "--json", "--finish-height", "70"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["faults"] == []
    assert found["finish_height_mm"] == pytest.approx(70.0, abs=1e-9)
    assert main(["hollow", str(dome), "--wall", "3", "--finish-height", "70", "-o", str(dome.with_name("c.stl"))]) == 0


def test_a_hollow_container_is_inspected_by_its_outer_shell(tmp_path, capsys):
    part = pytest.importorskip("glassworkbench.freecad").Part
    outside, inside = part.makeCylinder(30, 100), part.makeCylinder(27, 100)
    inside.translate((0, 0, 4))
    path = tmp_path / "tumbler.step"
    outside.cut(inside).exportStep(str(path))
    assert main(["inspect", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["hollow"] is True
    assert main(["inspect", str(path), "--json", "--outer-shell"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["hollow"] is True
    assert found["regions"]
    assert main(["hollow", str(path), "--wall", "3", "-o", str(tmp_path / "x.step")]) == 2
    assert "--outer-shell" in told(capsys)


def test_a_round_mold_is_inspected_in_plain_words(capsys):
    assert main(["inspect", WINE_BOTTLE]) == 0
    out = capsys.readouterr().out
    lines = {line[:20].strip(): line[21:] for line in out.splitlines()}
    assert lines["round"] == "yes, a body of revolution"
    assert lines["mouth"] == "face 18"
    assert out.index("finish from") < out.index("neck from") < out.index("base from")
    assert "7\N{NO-BREAK SPACE}surfaces\N{NO-BREAK SPACE}of\N{NO-BREAK SPACE}revolution" in lines["faces"]
    assert "departure" not in out


def test_what_stands_out_from_a_round_mold_is_told_with_its_place(capsys):
    assert main(["inspect", str(ROOT / "examples" / "molds" / "jar.step")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert re.search(r"round nearly: it departs from a body of revolution by up to 1\.5 mm, the most at height", out)


def test_an_axis_that_is_rounded_is_told_without_a_minus_zero():
    number = pytest.importorskip("glassworkbench.mold.inspection_words").number
    assert [number(value) for value in (-8.88e-16, -1.0, 0.25, 1234567.8)] == ["0", "-1", "0.25", "1234568"]


@pytest.mark.parametrize("asked", [["--tolerance", "0.01"], ["--seconds", "1"]])
def test_a_tolerance_that_was_not_met_is_told(tmp_path, capsys, monkeypatch, asked):
    def missing(*arguments, **options):
        image = render(*arguments, **options)
        report = dict(image.report) | {"tolerance": 0.01}
        report["certificate"] = dict(report["certificate"]) | {"total_p99": 0.0387}
        return dataclasses.replace(image, report=report)

    monkeypatch.setattr("glassworkbench.cli.render", missing)
    assert main(["render", BALL, "-o", str(tmp_path / "x.png"), "--size", "8x8", *asked]) == 0
    out = capsys.readouterr().out
    assert "99 % of pixels within 0.0387" in out
    assert ("(asked 0.01)" in out) == ("--tolerance" in asked)


def test_without_the_native_tracer_one_sentence_says_so(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("glassworkbench.tracer.native.available", lambda: False)
    arguments = ["render", BALL, "-o", str(tmp_path / "x.png"), "--size", "4x4", "--tolerance", "0.5"]
    assert main(arguments) == 0
    err = capsys.readouterr().err
    assert err.startswith("glassworkbench: the native tracer is not built")
    assert err.count("\n") == 1
    assert main([*arguments, "--quiet"]) == 0
    assert capsys.readouterr().err == ""


def test_a_traceback_is_shown_only_when_asked_for(tmp_path, capsys):
    arguments = ["render", str(tmp_path / "missing.toml"), "-o", str(tmp_path / "x.png")]
    assert main([*arguments, "--verbose"]) == 2
    assert "Traceback" in capsys.readouterr().err


def test_an_unexpected_fault_is_a_failure_without_traceback(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("glassworkbench.cli.render", lambda *_, **__: 1 / 0)
    assert main(["render", BALL, "-o", str(tmp_path / "x.png")]) == 1
    assert "ZeroDivisionError" in told(capsys)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("route", ["module", "freecadcmd"])
def test_the_program_runs_from_anywhere_with_any_names(tmp_path, route):
    if route == "freecadcmd" and FREECADCMD is None:
        pytest.skip("freecadcmd is not installed")
    folder = tmp_path / "Gläser & more"
    folder.mkdir()
    program = folder / "gw"
    program.symlink_to(PROGRAM)
    shutil.copy(BALL, folder / "die Kugel.toml")
    environment = os.environ | ({"FREECADCMD": FREECADCMD} if route == "freecadcmd" else {})
    command = [program, "render", "die Kugel.toml", "-o", "x y.png", "--size", "8x8"]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0
    assert done.stderr == ""
    assert done.stdout.startswith("x y.png: 8x8")
    assert (folder / "x y.png").is_file()
    command[2] = "die Kugl.toml"
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr == "glassworkbench: die Kugl.toml: there is no such file; check the path\n"


@pytest.mark.parametrize("route", ["module", "freecadcmd"])
def test_a_mold_becomes_a_container_and_a_picture(tmp_path, route):
    pytest.importorskip("glassworkbench.freecad")
    if route == "freecadcmd" and FREECADCMD is None:
        pytest.skip("freecadcmd is not installed")
    environment = {"FREECADCMD": FREECADCMD} if route == "freecadcmd" else {}
    wall, report = tmp_path / "wall.json", tmp_path / "render.json"
    done = run("hollow", WINE_BOTTLE, "--wall", "3", "-o", tmp_path / "c.step", "--report", wall, **environment)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "c.step").read_text().startswith("ISO-10303-21")
    facts = json.loads(wall.read_text())
    assert facts["wall"]["asked"] == "3"
    assert facts["wall"]["min_mm"] == pytest.approx(3.0, abs=0.1)
    picture = tmp_path / "bottle.exr"
    look = ["--wall", "3", "--glass", "emerald", "--station", "sidewall", "--size", "48x64", "--tolerance", "0.1"]
    done = run("render", WINE_BOTTLE, *look, "-o", picture, "--report", report, **environment)
    assert (done.returncode, done.stderr) == (0, "")
    image = read_image(picture)
    expected = {"mold": "wine_bottle.step", "wall": "3", "glass": "emerald", "station": "sidewall"}
    assert expected.items() <= image.metadata.items()
    assert {"tolerance", "seconds", "effects", "version"} <= set(image.metadata)
    assert image.pixels[32, 14] == pytest.approx(np.ones(3))
    assert image.pixels[32, 24, 1] > 1.5 * image.pixels[32, 24, 0] > 0.0
    assert json.loads(report.read_text())["leaks"] == 0


def test_scene_files_render_without_any_freecad(tmp_path):
    code = (
        "import sys; from glassworkbench.cli import main; code = main(sys.argv[1:]); "
        "assert not {'FreeCAD', 'Part'} & set(sys.modules); sys.exit(code)"
    )
    command = [shutil.which("python3", path="/usr/bin"), "-c", code, "render", BALL, "-o", "x.png", "--size", "8x8"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    assert subprocess.run(command, cwd=tmp_path, env=environment, timeout=120).returncode == 0
    assert (tmp_path / "x.png").is_file()


def hear_signals():
    # A shell starts background work with Ctrl-C ignored, and tests may be such work.
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("route", ["module", "freecadcmd"])
def test_a_stopped_render_leaves_nothing(tmp_path, route, stop):
    if route == "freecadcmd" and FREECADCMD is None:
        pytest.skip("freecadcmd is not installed")
    environment = os.environ | ({"FREECADCMD": FREECADCMD} if route == "freecadcmd" else {})
    command = [PROGRAM, "render", TUMBLER, "--tolerance", "1e-6", "-o", tmp_path / "x.png"]
    process = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True, preexec_fn=hear_signals)
    while b"start.py" not in Path(f"/proc/{process.pid}/cmdline").read_bytes():
        time.sleep(0.1)
    time.sleep(3.0)
    process.send_signal(stop)
    try:
        _, err = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 1
    assert err == "glassworkbench: cancelled\n"
    assert list(tmp_path.iterdir()) == []


def test_a_crop_is_delivered_alone(tmp_path):
    whole, part = tmp_path / "whole.exr", tmp_path / "part.exr"
    assert main(["render", BALL, "-o", str(whole), "--size", "20x20"]) == 0
    assert main(["render", BALL, "-o", str(part), "--size", "20x20", "--crop", "3,4,9,7"]) == 0
    assert np.array_equal(read_image(part).pixels, read_image(whole).pixels[4:11, 3:12])
    assert read_image(part).corner == (3, 4)


def test_the_certificate_told_of_a_region_is_that_of_the_region(tmp_path, capsys):
    arguments = ["render", BALL, "-o", str(tmp_path / "x.png"), "--size", "40x40", "--region", "18,18,4,4"]
    assert main([*arguments, "--tolerance", "0.01", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["region"] == [18, 18, 4, 4]
    assert report["certificate"]["total_max"] <= 0.01


@pytest.mark.parametrize("option", ["--crop", "--region"])
@pytest.mark.parametrize("box", ["1,2,3", "a,b,c,d", "-1,0,5,5", "0,0,50,50"])
def test_a_part_that_cannot_be_is_refused(tmp_path, capsys, option, box):
    assert main(["render", BALL, "-o", str(tmp_path / "x.png"), "--size", "20x20", f"{option}={box}"]) == 2
    assert option.strip("-") in told(capsys)


def test_a_rendering_that_was_stopped_goes_on(tmp_path, monkeypatch, capsys):
    class Stop(Exception):
        pass

    def stop(share):
        if share > 0.2:
            raise Stop

    whole, picture = tmp_path / "whole.exr", tmp_path / "picture.exr"
    monkeypatch.setattr(checkpoint, "INTERVAL_SECONDS", 0.0)
    monkeypatch.setattr(rendering, "BATCH_SECONDS", 1e-9)
    scene = dataclasses.replace(read_scene(BALL), size=(70, 70))
    with pytest.raises(Stop):
        render(scene, tolerance=0.1, checkpoint=f"{picture}.checkpoint", progress=stop)
    arguments = ["render", BALL, "--size", "70x70", "-o"]
    assert main([*arguments, str(picture), "--tolerance", "0.05", "--resume", f"{picture}.checkpoint"]) == 2
    assert "another tolerance" in told(capsys)
    assert main([*arguments, str(picture), "--tolerance", "0.1", "--resume", f"{picture}.checkpoint"]) == 0
    assert main([*arguments, str(whole), "--tolerance", "0.1"]) == 0
    assert np.array_equal(read_image(picture).pixels, read_image(whole).pixels)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["picture.exr", "whole.exr"]


def shown_on_terminal(command, columns):
    """What a program writes to standard error when that is a terminal so many columns wide."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    shown = bytearray()
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=theirs) as process:
        os.close(theirs)
        # Linux ends a terminal that nobody holds any more with an input/output error.
        with contextlib.suppress(OSError):
            while part := os.read(ours, 4096):
                shown += part
        os.close(ours)
    assert process.returncode == 0
    return shown.decode()


def test_a_bar_moves_on_a_terminal_and_in_a_pipe_there_is_none(tmp_path):
    pytest.importorskip("tqdm")
    render = [PROGRAM, "render", BALL, "-o", tmp_path / "x.png", "--size", "64x64"]
    assert re.search(r"rendering +\d+%", shown_on_terminal(render, columns=80))
    assert "rendering" not in shown_on_terminal([*render, "--quiet"], columns=80)
    assert run(*render[1:]).stderr == ""


def test_a_terminal_of_unknown_width_gets_a_readable_bar(tmp_path):
    pytest.importorskip("tqdm")
    render = [PROGRAM, "render", BALL, "-o", tmp_path / "x.png", "--size", "64x64"]
    shown = shown_on_terminal(render, columns=0)
    assert re.search(r"rendering +\d+% \|", shown)
    assert "it/s" not in shown


def test_errors_speak_of_the_options_of_the_command_line(tmp_path, capsys):
    import Part

    shells = {
        "open": (Part.Compound(Part.makeCylinder(20, 60).Faces[:2]), "--close"),
        "hollow": (
            Part.makeCylinder(20, 60).cut(Part.makeCylinder(17, 57, Part.Vertex(0, 0, 3).Point)),
            "--outer-shell",
        ),
        "block": (Part.Compound([Part.makeBox(9, 9, 9), Part.makeBox(9, 9, 9, Part.Vertex(9, 0, 0).Point)]), "--block"),
        "small": (Part.makeCylinder(0.02, 0.06), "--scale 1000"),
        "round": (Part.makeSphere(20), "--finish-height"),
    }
    for name, (shape, option) in shells.items():
        path = tmp_path / f"{name}.brep"
        shape.exportBrep(str(path))
        assert main(["hollow", str(path), "--wall", "3", "-o", str(tmp_path / "x.step")]) == 2
        told = capsys.readouterr().err
        assert option in told
        assert not re.search(r"=True|_mm\b", told), told
        assert main(["inspect", str(path), "--json"]) == 0
        assert not re.search(r"=True|_mm\b", " ".join(json.loads(capsys.readouterr().out)["faults"]))
    assert main(["render", WINE_BOTTLE, "-o", str(tmp_path / "x.png")]) == 2
    assert "--wall 3" in capsys.readouterr().err


def test_a_reader_that_leaves_early_is_no_error():
    reading, writing = os.pipe()
    os.close(reading)
    program = "import sys; from glassworkbench.cli import main; sys.exit(main(['stations', '--json']))"
    with os.fdopen(writing, "wb") as answer:
        done = subprocess.run(
            [shutil.which("python3", path="/usr/bin"), "-c", program], cwd=ROOT, stdout=answer, stderr=subprocess.PIPE
        )
    assert done.returncode == 1
    assert done.stderr == b""
