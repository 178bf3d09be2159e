"""The mold scaled: right where it says so, and only there."""

from pathlib import Path

import numpy as np
import pytest
from meshed_molds import cells_mesh, mesh_mold, uniform

from glassworkbench.errors import InputError
from glassworkbench.mold import read_mold, tessellate
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.measuring.outside import outside
from glassworkbench.wall.measuring.volumes import mesh_volume
from glassworkbench.wall.methods.scaled import scaled, scaled_per_axis

EXAMPLES = Path(__file__).resolve().parent.parent / "examples" / "molds"


def made(method, mold, thickness):
    at = uniform(thickness)
    return method(mold, AskedThickness(at, thickness, thickness), outside(mold, at), 10.0)


def test_a_box_scaled_per_axis_has_the_wall_on_all_sides():
    candidate = made(scaled_per_axis, mesh_mold(cells_mesh([-20, 20], [-15, 15], [0, 60], [[[1]]])), 5.0)
    points = candidate.inside.vertices_mm
    assert points.min(axis=0) == pytest.approx([-15, -10, 5])
    assert points.max(axis=0) == pytest.approx([15, 10, 60])
    assert mesh_volume(candidate.inside).volume_mm3 == pytest.approx(30 * 20 * 55)
    assert candidate.cavity.vertices_mm[:, 2].max() == pytest.approx(65.0)
    assert candidate.solid is None


def test_one_factor_gives_the_wall_where_the_mold_is_widest_and_another_elsewhere():
    mold = read_mold(EXAMPLES / "jar.step")
    candidate = made(scaled, mold, 2.0)
    widest = np.hypot(*candidate.inside.vertices_mm[:, :2].T).max()
    assert widest == pytest.approx(mold.anatomy.maximum_radius_mm - 2.0, abs=1e-3)
    # The height shrinks by the same factor: much more than a wall is left below.
    floor = candidate.inside.vertices_mm[:, 2].min()
    assert floor == pytest.approx(0.5 * mold.anatomy.height_mm * 2.0 / mold.anatomy.maximum_radius_mm, rel=1e-3)
    assert candidate.inside.vertices_mm[:, 2].max() == pytest.approx(mold.anatomy.finish_height_mm)
    assert candidate.solid.isValid()
    glass = mesh_volume(tessellate(mold.upright, 0.05)).volume_mm3 - mesh_volume(candidate.inside).volume_mm3
    assert mesh_volume(tessellate(candidate.solid, 0.05)).volume_mm3 == pytest.approx(glass, rel=3e-3)


def test_a_wall_as_thick_as_the_mold_is_refused():
    mold = mesh_mold(cells_mesh([-20, 20], [-15, 15], [0, 60], [[[1]]]))
    with pytest.raises(InputError, match="as thick as"):
        made(scaled_per_axis, mold, 15.0)
