from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from glassworkbench.errors import InputError
from glassworkbench.wall.thickness import (
    REGIONS,
    RegionalThickness,
    TabulatedThickness,
    UniformThickness,
    monotone_cubic,
    parse_thickness,
)

BOTTLE = SimpleNamespace(
    finish_height_mm=300.0,
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


@given(st.one_of(thicknesses.map(UniformThickness), tables().map(lambda table: TabulatedThickness(*table))))
def test_text_and_thickness_say_the_same(thickness):
    assert parse_thickness(str(thickness)) == thickness


@given(st.dictionaries(st.sampled_from(REGIONS), thicknesses, min_size=1))
def test_regions_and_their_text_say_the_same(regions):
    thickness = RegionalThickness(regions)
    assert parse_thickness(str(thickness)) == thickness


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
        ("bore=18.5", "bore"),
        ("Face12=4 else=2", "per face"),
        ("0:2 0:3", "sort"),
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
        ("height_mm,angle_deg,thickness_mm\n0,0,3\n", "angle_deg"),
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
    assert "wall.csv" in str(caught.value)


def test_a_file_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "wall.csv"
    path.write_bytes(bytes(range(128, 256)))
    with pytest.raises(InputError, match="text"):
        parse_thickness(f"@{path}")


def test_a_table_must_reach_from_base_to_finish():
    with pytest.raises(InputError, match="covers heights 0 to 250"):
        parse_thickness("0:3 250:2").over_height(BOTTLE)


def test_regions_must_be_some_that_the_mold_has():
    tumbler = SimpleNamespace(finish_height_mm=100.0, regions={"base": (0.0, 5.0), "body": (5.0, 100.0)})
    with pytest.raises(InputError, match="neck"):
        parse_thickness("neck=2").over_height(tumbler)
