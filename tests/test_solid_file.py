from pathlib import Path

import pytest

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import Part
from glassworkbench.mold import read_mold
from glassworkbench.mold.read import read_shape
from glassworkbench.wall.solid_file import write_solid

BOWL = Path(__file__).resolve().parents[2] / "shared" / "molds" / "pp_mould_bowl.step"


@pytest.mark.skipif(not BOWL.exists(), reason="the mold blocks are not part of the project")
def test_a_body_whose_step_file_occ_misreads_is_written_so_that_it_reads_it(tmp_path):
    body = read_mold(BOWL, block=True).upright
    plain, mended = tmp_path / "plain.step", tmp_path / "mended.step"
    body.exportStep(str(plain))
    write_solid(body, "bowl", mended)
    assert not read_shape(plain).isValid()
    read = read_shape(mended)
    assert read.isValid()
    assert read.Volume == pytest.approx(body.Volume, rel=1e-4)


@pytest.mark.parametrize("ending", [".step", ".brep", ".FCStd"])
def test_a_file_that_does_not_hold_the_closed_solid_is_told(tmp_path, ending):
    open_box = Part.Solid(Part.Shell(Part.makeBox(10, 10, 10).Faces[:5]))
    with pytest.raises(GlassWorkbenchError, match="read again, the "):
        write_solid(open_box, "box", tmp_path / f"box{ending}")


def test_parameter_curves_are_written_again_after_they_were_left_out(tmp_path):
    open_box = Part.Solid(Part.Shell(Part.makeBox(10, 10, 10).Faces[:5]))
    with pytest.raises(GlassWorkbenchError):
        write_solid(open_box, "box", tmp_path / "box.step")
    path = tmp_path / "cylinder.step"
    write_solid(Part.makeCylinder(10, 20), "cylinder", path)
    assert "PCURVE" in path.read_text()
