from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from glassworkbench.errors import InputError
from glassworkbench.wall.asking.interpolation import PeriodicGrid, monotone_cubic
from glassworkbench.wall.asking.notation import INTERPOLATIONS
from glassworkbench.wall.asking.shortened import shortened
from glassworkbench.wall.asking.thickness import (
    REGIONS,
    BoredThickness,
    FaceThickness,
    GridThickness,
    RegionalThickness,
    TabulatedThickness,
    UniformThickness,
)
from glassworkbench.wall.asking.thickness_text import parse_thickness, table_file

BOTTLE = SimpleNamespace(
    finish_height_mm=300.0,
    stem_top_mm=0.0,
    regions={
        "base": (0.0, 2.0),
        "heel": (2.0, 8.0),
        "body": (8.0, 200.0),
        "shoulder": (200.0, 230.0),
        "neck": (230.0, 284.0),
        "finish": (284.0, 300.0),
    },
)

thicknesses = st.floats(0.01, 50.0, allow_nan=False)


@st.composite
def tables(draw):
    steps = draw(st.lists(st.floats(0.01, 100.0), min_size=2, max_size=8))
    values = draw(st.lists(thicknesses, min_size=len(steps), max_size=len(steps)))
    return tuple(np.cumsum(steps).tolist()), tuple(values)


@pytest.mark.parametrize("text", ["3", "3mm", "3 mm", " 3.0 ", "3,0"])
def test_one_number_is_a_uniform_wall(text):
    assert parse_thickness(text) == UniformThickness(3.0)


def test_a_uniform_wall_is_the_same_at_each_height():
    wall = parse_thickness("2.5").over_height(BOTTLE)
    assert wall.uniform_mm == 2.5
    assert np.array_equal(wall.at(np.array([0.0, 150.0, 300.0])), [2.5, 2.5, 2.5])
    assert np.array_equal(wall.slope(np.array([0.0, 150.0])), [0.0, 0.0])


@st.composite
def grids(draw):
    rows, columns = draw(st.integers(2, 5)), draw(st.integers(2, 6))
    heights = np.cumsum(draw(st.lists(st.floats(0.01, 100.0), min_size=rows, max_size=rows)))
    turns = np.array(draw(st.lists(st.floats(0.1, 1.0), min_size=columns + 1, max_size=columns + 1)))
    angles = 360.0 * np.cumsum(turns)[:-1] / turns.sum()
    values = draw(st.lists(thicknesses, min_size=rows * columns, max_size=rows * columns))
    table = np.reshape(values, (rows, columns)).tolist()
    return tuple(heights.tolist()), tuple(angles.tolist()), tuple(map(tuple, table))


walls = st.one_of(
    thicknesses.map(UniformThickness),
    st.builds(lambda table, kind: TabulatedThickness(*table, kind), tables(), st.sampled_from(INTERPOLATIONS)),
    st.dictionaries(st.sampled_from(REGIONS), thicknesses, min_size=1).map(RegionalThickness),
    st.builds(lambda grid, kind: GridThickness(*grid, kind), grids(), st.sampled_from(INTERPOLATIONS)),
    st.builds(FaceThickness, st.dictionaries(st.integers(1, 999), thicknesses, min_size=1), thicknesses),
)


@given(st.one_of(walls, st.builds(BoredThickness, walls, st.floats(1e-3, 100.0))))
def test_text_and_thickness_say_the_same(thickness):
    assert parse_thickness(str(thickness)) == thickness


@given(grids())
@settings(deadline=None)
def test_a_smooth_grid_meets_its_values_and_stays_between_the_four_around(grid):
    heights, angles, values = map(np.array, grid)
    surface = PeriodicGrid(heights, angles, values)
    rows, columns = np.indices(values.shape)
    at_nodes = surface.at(heights[rows.ravel()], angles[columns.ravel()])
    assert np.abs(at_nodes - values.ravel()).max() <= 1e-9 * values.max()
    u, v = (array.ravel() for array in np.meshgrid(*2 * [np.linspace(0.0, 1.0, 9)]))
    turns = np.diff(angles, append=angles[0] + 360.0)
    for row in range(len(heights) - 1):
        for column in range(len(angles)):
            corners = values[row : row + 2][:, [column, (column + 1) % len(angles)]]
            inside = surface.at(
                heights[row] + u * (heights[row + 1] - heights[row]), angles[column] + v * turns[column]
            )
            assert corners.min() - 1e-9 * corners.max() <= inside.min()
            assert inside.max() <= corners.max() * (1.0 + 1e-9)


@given(tables())
@settings(deadline=None)
def test_a_grid_that_is_the_same_at_each_angle_is_its_table(table):
    heights, column = map(np.array, table)
    surface = PeriodicGrid(heights, np.array([10.0, 80.0, 300.0]), np.tile(column[:, None], 3))
    z = np.linspace(heights[0] - 1.0, heights[-1] + 1.0, 50)
    expected, _ = monotone_cubic(heights, column, z)
    assert np.abs(surface.at(z, 7.0 * z) - expected).max() <= 1e-9 * column.max()


def test_a_smooth_grid_has_no_kink_at_its_rows_nor_at_its_columns():
    random = np.random.default_rng(4)
    heights, angles = np.array([0.0, 30.0, 45.0, 100.0]), np.array([0.0, 50.0, 200.0, 290.0])
    surface = PeriodicGrid(heights, angles, random.uniform(1.0, 5.0, (4, 4)))
    step = 1e-5
    place = random.uniform(0.0, 360.0, 50)
    for height in heights[1:-1]:
        below, here, above = (surface.at(np.full(50, height + shift), place) for shift in (-step, 0.0, step))
        assert np.abs((above - here) - (here - below)).max() / step < 1e-4
    place = random.uniform(0.0, 100.0, 50)
    for angle in angles:
        before, here, after = (surface.at(place, np.full(50, angle + shift)) for shift in (-step, 0.0, step))
        assert np.abs((after - here) - (here - before)).max() / step < 1e-4


def test_a_linear_grid_is_bilinear_and_periodic():
    surface = PeriodicGrid(np.array([0.0, 10.0]), np.array([0.0, 90.0]), np.array([[1.0, 2.0], [3.0, 6.0]]), False)
    assert surface.at(np.array([5.0]), np.array([45.0])) == pytest.approx(3.0)
    assert surface.at(np.array([0.0]), np.array([225.0])) == pytest.approx(1.5)
    assert surface.at(np.array([-1.0]), np.array([-45.0])) == pytest.approx(1.0 + 1.0 / 6.0)


def test_full_turn_and_none_are_one_angle():
    without = parse_thickness("0@0:3 0@120:2 300@0:4 300@120:3")
    assert parse_thickness("0@0:3 0@120:2 0@360:3 300@0:4 300@120:3 300@360:4") == without
    assert parse_thickness("0@120:2 0@360:3 300@120:3 300@360:4") == without


@pytest.mark.parametrize(
    ("text", "wall"),
    [
        ("bore=18.5 3", "3"),
        ("3 mm bore=18.5mm", "3"),
        ("finish=2.5 bore=18,5 body=2", "finish=2.5 body=2"),
        ("0:2 300:5 linear bore=18.5", "0:2 300:5 linear"),
        ("Face12=4 bore=18.5 else=2", "Face12=4 else=2"),
    ],
)
def test_a_bore_goes_with_any_wall(text, wall):
    assert parse_thickness(text) == BoredThickness(parse_thickness(wall), 18.5)


def test_a_linear_table_keeps_that_in_its_text():
    thickness = parse_thickness("0:2 300:5 linear")
    assert thickness.interpolation == "linear"
    assert parse_thickness(str(thickness)) == thickness
    assert thickness.over_height(BOTTLE).at(100.0) == pytest.approx(3.0, abs=1e-12)
    assert thickness.over_height(BOTTLE).slope(100.0) == pytest.approx(0.01, abs=1e-12)


@given(tables())
@settings(deadline=None)
def test_smooth_interpolation_is_pchip(table):
    knots, values = map(np.array, table)
    x = np.linspace(knots[0], knots[-1], 101)
    value, slope = monotone_cubic(knots, values, x)
    expected = PchipInterpolator(knots, values)
    steepest = np.abs(np.diff(values) / np.diff(knots)).max()
    assert np.abs(value - expected(x)).max() <= 1e-9 * values.max()
    between = np.abs(x[:, None] - knots).min(axis=1) > 1e-6
    assert np.abs(slope - expected.derivative()(x))[between].max(initial=0.0) <= 1e-6 * (steepest + 1.0)


@given(tables())
def test_smooth_interpolation_stays_between_its_rows(table):
    knots, values = map(np.array, table)
    for row in range(len(knots) - 1):
        low, high = sorted(values[row : row + 2])
        between, _ = monotone_cubic(knots, values, np.linspace(knots[row], knots[row + 1], 33))
        assert between.min() >= low - 1e-9 * high
        assert between.max() <= high + 1e-9 * high


@pytest.mark.parametrize(
    "text",
    [
        "height_mm,thickness_mm\n0,5\n40,2.5\n300,3\n",
        "height_mm;thickness_mm\n0;5\n40;2,5\n300;3\n",
        "\ufeffthickness_mm;height_mm;note\r\n5;0;base\r\n2,5;40;\r\n\r\n3;300;\r\n",
        "height_mm\tthickness_mm\n0\t5\n40\t2,5\n300\t3\n",
    ],
)
def test_tables_are_read_from_csv(tmp_path, text):
    path = tmp_path / "my wall.csv"
    path.write_text(text, encoding="utf-8")
    assert parse_thickness(f"@{path}") == TabulatedThickness((0.0, 40.0, 300.0), (5.0, 2.5, 3.0))


@pytest.mark.parametrize(
    "text",
    [
        "height_mm,angle_deg,thickness_mm\n0,0,5\n0,90,4.5\n300,0,3\n300,90,2\n",
        "angle_deg;height_mm;thickness_mm\n0;0;5\n90;0;4,5\n0;300;3\n90;300;2\n",
    ],
)
def test_grids_are_read_from_csv(tmp_path, text):
    path = tmp_path / "my wall.csv"
    path.write_text(text)
    grid = GridThickness((0.0, 300.0), (0.0, 90.0), ((5.0, 4.5), (3.0, 2.0)))
    assert parse_thickness(f"@{path}") == grid
    assert parse_thickness(f"@{path} linear bore=18") == BoredThickness(replace(grid, interpolation="linear"), 18.0)


def test_the_file_of_a_table_is_known_whatever_follows_it():
    assert table_file("@my wall.csv linear bore=18") == "my wall.csv"
    assert table_file("0:3 300:2") is None


def test_regions_hold_in_their_middle_and_blend_at_their_ends():
    wall = parse_thickness("finish=2.5 neck=3 shoulder=2.2 body=2 heel=4 base=5").over_height(BOTTLE)
    for name, expected in (("finish", 2.5), ("neck", 3.0), ("shoulder", 2.2), ("body", 2.0), ("heel", 4.0)):
        low, high = BOTTLE.regions[name]
        assert wall.at(0.5 * (low + high)) == pytest.approx(expected, abs=1e-12)
    assert 2.0 < wall.at(200.0) < 2.2
    assert wall.minimum_mm == 2.0
    assert wall.maximum_mm == 5.0


def test_the_base_has_its_thickness_however_high_it_is_pushed_up():
    wall = parse_thickness("body=2 base=5").over_height(BOTTLE)
    assert wall.at(22.0, underside=True) == 5.0
    assert wall.at(60.0) == 2.0
    assert np.array_equal(wall.at(np.array([22.0, 60.0]), np.array([True, False])), [5.0, 2.0])


def test_regions_left_out_blend_between_their_neighbours():
    wall = parse_thickness("body=2 finish=4").over_height(BOTTLE)
    heights = np.linspace(0.0, 300.0, 301)
    assert np.all(np.diff(wall.at(heights)) >= 0.0)
    assert 2.5 < wall.at(220.0) < 3.5


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "empty"),
        ("0", "above 0"),
        ("-1", "above 0"),
        ("0.001", "at least 0.01 mm"),
        ("nan", "finite"),
        ("inf", "finite"),
        ("three", "number"),
        ("body=0", "above 0"),
        ("body=nan", "finite"),
        ("bodi=2", "body"),
        ("body=2 body=3", "twice"),
        ("body", "number"),
        ("body=2 3", "region=thickness"),
        ("bore=18.5", "give a thickness, too"),
        ("3 bore=0", "bore: must be above 0"),
        ("3 bore=-2", "bore: must be above 0"),
        ("3 bore=nan", "bore.*finite"),
        ("3 bore=wide", "bore: expected a number"),
        ("3 bore=18 bore=19", "bore: given twice"),
        ("Face12=4", "else=2"),
        ("else=2", "no face is named"),
        ("Face0=4 else=2", "counted from 1"),
        ("Face2=4 Face2=3 else=2", "Face2: given twice"),
        ("Face2=4 else=2 else=3", "else: given twice"),
        ("Face2=0 else=2", "Face2: must be above 0"),
        ("Face2=4 else=-2", "else: must be above 0"),
        ("Face2=4 body=3 else=2", "do not go together"),
        ("0@0:3 0@90:2 40@0:3 300@0:3 300@90:2", "height 40 mm lacks angle 90 deg"),
        ("0@0:3 0@90:2 300@0:3 300@90:2 40@0:3 40@90:3", "40 mm follows 300 mm; sort"),
        ("0@0:3 0@90:2 0@90:2 300@0:3 300@90:2", "height 0 mm, angle 90 deg is given twice"),
        ("0@0:3 0@370:2 300@0:3 300@370:2", "angle 370 deg is not within 0 to 360"),
        ("0@0:3 0@-90:2 300@0:3 300@-90:2", "angle -90 deg is not within 0 to 360"),
        ("0@0:3 0@nan:2 300@0:3 300@nan:2", "angle_deg.*finite"),
        ("0@0:3 0@90:nan 300@0:3 300@90:2", "thickness_mm.*finite"),
        ("0@0:3 0@90:0 300@0:3 300@90:2", "above 0"),
        ("0@0:3 0@90:2 0@360:3 300@0:3 300@90:2 300@360:2", "at height 300 mm, 0 deg has 3 mm but 360 deg"),
        ("0@0:3 0@90:2", "two heights"),
        ("0@0:3 300@0:2", "two angles"),
        ("0@0:3 0@90", "height@angle:thickness"),
        ("0@0:3 40:2", "height@angle:thickness"),
        ("0:2 0:3", "height 0 mm is given twice"),
        ("50:2 0:3", "sort"),
        ("0:2", "two rows"),
        ("0:2 300:-1", "above 0"),
        ("0:2 nan:3", "finite"),
        ("0:2 100", "height:thickness"),
        ("@missing.csv", "missing.csv"),
    ],
)
def test_an_impossible_wall_is_refused_in_one_sentence(text, word):
    with pytest.raises(InputError, match=word) as caught:
        parse_thickness(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "word"),
    [
        ("", "empty"),
        ("0,5\n300,3\n", "height_mm"),
        ("height_mm,angle_deg,thickness_mm\n0,0,3\n", "two heights"),
        ("height_mm,angle_deg,thickness_mm\n0,0,3\n0,90,2\n300,90,3\n", "height 300 mm lacks angle 0 deg"),
        ("height_mm,angle_deg,thickness_mm\n0,0,3\n0,,2\n", "line 3, angle_deg"),
        ("height_mm,height_mm,thickness_mm\n0,0,3\n", "height_mm twice"),
        ("height_mm,thickness_mm\n0,5\n40,\n300,3\n", "line 3"),
        ("height_mm,thickness_mm\n0,5\n40\n300,3\n", "line 3"),
        ("height_mm,thickness_mm\n300,5\n0,3\n", "sort"),
        ("height_mm,thickness_mm\n0,5\n300,0\n", "above 0"),
    ],
)
def test_an_impossible_table_is_refused_and_named(tmp_path, content, word):
    path = tmp_path / "wall.csv"
    path.write_text(content)
    with pytest.raises(InputError, match=word) as caught:
        parse_thickness(f"@{path}")
    assert str(caught.value).startswith(f"{path}")


@pytest.mark.parametrize(
    ("content", "line", "word"),
    [
        ("height_mm,thickness_mm\n\n0,5\n100,NaN\n300,2\n", 4, "finite"),
        ("height_mm,thickness_mm\n0,5\n200,3\n100,2\n", 4, "height 100 mm follows 200 mm; sort"),
        ("height_mm,thickness_mm\n0,5\n0,3\n", 3, "given twice"),
        ("height_mm,thickness_mm\n0,5\n200,-1\n300,2\n", 3, "above 0"),
        ("height_mm,angle_deg,thickness_mm\n0,0,5\n0,400,4\n300,0,3\n300,400,3\n", 3, "angle 400 deg is not within"),
        ("height_mm,angle_deg,thickness_mm\n0,0,5\n0,360,4\n300,0,3\n300,360,3\n", 3, "the same angle"),
        ("height_mm,angle_deg,thickness_mm\n0,0,5\n0,90,4\n300,0,3\n", 4, "lacks angle 90 deg"),
        ("height_mm,angle_deg,thickness_mm\n0,0,5\n0,90,4\n0,90,4\n300,0,3\n300,90,3\n", 4, "given twice"),
        ("height_mm,angle_deg,thickness_mm\n0,0,nan\n", 2, "thickness_mm: every number must be finite"),
        ("height_mm,thickness\n0,5\n", 1, "no column thickness_mm"),
    ],
)
def test_what_is_wrong_with_a_table_is_told_with_file_and_line(tmp_path, content, line, word):
    path = tmp_path / "wall.csv"
    path.write_text(content)
    with pytest.raises(InputError) as caught:
        parse_thickness(f"@{path}")
    assert str(caught.value).startswith(f"{path}, line {line}")
    assert word in str(caught.value)


@pytest.mark.parametrize(
    "content",
    [
        "height_mm,thickness_mm\n0,5\n250,2\n",
        "height_mm,angle_deg,thickness_mm\n0,0,5\n0,90,2\n250,0,5\n250,90,3\n",
    ],
)
def test_a_table_that_is_too_short_for_the_mold_is_told_with_its_file(tmp_path, content):
    path = tmp_path / "short.csv"
    path.write_text(content)
    with pytest.raises(InputError, match="covers heights 0 to 250 mm") as caught:
        parse_thickness(f"@{path}").on(SimpleNamespace(anatomy=BOTTLE))
    assert str(caught.value).startswith(f"{path}: ")


def test_a_table_is_the_same_whatever_file_it_is_from(tmp_path):
    path = tmp_path / "wall.csv"
    path.write_text("height_mm,thickness_mm\n0,5\n300,2\n")
    wall = parse_thickness(f"@{path}")
    assert parse_thickness(str(wall)) == wall
    assert shortened(wall) == "@wall.csv"
    assert shortened(parse_thickness(f"@{path} linear bore=18")) == "@wall.csv linear bore=18"


def test_a_long_wall_is_shortened_between_its_ends():
    long = " ".join(f"{height}:{2 + height / 1000}" for height in range(0, 301, 10))
    assert shortened(parse_thickness(long)) == "0:2 10:2.01 20:2.02 … 300:2.3"
    assert shortened(parse_thickness(f"{long} linear bore=18")) == "0:2 10:2.01 20:2.02 … 300:2.3 linear bore=18"
    named = "finish=2.5 neck=3 shoulder=2.2 body=2 heel=4 base=5"
    assert shortened(parse_thickness(named)) == named


def test_a_region_that_is_not_known_is_told_with_those_of_the_mold_from_top_to_bottom():
    with pytest.raises(InputError, match="there is finish, neck, shoulder, body, stem, heel, base; faces are Face1"):
        parse_thickness("handle=3")
    with pytest.raises(InputError, match="there is body, base; faces are Face1"):
        parse_thickness("handle=3", ("body", "base"))
    with pytest.raises(InputError, match="did you mean 'Face12'"):
        parse_thickness("Fac12=3 else=2")


def test_a_face_below_the_first_is_told_before_what_else_is_missing():
    with pytest.raises(InputError, match="Face0: faces are counted from 1"):
        parse_thickness("Face0=3")


def test_a_file_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "wall.csv"
    path.write_bytes(bytes(range(128, 256)))
    with pytest.raises(InputError, match="text"):
        parse_thickness(f"@{path}")


def test_a_table_must_reach_from_base_to_finish():
    with pytest.raises(InputError, match="covers heights 0 to 250"):
        parse_thickness("0:3 250:2").over_height(BOTTLE)


@pytest.mark.parametrize("text", ["neck=2", "body=3 neck=2", "body=2 stem=3"])
def test_regions_must_be_some_that_the_mold_has(text):
    tumbler = SimpleNamespace(
        finish_height_mm=100.0, stem_top_mm=0.0, regions={"base": (0.0, 5.0), "body": (5.0, 100.0)}
    )
    with pytest.raises(InputError, match="it has body, base"):
        parse_thickness(text).over_height(tumbler)


def test_what_a_stem_is_given_does_not_reach_into_the_bowl():
    glass = SimpleNamespace(
        finish_height_mm=200.0,
        stem_top_mm=90.0,
        regions={"base": (0.0, 6.0), "stem": (6.0, 90.0), "body": (90.0, 180.0), "finish": (180.0, 200.0)},
    )
    wall = parse_thickness("base=9 stem=8 body=2 finish=1").over_height(glass)
    assert wall.at(90.0) == 2.0
    assert wall.maximum_mm == 2.0
    with pytest.raises(InputError, match="stay solid; give the thickness of finish, body"):
        parse_thickness("stem=8").over_height(glass)


def test_the_underside_has_the_thickness_of_the_lowest_region_named():
    wall = parse_thickness("body=2 heel=4").over_height(BOTTLE)
    assert wall.at(22.0, underside=True) == 4.0
