"""What of the outside is lost to a wall that is asked elsewhere: against the closed form of a can with a thick base."""

import json

import numpy as np
import pytest
from test_outside import outside

from glassworkbench.cli import main
from glassworkbench.document import make_container
from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.wall.measuring.swallowed import note_on_swallowed, swallowed


def thick_base(base_mm):
    """Ask 2 mm of a can's side, and of its base another wall."""
    return outside(lambda points, _: np.where(points[:, 2] < 1e-6, base_mm, 2.0), levels=201)


def test_a_wall_that_is_the_same_everywhere_swallows_nothing():
    assert swallowed(outside(lambda points, _: np.full(len(points), 12.0))) is None


def test_a_base_takes_the_side_up_to_where_its_own_wall_reaches():
    lost = swallowed(thick_base(40.0))
    # At height h the side asks for a point 2 mm inside. The base reaches past it by 40 - h, which is more than 2 mm.
    assert lost.high_mm == pytest.approx(38.0, abs=1.0)
    assert lost.thick_mm == pytest.approx(40.0, abs=0.1)
    assert lost.thick_at_mm == pytest.approx(0.0, abs=0.1)
    side, base = 2.0 * np.pi * 30.0 * 100.0, np.pi * 30.0**2
    assert lost.share == pytest.approx(0.38 * side / (side + base), abs=0.01)


def test_a_wall_that_swallows_much_is_refused_and_the_most_that_fits_is_told():
    with pytest.raises(InputError, match=r"40 mm asked at height 0\.0 mm swallow the wall of 2 mm .* at most about 18"):
        note_on_swallowed(thick_base(40.0), 0.0)
    (note,) = note_on_swallowed(thick_base(12.0), 0.0)
    assert "12 mm" in note
    assert note_on_swallowed(thick_base(3.0), 0.0) == ()


def test_the_command_line_prints_the_note_and_where_the_time_went(tmp_path, capsys):
    path, report = tmp_path / "can.brep", tmp_path / "report.json"
    Part.makeCylinder(30, 100).exportBrep(str(path))
    (tmp_path / "wall.csv").write_text("height_mm,thickness_mm\n0,12\n1,12\n3,2\n100,2\n")
    words = ["hollow", str(path), "--wall", f"@{tmp_path / 'wall.csv'}", "-o", str(tmp_path / "c.brep")]
    assert main([*words, "--report", str(report)]) == 0
    out, err = capsys.readouterr()
    assert "glassworkbench: note: 12 mm asked at height" in err
    told = json.loads(report.read_text())
    assert set(told["seconds_of"]) == {"reading", "hollowing", "writing"}
    assert told["seconds"] >= sum(told["seconds_of"].values())
    assert f"{told['seconds']:.1f} s (reading {told['seconds_of']['reading']:.1f}, hollowing " in out
    assert main([*words, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_the_container_of_a_document_keeps_the_note():
    document = FreeCAD.newDocument("Swallowed")
    try:
        can = document.addObject("Part::Cylinder", "Can")
        can.Radius, can.Height = 30, 100
        document.recompute()
        (note,) = make_container(can, "0:12 1:12 3:2 100:2").Notes
        assert note.startswith("12 mm asked at height")
    finally:
        FreeCAD.closeDocument(document.Name)
