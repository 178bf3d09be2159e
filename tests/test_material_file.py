"""Glasses of one's own: files, a folder of them, and what is wrong with a faulty one."""

import numpy as np
import pytest

from glassworkbench.errors import InputError
from glassworkbench.glass import catalogue, find_filling, find_glass
from glassworkbench.glass.own_glasses import keep

RUBY = """
[glass.ruby]
refractive_index = 1.53
absorption_per_mm = [0.02, 0.6, 0.5]
density_g_per_cm3 = 2.6
"""
MEASURED = """
[glass.mine]
dispersion = { formula = "table", wavelengths_nm = [380, 500, 780], refractive_index = [1.54, 1.53, 1.52] }
absorption = { wavelengths_nm = [380, 500, 780], internal_transmittance = [0.5, 0.9, 0.8], thickness_mm = 2.0 }
density_g_per_cm3 = 2.5
"""
RECIPE = """
[chromophore.neodymium]
colourant = "Nd2O3"
molar_mass_g_per_mol = 168.24
range_nm = [350, 900]
bands = [{ centre_nm = 585, width_per_cm = 600, strength = 6 }]

[glass.lilac]
dispersion = "soda_lime"
colourants = { Fe2O3 = 0.02, Nd2O3 = 2.0 }
redox = 0.2
density_g_per_cm3 = 2.55
"""


def written(folder, text):
    path = folder / "mine.toml"
    path.write_text(text)
    return str(path)


def test_a_file_brings_a_glass(tmp_path):
    path = written(tmp_path, RUBY)
    assert find_glass(path).name == "ruby"
    assert find_glass(f"{path}:ruby").refractive_index(450.0) == 1.53
    assert find_glass(path).rgb_absorption_per_mm().tolist() == [0.02, 0.6, 0.5]
    assert find_glass(path).absorption_per_mm([450.0, 550.0, 650.0]).tolist() == [0.5, 0.6, 0.02]
    written(tmp_path, RUBY + RUBY.replace("ruby", "rose"))
    with pytest.raises(InputError, match="holds 2 tables"):
        find_glass(path)
    with pytest.raises(InputError, match="did you mean 'rose'"):
        find_glass(f"{path}:rse")


def test_a_measured_spectrum_is_taken_as_it_is(tmp_path):
    mine = find_glass(written(tmp_path, MEASURED))
    assert mine.transmittance([380.0, 500.0, 780.0], 2.0) == pytest.approx([0.5, 0.9, 0.8])
    assert mine.refractive_index(440.0) == pytest.approx(1.535)
    with pytest.raises(InputError, match="mine: refractive index: 379 nm lies outside 380 to 780 nm"):
        mine.refractive_index(379.0)


def test_a_spectrum_from_400_to_700_nm_is_enough_for_a_colour(tmp_path):
    text = MEASURED.replace("380", "400").replace("780", "700")
    mine = find_glass(written(tmp_path, text))
    whole = find_glass(f"{written(tmp_path, MEASURED)}")
    assert np.allclose(mine.rgb_absorption_per_mm(), whole.rgb_absorption_per_mm(), rtol=0.3)
    assert mine.colour(0.0)[1] == pytest.approx(1.0)
    short = find_glass(written(tmp_path, text.replace("[400, 500, 700], internal", "[400, 500, 650], internal")))
    with pytest.raises(InputError, match="mine: absorption is known from 400 to 650 nm; a colour needs 400 to 700 nm"):
        short.rgb_absorption_per_mm()


def test_a_file_brings_colourants_of_its_own(tmp_path):
    lilac = find_glass(written(tmp_path, RECIPE))
    neodymium_mol_per_l = 2.55 * 1000 * 0.02 / 168.24
    iron = find_glass("flint Fe2O3=0.02 redox=0.2").absorption_per_mm(585.0) * 2.55 / 2.5
    assert lilac.absorption_per_mm(585.0) == pytest.approx(iron + np.log(10) / 10 * 6 * neodymium_mol_per_l)


def test_a_glass_is_like_another_but_for_what_it_says(tmp_path):
    text = '[glass.deep]\nlike = "emerald"\ncolourants = { Cr2O3 = 0.4 }\ndescription = "deep green"'
    deep, emerald = find_glass(written(tmp_path, text)), find_glass("emerald Cr2O3=0.4")
    wavelengths = np.linspace(400.0, 700.0, 31)
    assert np.allclose(deep.absorption_per_mm(wavelengths), emerald.absorption_per_mm(wavelengths))
    assert deep.density_g_per_cm3 == emerald.density_g_per_cm3
    assert deep.description == "deep green"
    assert deep.source.startswith("like emerald: ")
    heavier = find_glass(
        written(tmp_path, '[glass.x]\nlike = "emerald"\nabsorption_per_mm = [1, 2, 3]\nrefractive_index = 1.6')
    )
    assert heavier.rgb_absorption_per_mm().tolist() == [1.0, 2.0, 3.0]
    assert heavier.refractive_index_d == 1.6


def test_a_file_brings_a_filling(tmp_path):
    tea = find_filling(written(tmp_path, '[filling.tea]\nlike = "water"\ncolourants = { A420 = 1.5 }') + ":tea")
    assert tea.transmittance(420.0, 10.0) == pytest.approx(10**-1.5, rel=1e-3)


def test_the_users_folder_joins_the_catalogue(tmp_path, monkeypatch):
    monkeypatch.setenv("GLASSWORKBENCH_GLASSES", str(tmp_path))
    written(tmp_path, RUBY)
    assert find_glass("ruby").density_g_per_cm3 == 2.6
    assert list(catalogue())[-1] == "ruby"
    (tmp_path / "broken.toml").write_text(RUBY.replace("1.53", "0.5"))
    with pytest.warns(UserWarning, match=r"broken\.toml: .*refractive_index.*; the file is left out of the catalogue"):
        assert "ruby" in catalogue()


def test_a_file_is_kept_for_good(tmp_path, monkeypatch):
    monkeypatch.setenv("GLASSWORKBENCH_GLASSES", str(tmp_path / "data" / "glasses"))
    path = written(tmp_path, RUBY)
    assert keep(path) == ["ruby"]
    assert catalogue()["ruby"].refractive_index_d == 1.53
    with pytest.raises(InputError, match="'ruby' is in the catalogue already; give it another name"):
        keep(path)
    with pytest.raises(InputError, match="refractive_index: must lie between"):
        keep(written(tmp_path, RUBY.replace("1.53", "0.5").replace("ruby", "rose")))
    with pytest.raises(InputError, match=r"is no file of glasses; give one that ends in \.toml or \.fcmat"):
        keep(tmp_path / "mine.csv")
    (tmp_path / "empty.toml").write_text("")
    with pytest.raises(InputError, match="holds no glass and no filling"):
        keep(tmp_path / "empty.toml")


def test_a_recipe_with_a_colourant_of_its_own_is_changed(tmp_path):
    path = written(tmp_path, RECIPE)
    paler = find_glass(f"{path} Nd2O3=1")
    wavelength_nm = 585.0
    difference = find_glass(path).absorption_per_mm(wavelength_nm) - paler.absorption_per_mm(wavelength_nm)
    assert difference == pytest.approx(np.log(10) / 10 * 6 * 2.55 * 10 / 168.24)


FAULTS = [
    (RUBY, "refractive_index", "refractive_indx", "did you mean 'refractive_index'"),
    (RUBY, "density_g_per_cm3 = 2.6", "", "'density_g_per_cm3' is missing"),
    (RUBY, "1.53", "0.9", "refractive_index: must lie between 1 and 5, but is 0.9"),
    (RUBY, "1.53", "nan", "refractive_index: must be finite"),
    (RUBY, "1.53", '"high"', "refractive_index: must be a number"),
    (RUBY, "refractive_index = 1.53", "", "refractive_index, dispersion: neither is; give one"),
    (RUBY, "refractive_index = 1.53", 'refractive_index = 1.5\ndispersion = "soda_lime"', "both are given"),
    (RUBY, "absorption_per_mm = [0.02, 0.6, 0.5]", "", "absorption: is missing; give colourants"),
    (RUBY, "[0.02, 0.6, 0.5]", "[0.02, 0.6]", "absorption_per_mm: must be three numbers"),
    (RUBY, "[0.02, 0.6, 0.5]", "[0.02, -0.6, 0.5]", "absorption_per_mm: must not be negative, got -0.6"),
    (RUBY, "[0.02, 0.6, 0.5]", "[0.02, nan, 0.5]", "absorption_per_mm: must be finite"),
    (RUBY, "2.6", "nan", "density_g_per_cm3: must be finite"),
    (RUBY, "2.6", "0", "density_g_per_cm3: must be above 0"),
    (RUBY, "2.6", "2600", "no glass has 2600 g/cm3; is it in kg/m3"),
    (RUBY, "2.6", "2.6\nlike = []", r"like: must be a text in quotation marks, got \[\]"),
    (RUBY, "[0.02, 0.6, 0.5]", "[0.02, 1e300, 0.5]", "absorption_per_mm: must be at most 1e.06 per mm"),
    (RECIPE, "Nd2O3 = 2.0", "Nd2O3 = 200", "colourants: Nd2O3: must be at most 100"),
    (RECIPE, "168.24", "0.1", "no colourant is lighter than hydrogen"),
    (RECIPE, "strength = 6", "strength = 1e9", "strength: must be at most 1e.06"),
    (RECIPE, 'colourant = "Nd2O3"', "colourant = 7", "colourant: must be a text in quotation marks, got 7"),
    (RUBY, "[glass.ruby]", "[glas.ruby]", "did you mean 'glass'"),
    (RUBY, "[glass.ruby]", "[glass]", r"\[glass\] must hold tables"),
    (RUBY, "1.53", "1,53", "not valid TOML"),
    (RUBY, "2.6", "2.6\nredox = 0.2", "redox: is for colourants"),
    (RUBY, "2.6", '2.6\nlike = "amberr"', "like: 'amberr' is not known; did you mean 'amber'"),
    (RUBY, "2.6", '2.6\nlike = "ruby"', "like: 'ruby' is no glass with numbers of its own"),
    (MEASURED, "[380, 500, 780], internal", "[380, 780, 500], internal", "must rise, but 500 nm follows 780 nm; sort"),
    (MEASURED, "[380, 500, 780], internal", "[380, nan, 500], internal", "wavelengths_nm: must be finite"),
    (MEASURED, "[380, 500, 780], internal", "[380, 500], internal", "3 values for 2 wavelengths_nm"),
    (MEASURED, "[0.5, 0.9, 0.8]", "[0.5, 1.9, 0.8]", "internal_transmittance must lie above 0"),
    (
        MEASURED,
        "internal_transmittance = [0.5, 0.9, 0.8], thickness_mm = 2.0",
        "per_mm = [0.1, -0.2, 0]",
        "absorption: must not be negative, got -0.2",
    ),
    (MEASURED, ", thickness_mm = 2.0", "", "thickness_mm belongs to internal_transmittance"),
    (MEASURED, "internal_transmittance", "internal_transmission", "did you mean 'internal_transmittance'"),
    (MEASURED, "[1.54, 1.53, 1.52]", "[1.54, 0.53, 1.52]", "refractive_index: must lie between 1 and 5, but is"),
    (MEASURED, '"table"', '"tabel"', "formula 'tabel' is not known; did you mean 'table'"),
    (MEASURED, 'formula = "table", ', "", "dispersion: formula is missing; there is sellmeier"),
    (RECIPE, "Nd2O3 = 2.0", "Nd203 = 2.0", "colourants: 'Nd203' is not known; did you mean 'Nd2O3'"),
    (RECIPE, "Nd2O3 = 2.0", "Nd2O3 = -2.0", "colourants: Nd2O3: must not be negative"),
    (RECIPE, "redox = 0.2", "", "redox: is missing, the reduced share of Fe2O3"),
    (RECIPE, "redox = 0.2", "redox = 20", "redox: must lie between 0"),
    (RECIPE, '"soda_lime"', '"sodalime"', "dispersion: 'sodalime' is not known; did you mean 'soda_lime'"),
    (RECIPE, "strength = 6", "strength = -6", r"\[chromophore.neodymium\] strength: must not be negative"),
    (RECIPE, "width_per_cm = 600", "width = 600", "key 'width' is not known; did you mean 'width_per_cm'"),
    (RECIPE, "[350, 900]", "[900, 350]", "range_nm: must rise"),
    (RECIPE, "bands = [", "band = [", "key 'band' is not known; did you mean 'bands'"),
]


@pytest.mark.parametrize(("text", "old", "new", "message"), FAULTS)
def test_a_faulty_file_is_told_in_one_sentence_with_file_and_field(tmp_path, text, old, new, message):
    assert old in text
    path = written(tmp_path, text.replace(old, new, 1))
    with pytest.raises(InputError, match=message) as caught:
        find_glass(path)
    assert str(caught.value).startswith(path)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_is_told(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        find_glass(str(tmp_path / "none.toml"))
