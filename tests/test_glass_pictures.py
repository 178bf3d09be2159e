"""Swatches and curves: the colours that are drawn are those of the glass."""

import numpy as np
import pytest

from glassworkbench.colour import linear_srgb
from glassworkbench.errors import InputError
from glassworkbench.glass import catalogue, facts, fillings, find_glass
from glassworkbench.glass.pictures import save_curves, save_swatches
from glassworkbench.images import to_display

matplotlib_image = pytest.importorskip("matplotlib.image")


def pixels(path):
    return np.rint(255.0 * matplotlib_image.imread(path)[..., :3]).astype(int)


def test_swatches_show_the_colour_at_each_thickness(tmp_path):
    amber = find_glass("amber")
    save_swatches({"amber": amber}, {}, tmp_path / "amber.png")
    picture = pixels(tmp_path / "amber.png")
    for thickness_mm in (1.0, 6.0, 11.0):
        colour = to_display(linear_srgb(amber.colour(thickness_mm))).astype(int)
        # Neighbouring shades of the wedge differ by up to two steps.
        assert np.any(np.abs(picture - colour).max(axis=2) <= 2)


def test_curves_are_drawn_of_all_and_of_one(tmp_path):
    save_curves(catalogue(), fillings(), tmp_path / "all.png")
    save_curves({}, {"beer": fillings()["beer"]}, tmp_path / "beer.png")
    everything, beer = pixels(tmp_path / "all.png"), pixels(tmp_path / "beer.png")
    assert everything.shape[0] > 4 * beer.shape[0]
    colour = to_display(linear_srgb(fillings()["beer"].colour(10.0))).astype(int)
    for picture in (everything, beer):
        assert np.count_nonzero(np.abs(picture - colour).max(axis=2) <= 1) > 3000


def test_a_picture_of_nothing_is_refused(tmp_path):
    for save in (save_swatches, save_curves):
        with pytest.raises(InputError, match="there is nothing to draw"):
            save({}, {}, tmp_path / "x.png")
        with pytest.raises(InputError, match=r"the ending '\.bmp' is not known"):
            save(catalogue(), {}, tmp_path / "x.bmp")


def test_facts_name_the_source_of_each_chromophore():
    told = facts(find_glass("emerald"))
    assert [row["name"] for row in told["chromophores"]] == ["ferric iron", "ferrous iron", "chromium"]
    assert all(row["source"] for row in told["chromophores"])
    assert told["recipe"] == {"Fe2O3": 0.3, "Cr2O3": 0.2}
    assert told["redox"] == 0.25
    assert facts(find_glass("clear"))["redox"] is None
