import math
import subprocess
import sys

import pytest

from glassworkbench.document import make_container, make_render, render_image
from glassworkbench.document.container import set_glass
from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import FreeCAD

RADIUS, HEIGHT = 30.0, 90.0


@pytest.fixture
def document():
    document = FreeCAD.newDocument("Test")
    document.UndoMode = 1
    yield document
    for name in FreeCAD.listDocuments():
        FreeCAD.closeDocument(name)


@pytest.fixture
def tumbler(document):
    """The outside of a plain glass: a cylinder."""
    solid = document.addObject("Part::Cylinder", "Tumbler")
    solid.Radius, solid.Height = RADIUS, HEIGHT
    document.recompute()
    return solid


def capacity_mm3(wall):
    return math.pi * (RADIUS - wall) ** 2 * (HEIGHT - wall)


def glass_mm3(wall):
    return math.pi * RADIUS**2 * HEIGHT - capacity_mm3(wall)


def test_a_container_has_the_wall_the_weight_and_the_capacity_of_its_closed_form(tumbler):
    container = make_container(tumbler, wall=3.0, glass="emerald")
    assert container.Shape.isValid()
    assert container.Shape.Volume == pytest.approx(glass_mm3(3.0), rel=1e-6)
    assert container.BrimfulCapacity.Value == pytest.approx(capacity_mm3(3.0), rel=1e-4)
    assert container.WeightGrams == pytest.approx(2.5e-3 * glass_mm3(3.0), rel=1e-4)
    assert container.MinimumWall.Value == pytest.approx(3.0, abs=0.01)
    assert container.LargestDeviation.Value < 0.06
    assert container.Glass == "emerald"
    assert container.Fault == ""


def test_another_thickness_recomputes_and_a_region_overrules_it(document, tumbler):
    container = make_container(tumbler, wall=3.0)
    container.WallThickness = "2 mm"
    document.recompute()
    assert container.Shape.Volume == pytest.approx(glass_mm3(2.0), rel=1e-6)
    container.Wall = "4"
    document.recompute()
    assert container.Shape.Volume == pytest.approx(glass_mm3(4.0), rel=1e-6)


def test_another_mold_recomputes(document, tumbler):
    container = make_container(tumbler, wall=3.0)
    tumbler.Height = 2.0 * HEIGHT
    document.recompute()
    assert container.Shape.BoundBox.ZLength == pytest.approx(2.0 * HEIGHT, rel=1e-6)


def test_a_moved_mold_takes_the_container_along(document, tumbler):
    container = make_container(tumbler, wall=3.0)
    tumbler.Placement.Base = FreeCAD.Vector(100.0, 20.0, 5.0)
    document.recompute()
    assert container.Fault == ""
    assert container.Shape.CenterOfMass.x == pytest.approx(100.0, abs=1e-6)
    assert container.Shape.BoundBox.ZMin == pytest.approx(5.0, abs=1e-6)


def test_a_failed_recompute_keeps_the_shape_and_says_why_in_one_sentence(document, tumbler, capfd):
    container = make_container(tumbler, wall=3.0)
    container.WallThickness = 40.0
    document.recompute()
    assert container.Shape.Volume == pytest.approx(glass_mm3(3.0), rel=1e-6)
    assert "40 mm" in container.Fault
    assert "\n" not in container.Fault
    output = "".join(capfd.readouterr())
    assert "Traceback" not in output
    container.WallThickness = 3.0
    document.recompute()
    assert container.Fault == ""


def test_a_container_with_a_fault_is_not_rendered(document, tumbler):
    container = make_container(tumbler, wall=3.0)
    picture = make_render(container, size=(16, 16))
    container.WallThickness = 40.0
    document.recompute()
    with pytest.raises(GlassWorkbenchError, match="40 mm"):
        render_image(picture)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"wall": "knee=2"}, "neck"),
        ({"wall": 0}, "wall"),
        ({"wall": float("nan")}, "wall"),
        ({"wall": 40.0}, "40 mm"),
        ({"glass": "emarald"}, "emerald"),
        ({"method": "revolvd"}, "revolved"),
    ],
)
def test_bad_input_leaves_the_document_as_it_was(document, tumbler, arguments, message):
    with pytest.raises(GlassWorkbenchError, match=message):
        make_container(tumbler, **arguments)
    assert [obj.Name for obj in document.Objects] == ["Tumbler"]
    assert tumbler.Visibility


def test_a_source_without_a_solid_is_refused(document):
    empty = document.addObject("Part::Feature", "Empty")
    with pytest.raises(GlassWorkbenchError, match="Empty"):
        make_container(empty)
    assert [obj.Name for obj in document.Objects] == ["Empty"]


def test_undo_is_one_step_and_redo_brings_the_container_back(document, tumbler):
    document.openTransaction("Make container")
    make_container(tumbler, wall=3.0)
    document.commitTransaction()
    assert document.UndoNames == ["Make container"]
    document.undo()
    assert document.getObject("Container") is None
    document.redo()
    assert document.getObject("Container").Shape.Volume == pytest.approx(glass_mm3(3.0), rel=1e-6)


def test_the_picture_follows_an_undone_wall(document, tumbler):
    container = make_container(tumbler, wall=3.0)
    document.openTransaction("Thicker")
    container.WallThickness = 5.0
    document.recompute()
    document.commitTransaction()
    document.undo()
    radii = container.Proxy.geometry(container).cavity.meridian[:, :, 0]
    assert radii.max() == pytest.approx(RADIUS - 3.0, abs=1e-6)


def test_a_glass_of_ones_own_can_be_chosen_once_its_file_is_in_the_folder(document, tumbler, tmp_path, monkeypatch):
    monkeypatch.setenv("GLASSWORKBENCH_GLASSES", str(tmp_path / "glasses"))
    container = make_container(tumbler, wall=3.0)
    (tmp_path / "glasses").mkdir()
    heavy = tmp_path / "heavy.toml"
    heavy.write_text('[glass.heavy]\nlike = "flint"\ndensity_g_per_cm3 = 3.0\n')
    with pytest.raises(InputError, match="in a document it must be one of the catalogue; put its file into"):
        set_glass(container, str(heavy))
    heavy.rename(tmp_path / "glasses" / "heavy.toml")
    set_glass(container, "heavy")
    assert container.Glass == "heavy"
    assert container.WeightGrams == pytest.approx(3.0e-3 * glass_mm3(3.0), rel=1e-4)


def test_a_new_glass_needs_no_recompute(document, tumbler):
    container = make_container(tumbler, wall=3.0)
    document.recompute()
    container.Glass = "amber"
    assert "Touched" not in container.State


def test_save_close_and_reopen_keep_container_and_picture_alive(document, tumbler, tmp_path):
    container = make_container(tumbler, wall=3.0, glass="amber")
    picture = make_render(container, station="sidewall", tolerance=0.1, size=(24, 32), fill="water")
    path = str(tmp_path / "tumbler.FCStd")
    document.saveAs(path)
    FreeCAD.closeDocument(document.Name)
    document = FreeCAD.openDocument(path)
    container, picture = document.getObject("Container"), document.getObject("Render")
    assert container.Shape.Volume == pytest.approx(glass_mm3(3.0), rel=1e-6)
    assert container.Glass == "amber"
    assert container.WeightGrams == pytest.approx(2.5e-3 * glass_mm3(3.0), rel=1e-4)
    assert document.recompute() == 0
    container.WallThickness = 4.0
    document.recompute()
    assert container.Shape.Volume == pytest.approx(glass_mm3(4.0), rel=1e-6)
    assert render_image(picture).metadata["station"] == "sidewall"


def test_a_file_of_an_older_version_gains_what_it_lacks(document, tumbler, tmp_path):
    container = make_container(tumbler, wall=3.0)
    container.removeProperty("TimeLimit")
    container.SchemaVersion = 0
    path = str(tmp_path / "old.FCStd")
    document.saveAs(path)
    FreeCAD.closeDocument(document.Name)
    container = FreeCAD.openDocument(path).getObject("Container")
    assert container.TimeLimit == 120.0
    assert container.SchemaVersion == 1
    assert container.Glass == "flint"


def test_a_file_opens_where_the_workbench_is_not_installed(document, tumbler, tmp_path):
    make_render(make_container(tumbler, wall=3.0))
    path = tmp_path / "tumbler.FCStd"
    document.saveAs(str(path))
    script = (
        f"import sys; sys.path[:0] = {[entry for entry in sys.path if 'freecad' in entry.lower()]!r}\n"
        "import FreeCAD, importlib.util\n"
        "assert importlib.util.find_spec('glassworkbench') is None\n"
        f"document = FreeCAD.openDocument({str(path)!r})\n"
        "document.recompute()\n"
        "print('volume', document.getObject('Container').Shape.Volume)\n"
    )
    result = subprocess.run(
        [sys.executable, "-I", "-c", script], capture_output=True, text=True, cwd=tmp_path, check=True
    )
    volume = float(result.stdout.split("volume")[-1])
    assert volume == pytest.approx(glass_mm3(3.0), rel=1e-6)


def test_a_picture_carries_what_it_shows(tumbler):
    container = make_container(tumbler, wall=3.0, glass="emerald")
    picture = make_render(container, station="sidewall", tolerance=0.1, size=(24, 32))
    image = render_image(picture)
    assert image.pixels.shape == (32, 24, 3)
    assert image.metadata["mold"] == "Tumbler"
    assert image.metadata["wall"] == "3"
    assert image.metadata["glass"] == "emerald"
    red, green, blue = image.pixels[16, 12]
    assert green > red
    assert green > blue


@pytest.mark.parametrize(
    ("arguments", "message"),
    [({"station": "sidewal"}, "sidewall"), ({"fill": "watr"}, "water"), ({"size": (0, 5)}, "size")],
)
def test_a_picture_that_cannot_be_leaves_the_document_as_it_was(document, tumbler, arguments, message):
    container = make_container(tumbler, wall=3.0)
    with pytest.raises(InputError, match=message):
        make_render(container, **arguments)
    assert [obj.Name for obj in document.Objects] == ["Tumbler", "Container"]


def test_a_picture_shows_the_defects_that_it_names(tumbler):
    picture = make_render(make_container(tumbler, wall=3.0), station="sidewall", tolerance=0.1, size=(24, 32))
    picture.Defects = "seedy:1"
    assert "seed at" in render_image(picture).metadata["defects"]
    picture.Defects = "seedy"
    with pytest.raises(InputError, match="give the seed of seedy"):
        render_image(picture)


def test_only_containers_have_pictures(tumbler):
    with pytest.raises(InputError, match="Tumbler"):
        make_render(tumbler)
