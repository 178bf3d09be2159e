"""An open surface is refused, or closed where the user says so and its holes are flat."""

import pytest

from glassworkbench.errors import InputError
from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import mold_from_shape


def test_the_flat_holes_of_an_open_shell_are_closed_when_asked():
    can = Part.makeCylinder(20, 60)
    side = Part.makeShell([face for face in can.Faces if not face.Surface.isPlanar()])
    with pytest.raises(InputError, match="close_open_shell=True"):
        mold_from_shape(side, "can")
    mold = mold_from_shape(side, "can", close_open_shell=True)
    assert mold.solid.Volume == pytest.approx(can.Volume, rel=1e-9)
    assert mold.repairs == ("its surface was open: 2 flat holes were closed",)


def test_loose_faces_are_sewn_and_closed():
    faces = Part.makeBox(30, 30, 90).Faces
    mold = mold_from_shape(Part.Compound(faces[:5]), "box", close_open_shell=True)
    assert mold.solid.Volume == pytest.approx(81000, rel=1e-9)


def test_a_closed_mold_is_left_as_it_is():
    assert mold_from_shape(Part.makeCylinder(20, 60), "can", close_open_shell=True).repairs == ()


def test_a_hole_that_is_not_flat_is_refused_with_its_place():
    pipe = Part.makeCylinder(8, 60, FreeCAD.Vector(0, 0, 50), FreeCAD.Vector(1, 0, 0))
    pierced = Part.makeCylinder(30, 100).cut(pipe)
    wall = [face for face in pierced.Faces if face.BoundBox.ZLength > 90 or face.Surface.isPlanar()]
    with pytest.raises(InputError, match=r"near \(.*\) mm is not flat"):
        mold_from_shape(Part.makeShell(wall), "pierced", close_open_shell=True)
