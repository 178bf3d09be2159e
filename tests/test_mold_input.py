"""Files that cannot be a mold are refused with one sentence, and OCC's noise stays away from the user."""

import math
import re
from pathlib import Path

import pytest

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import inspect, mold_from_shape, read_mold
from glassworkbench.mold.inspection_words import in_words
from glassworkbench.mold.units import declared_unit
from glassworkbench.wall import hollow

MOLDS = Path(__file__).resolve().parent.parent / "examples" / "molds"


def refusal(path, **options) -> str:
    with pytest.raises(InputError) as caught:
        read_mold(path, **options)
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert str(path) in sentence
    return sentence


@pytest.fixture
def write(tmp_path):
    def written(shape: Part.Shape) -> Path:
        path = tmp_path / "mold.step"
        shape.exportStep(str(path))
        return path

    return written


def test_a_missing_file(tmp_path):
    assert "no such file" in refusal(tmp_path / "nowhere.step")


def test_an_empty_file(tmp_path):
    path = tmp_path / "empty.step"
    path.write_text("")
    assert "empty" in refusal(path)


def test_another_ending(tmp_path):
    path = tmp_path / "bottle.docx"
    path.write_text("bottle")
    assert ".docx" in refusal(path)


def test_a_file_that_is_not_step(tmp_path):
    path = tmp_path / "picture.step"
    path.write_bytes(b"\x89PNG\r\n" + bytes(1000))
    assert "not a STEP file" in refusal(path)


def test_a_truncated_file(tmp_path):
    whole = (MOLDS / "wine_bottle.step").read_text()
    path = tmp_path / "half.step"
    path.write_text(whole[: len(whole) // 2])
    assert "cut short" in refusal(path)


def test_a_damaged_file_makes_no_noise(tmp_path, capfd):
    whole = (MOLDS / "wine_bottle.step").read_text()
    path = tmp_path / "damaged.step"
    path.write_text(whole[:3000] + "#!?(((" + whole[6000:])
    refusal(path)
    captured = capfd.readouterr()
    assert captured.out == captured.err == ""


def test_a_damaged_brep_makes_no_noise(tmp_path, capfd):
    path = tmp_path / "damaged.brep"
    path.write_text("DBRep_DrawableShape\nnonsense")
    assert "damaged" in refusal(path)
    captured = capfd.readouterr()
    assert captured.out == captured.err == ""


def test_a_file_without_surfaces(write):
    assert "no surface" in refusal(write(Part.makeLine((0, 0, 0), (0, 0, 10))))


def test_faces_that_are_no_solid(write):
    assert "no solid" in refusal(write(Part.makePlane(10, 10)))


def test_an_open_shell(write):
    box = Part.makeBox(30, 30, 90)
    assert "open shell" in refusal(write(Part.makeShell(box.Faces[:5])))


def test_a_closed_shell_is_taken_as_a_solid(write):
    mold = read_mold(write(Part.makeShell(Part.makeBox(30, 30, 90).Faces)))
    assert mold.anatomy.height_mm == pytest.approx(90)


def test_several_solids(write):
    boxes = [Part.makeBox(10, 10, 30), Part.makeBox(10, 10, 30, FreeCAD.Vector(50, 0, 0))]
    assert "2 solids" in refusal(write(Part.Compound(boxes)))


def test_a_mold_without_a_finish(write):
    assert "mouth cannot be found" in refusal(write(Part.makeSphere(40)))


def test_metres_declared_as_millimetres(write):
    small = read_mold(MOLDS / "wine_bottle.step").solid.scaled(1e-3, FreeCAD.Vector())
    path = write(small)
    assert "scale_to_mm=1000" in refusal(path)
    assert read_mold(path, scale_to_mm=1000).anatomy.height_mm == pytest.approx(300, rel=1e-3)


def test_a_file_in_metres_arrives_in_millimetres(write):
    path = write(Part.makeCylinder(0.02, 0.3))
    path.write_text(path.read_text().replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)"))
    assert read_mold(path).anatomy.height_mm == pytest.approx(300, rel=1e-6)
    assert inspect(path)["unit"] == "metre"


@pytest.mark.parametrize("scale", [0, -1, float("nan"), float("inf")])
def test_an_impossible_scale(scale):
    with pytest.raises(InputError, match="scale_to_mm"):
        read_mold(MOLDS / "jar.step", scale_to_mm=scale)


@pytest.mark.parametrize("axis", [(0, 0, 0), (0, 0), (0, 0, float("nan")), "up"])
def test_an_impossible_axis(axis):
    with pytest.raises(InputError, match="axis"):
        mold_from_shape(Part.makeCylinder(20, 60), "can", axis=axis)


def test_inspect_tells_faults_instead_of_refusing(write):
    boxes = [Part.makeBox(10, 10, 30), Part.makeBox(10, 10, 30, FreeCAD.Vector(50, 0, 0))]
    found = inspect(write(Part.Compound(boxes)))
    assert found["solids"] == 2
    assert "2 solids" in found["faults"][0]
    assert found["axis"] is None


@pytest.mark.parametrize("ending", ["brep", "iges", "FCStd"])
def test_other_kinds_of_file_hold_the_same_mold(tmp_path, ending):
    can = Part.makeCylinder(20, 60)
    path = tmp_path / f"can.{ending}"
    if ending == "FCStd":
        document = FreeCAD.newDocument("can")
        document.addObject("Part::Feature", "can").Shape = can
        document.saveAs(str(path))
        FreeCAD.closeDocument(document.Name)
    else:
        (can.exportBrep if ending == "brep" else can.exportIges)(str(path))
    anatomy = read_mold(path).anatomy
    assert anatomy.height_mm == pytest.approx(60, abs=1e-6)
    assert anatomy.maximum_radius_mm == pytest.approx(20, abs=1e-6)


def test_inspect_says_where_a_mold_departs_from_a_body_of_revolution(write):
    found = inspect(write(Part.makeCylinder(20, 60).fuse(Part.makeBox(4, 10, 8, FreeCAD.Vector(-2, 15, 30)))))
    assert found["departure_mm"] == pytest.approx((25**2 + 2**2) ** 0.5 - 20, abs=1e-3)
    assert 30 <= found["departure_at"]["height_mm"] <= 38
    assert found["departure_at"]["angle_deg"] == pytest.approx(90, abs=6)


def crossing_bottle() -> Part.Shape:
    """Turn an outline that crosses itself at radius 33, height 63."""
    outline = [(0, 0), (30, 0), (30, 60), (36, 66), (36, 60), (28, 68), (12, 90), (12, 120), (0, 120), (0, 0)]
    face = Part.Face(Part.makePolygon([FreeCAD.Vector(x, 0, z) for x, z in outline]))
    return Part.makeSolid(face.revolve(FreeCAD.Vector(), FreeCAD.Vector(0, 0, 1), 360).Shells[0])


def test_inspect_says_where_a_mold_crosses_itself(write):
    (fault,) = [fault for fault in inspect(write(crossing_bottle()))["faults"] if "crosses itself" in fault]
    x, y, z = map(float, re.search(r"near \((.*)\) mm", fault).group(1).split(","))
    assert math.hypot(x, y) == pytest.approx(33, abs=0.5)
    assert z == pytest.approx(63, abs=0.5)


def test_a_mold_that_crosses_itself_is_refused_before_any_method_tries(write):
    with pytest.raises(InputError, match=r"the mold crosses itself near \(.*, 63\.0\) mm"):
        hollow(read_mold(write(crossing_bottle())), 2.0)


def test_seams_of_an_iges_file_are_no_crossings(tmp_path):
    path = tmp_path / "bottle.iges"
    Part.read(str(MOLDS / "wine_bottle.step")).exportIges(str(path))
    assert not [fault for fault in inspect(path)["faults"] if "crosses" in fault]


def test_inspect_takes_a_doubtful_size_for_a_fault(write):
    found = inspect(write(Part.makeCylinder(3, 8)))
    assert "unusual for a container" in found["faults"][0]


def exported_iges(folder: Path, unit: str = "2,2HMM", name: str = "14Hcan; in, mm.xx") -> Path:
    """Return an IGES file whose global section declares a unit, and holds a string with delimiters in it."""
    path = folder / "can.igs"
    Part.makeCylinder(20, 60).exportIges(str(path))
    lines = path.read_text().splitlines()
    section = "".join(line[:72] for line in lines if line[72:73] == "G").replace("2,2HMM", unit)
    section = section.replace("13HFilename.iges", name)
    rows = [f"{section[start : start + 72]:72}G{start // 72 + 1:7}" for start in range(0, len(section), 72)]
    kept = [line for line in lines if line[72:73] != "G"]
    path.write_text("\n".join([kept[0], *rows, *kept[1:]]) + "\n")
    return path


@pytest.mark.parametrize(
    ("unit", "name"),
    [("2,2HMM", "millimetre"), ("1,2HIN", "inch"), ("6,1HM", "metre"), ("10,", "centimetre"), (",", "inch")],
)
def test_the_unit_of_an_iges_file_is_that_of_its_header(tmp_path, unit, name):
    assert declared_unit(exported_iges(tmp_path, unit)) == name


def test_an_iges_file_is_told_with_its_unit_and_without_solids(tmp_path):
    found = inspect(exported_iges(tmp_path))
    assert found["unit"] == "millimetre"
    assert any(line.split() == ["solids", "none,", "only", "faces"] for line in in_words(found))


def test_a_solid_that_is_inside_out_is_turned_and_told(tmp_path):
    path = tmp_path / "can.brep"
    Part.makeCylinder(20, 60).reversed().exportBrep(str(path))
    mold = read_mold(path)
    assert mold.solid.Volume > 0.0
    assert mold.repairs == ("it was inside out: its faces were turned outward",)
    assert mold.repairs[0] in inspect(path)["notes"]
    assert inspect(MOLDS / "jar.step")["faults"] == []
