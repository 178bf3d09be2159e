"""A container that is already hollow is taken as its file has it."""

import numpy as np
import pytest

from glassworkbench.cli import main
from glassworkbench.document import make_container, make_render
from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import inspect, mold_from_shape, read_mold
from glassworkbench.scene import Patches, Revolved
from glassworkbench.staging import station
from glassworkbench.wall import container_from_shape, hollow, read_container
from glassworkbench.wall.measuring.volumes import mesh_volume, revolved_volume
from glassworkbench.wall.offsetting import offset_check

RADIUS, HEIGHT, WALL, BASE = 30.0, 90.0, 3.0, 4.0


def volume_mm3(surface):
    measure = revolved_volume if isinstance(surface, Revolved) else mesh_volume
    return measure(surface.meridian if isinstance(surface, Revolved) else surface).volume_mm3


def tumbler():
    """Return a tumbler whose axis is x and whose lowest point is at x = 7."""
    along = FreeCAD.Vector(1, 0, 0)
    inner = Part.makeCylinder(RADIUS - WALL, HEIGHT, FreeCAD.Vector(7 + BASE, 0, 0), along)
    return Part.makeCylinder(RADIUS, HEIGHT, FreeCAD.Vector(7, 0, 0), along).cut(inner)


def square_jar():
    outer, inner = Part.makeBox(60, 60, 100), Part.makeBox(52, 52, 100, FreeCAD.Vector(4, 4, 5))
    return outer.cut(inner)


def round_rimmed():
    """Return a tumbler on z whose rim is half a torus."""
    middle = RADIUS - 0.5 * WALL
    outline = [(0, 0), (RADIUS, 0), (RADIUS, HEIGHT), (middle, HEIGHT + 0.5 * WALL), (RADIUS - WALL, HEIGHT)]
    outline += [(RADIUS - WALL, BASE), (0, BASE)]
    at = [FreeCAD.Vector(r, 0, z) for r, z in outline]
    lines = [Part.makeLine(at[k], at[(k + 1) % len(at)]) for k in (0, 1, 4, 5, 6)]
    lip = Part.Arc(at[2], at[3], at[4]).toShape()
    profile = Part.Face(Part.Wire(Part.__sortEdges__([*lines, lip])))
    return profile.revolve(FreeCAD.Vector(), FreeCAD.Vector(0, 0, 1), 360)


@pytest.fixture
def saved(tmp_path):
    """A document, saved, with a container of a cylinder, a picture of it, and a group around all."""
    path = tmp_path / "tumbler.FCStd"
    document = FreeCAD.newDocument("Saved")
    mold = document.addObject("Part::Cylinder", "Mold")
    mold.Radius, mold.Height = RADIUS, HEIGHT
    document.recompute()
    make_render(make_container(mold, wall=WALL), size=(16, 16))
    document.addObject("App::DocumentObjectGroup", "All").Group = document.Objects
    document.recompute()
    document.saveAs(str(path))
    FreeCAD.closeDocument(document.Name)
    return path


def test_the_inside_of_a_tumbler_is_exact_and_reaches_past_the_mouth():
    geometry = container_from_shape(tumbler(), "tumbler")
    assert isinstance(geometry.outer, Revolved)
    assert isinstance(geometry.cavity, Revolved)
    top = geometry.cavity.meridian[:, :, 1].max()
    assert top > HEIGHT + 1.0
    assert geometry.high_mm == pytest.approx([RADIUS, RADIUS, HEIGHT], abs=1e-9)
    assert geometry.finish_height_mm == pytest.approx(HEIGHT, abs=1e-9)
    assert volume_mm3(geometry.outer) == pytest.approx(np.pi * RADIUS**2 * HEIGHT, rel=1e-9)
    assert volume_mm3(geometry.cavity) == pytest.approx(np.pi * (RADIUS - WALL) ** 2 * (top - BASE), rel=1e-9)


def test_the_inside_of_a_square_jar_is_closed_and_exact():
    geometry = container_from_shape(square_jar(), "jar")
    assert isinstance(geometry.outer, Patches)
    top = geometry.cavity.box_mm[1][2]
    assert top > 101.0
    assert volume_mm3(geometry.outer.mesh) == pytest.approx(60 * 60 * 100, rel=1e-9)
    assert volume_mm3(geometry.cavity.mesh) == pytest.approx(52 * 52 * (top - 5), rel=1e-9)


def test_a_hollowed_mold_that_was_saved_is_the_container_it_was(tmp_path):
    made = hollow(mold_from_shape(Part.makeCone(20, RADIUS, HEIGHT), "cone", up=(0, 0, 1)), WALL)
    path = tmp_path / "cone.step"
    made.save(path)
    was, found = made.geometry(), read_container(path)
    for surface in ("outer", "cavity"):
        assert isinstance(getattr(found, surface), Revolved)
    assert volume_mm3(found.outer) == pytest.approx(volume_mm3(was.outer), rel=1e-9)
    # Past the mouth the two go on differently, in air.
    inside = [container.cavity.meridian[:, :, :2].reshape(-1, 2) for container in (was, found)]
    depths = [points[points[:, 0] < 1e-9, 1].min() for points in inside]
    assert depths[1] == pytest.approx(depths[0], abs=1e-6)


def test_a_rounded_rim_parts_nothing_so_the_glass_is_taken_whole_and_not_filled():
    geometry = container_from_shape(round_rimmed(), "tumbler")
    assert geometry.cavity is None
    lip = 0.5 * np.pi * (0.5 * WALL) ** 2 * 2.0 * np.pi * (RADIUS - 0.5 * WALL)
    glass = np.pi * RADIUS**2 * HEIGHT - np.pi * (RADIUS - WALL) ** 2 * (HEIGHT - BASE) + lip
    assert volume_mm3(geometry.outer) == pytest.approx(glass, rel=1e-6)
    scene = station("studio", geometry, "flint")
    assert [body.name for body in scene.bodies] == ["outer"]
    assert [medium.where for medium in scene.media] == ["outer"]
    with pytest.raises(InputError, match="rim is rounded"):
        station("studio", geometry, "flint", "water")


def test_a_mold_is_no_container_and_a_container_no_mold():
    with pytest.raises(InputError, match="say how thick its wall shall be"):
        container_from_shape(Part.makeCylinder(RADIUS, HEIGHT), "mold")
    with pytest.raises(InputError, match=r"leave the wall away .*outer_shell"):
        mold_from_shape(tumbler(), "tumbler")


def test_a_saved_document_gives_its_mold_or_its_container_as_wanted(saved):
    mold = read_mold(saved)
    assert mold.solid.Volume == pytest.approx(np.pi * RADIUS**2 * HEIGHT, rel=1e-9)
    geometry = read_container(saved)
    at_base = geometry.cavity.meridian[:, :, 1].min()
    assert at_base == pytest.approx(WALL, abs=1e-6)


def test_inspect_tells_of_a_hollow_container_what_its_outside_is(tmp_path):
    path = tmp_path / "tumbler.step"
    tumbler().exportStep(str(path))
    found = inspect(path)
    assert found["hollow"] is True
    assert found["revolved"] is True
    assert found["departure_mm"] == pytest.approx(0.0, abs=1e-9)
    assert found["push_up_mm"] == pytest.approx(0.0, abs=1e-9)
    assert found["regions"]["finish"][1] == pytest.approx(HEIGHT, abs=1e-6)


def test_a_ring_is_not_called_hollow():
    with pytest.raises(InputError, match="neither base nor mouth") as caught:
        mold_from_shape(Part.makeTorus(30, 10), "ring")
    assert "hollow" not in str(caught.value)


def test_an_offset_that_crosses_itself_is_told_in_a_designers_words():
    class Crossing:
        """What OCC's check says of a solid whose faces cross."""

        Shells = (Part.makeBox(1, 1, 1).Shells[0],)

        def isValid(self):  # noqa: N802 (FreeCAD's name)
            return True

        def check(self, thoroughly):
            raise ValueError("BOP check found the following errors:\nError in Face: BOPAlgo SelfIntersect\n")

    with pytest.raises(GlassWorkbenchError) as caught:
        offset_check.check_solid(Crossing())
    assert str(caught.value) == "the offset surface crosses itself"


def test_the_command_line_renders_a_container_as_it_is(tmp_path, capsys):
    path, picture = tmp_path / "tumbler.step", tmp_path / "tumbler.png"
    tumbler().exportStep(str(path))
    asked = ["render", str(path), "--glass", "emerald", "--size", "12x16", "--seconds", "0.1", "-o", str(picture)]
    assert main(asked) == 0
    assert picture.exists()
    assert main([*asked, "--wall", "3"]) == 2
    assert main([*asked, "--outer-shell"]) == 2
    told = capsys.readouterr().err
    assert "leave the wall away" in told
    assert "(--outer-shell)" in told
    assert "--outer-shell: is for hollowing" in told
