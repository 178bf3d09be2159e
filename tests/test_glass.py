"""The catalogue: figures that must come out, and that each number tells where it is from."""

import numpy as np
import pytest

from glassworkbench.colour import WAVELENGTHS_NM, linear_srgb, tristimulus, white
from glassworkbench.errors import InputError
from glassworkbench.glass import Filling, Glass, catalogue, fillings, find_filling, find_glass, refused

MATERIALS = {**catalogue(), **fillings()}
SODIUM_D_NM = 589.29
HELIUM_D_NM = 587.5618


def test_the_catalogue_has_the_usual_container_glasses_and_drinks():
    coloured = {"emerald", "dead_leaf", "champagne_green", "antique_green", "amber", "cobalt_blue", "black"}
    assert {"flint", "extra_white_flint", "borosilicate", "lead_crystal", "n_bk7", *coloured} <= set(catalogue())
    assert {"water", "red_wine", "white_wine", "beer", "spirit", "olive_oil"} <= set(fillings())
    assert all(isinstance(glass, Glass) for glass in catalogue().values())
    assert all(isinstance(filling, Filling) for filling in fillings().values())


@pytest.mark.parametrize("name", MATERIALS)
def test_every_material_tells_its_sources_and_covers_what_eyes_see(name):
    material = MATERIALS[name]
    assert all((material.description, material.source, material.dispersion.source))
    low, high = material.range_nm
    assert low <= 380.0
    assert high >= 780.0
    assert np.all(material.refractive_index(WAVELENGTHS_NM) > 1.3)
    assert np.all(material.absorption_per_mm(WAVELENGTHS_NM) >= 0.0)
    assert np.all(np.diff(material.refractive_index(WAVELENGTHS_NM)) < 0.0)


@pytest.mark.parametrize(
    ("name", "wavelength_nm", "index"),
    [
        ("flint", HELIUM_D_NM, 1.52338),
        ("amber", HELIUM_D_NM, 1.52338),
        ("borosilicate", HELIUM_D_NM, 1.4715),
        ("lead_crystal", HELIUM_D_NM, 1.54814),
        ("n_bk7", HELIUM_D_NM, 1.51680),
        ("n_bk7", 435.8343, 1.52668),
        ("n_bk7", 656.2725, 1.51432),
        ("water", SODIUM_D_NM, 1.33335),
        ("ethanol", SODIUM_D_NM, 1.36150),
        ("spirit", SODIUM_D_NM, 1.355),
        ("olive_oil", SODIUM_D_NM, 1.4690),
    ],
)
def test_published_indices_come_out(name, wavelength_nm, index):
    assert MATERIALS[name].refractive_index(wavelength_nm) == pytest.approx(
        index, abs=6e-6 if index != 1.4715 else 5e-5
    )


def test_the_index_told_is_that_at_the_helium_d_line():
    assert find_glass("n_bk7").refractive_index_d == pytest.approx(1.5168, abs=1e-6)
    assert find_glass("n_bk7").abbe_number == pytest.approx(64.17, abs=0.01)
    assert find_glass("lead_crystal").abbe_number == pytest.approx(45.75, abs=0.01)


def test_clear_glass_absorbs_as_rubin_measured():
    k = np.array([1.925e-7, 2.200e-7, 8.371e-7])
    wavelengths = np.array([450.0, 550.0, 650.0])
    assert np.allclose(find_glass("clear").absorption_per_mm(wavelengths), 4.0 * np.pi * k / (1e-6 * wavelengths))


@pytest.mark.parametrize(
    ("wavelength_nm", "k"), [(380, 6.07e-7), (450, 3.43e-7), (550, 2.43e-7), (650, 6.52e-7), (1050, 3.60e-6)]
)
def test_iron_absorbs_as_measured_in_float_glass(wavelength_nm, k):
    # M. R. Vogt et al. 2016, float glass with 703 ppm of Fe2O3.
    float_glass = find_glass("flint Fe2O3=0.0703 redox=0.29")
    assert float_glass.absorption_per_mm(wavelength_nm) == pytest.approx(
        4.0 * np.pi * k / (1e-6 * wavelength_nm), rel=0.1
    )


def test_amber_passes_at_most_ten_percent_of_harmful_light_at_two_millimetres():
    inside = find_glass("amber").transmittance(np.arange(290.0, 450.5, 0.5), 2.0)
    assert 0.0 < inside.max() <= 0.10
    assert find_glass("amber").plate_transmittance(np.arange(310.0, 450.5, 0.5), 2.0).max() <= 0.10


def test_only_amber_and_black_protect_so():
    protecting = {
        name for name in catalogue() if find_glass(name).plate_transmittance(np.arange(310.0, 451.0), 2.0).max() <= 0.10
    }
    assert "amber" in protecting
    assert not protecting & {"flint", "clear", "emerald", "cobalt_blue", "borosilicate", "georgia_green"}


@pytest.mark.parametrize(
    ("name", "brightest"), [("emerald", 1), ("cobalt_blue", 2), ("amber", 0), ("red_wine", 0), ("georgia_green", 1)]
)
def test_colours_are_what_their_names_say(name, brightest):
    material = MATERIALS[name]
    passed = material.rgb_transmittance(material.usual_path_mm)
    assert np.argmax(passed) == brightest
    assert np.argmax(linear_srgb(material.colour(material.usual_path_mm))) == brightest


@pytest.mark.parametrize("name", MATERIALS)
def test_traced_colours_are_the_true_ones_at_the_usual_path(name):
    material = MATERIALS[name]
    true = linear_srgb(material.colour(material.usual_path_mm)) / linear_srgb(white())
    traced = material.rgb_transmittance(material.usual_path_mm)
    assert np.all(material.rgb_absorption_per_mm() >= 0.0)
    shown = (true > 0.05) & (true < 1.0)
    assert np.allclose(traced[shown], true[shown], rtol=1e-9)
    assert np.all(traced[~shown & (true <= 0.05)] < 0.05)


def test_a_saturated_channel_is_fitted_where_it_still_passes_light():
    amber = find_glass("amber")
    blue = amber.rgb_absorption_per_mm()[2]
    path = -np.log(0.05) / blue
    passed = linear_srgb(tristimulus(amber.transmittance(WAVELENGTHS_NM, path))) / linear_srgb(white())
    assert passed[2] == pytest.approx(0.05, rel=1e-6)


def test_transmittance_multiplies_along_the_path():
    emerald = find_glass("emerald")
    whole = emerald.transmittance(WAVELENGTHS_NM, 5.0)
    assert np.allclose(whole, emerald.transmittance(WAVELENGTHS_NM, 2.0) * emerald.transmittance(WAVELENGTHS_NM, 3.0))


def test_a_plate_loses_what_its_faces_reflect():
    # A lossless slab of n_d = 1.52338 reflects 2R / (1 + R) = 0.082491.
    passed = find_glass("extra_white_flint Fe2O3=0").plate_transmittance(HELIUM_D_NM, 2.0)
    assert passed == pytest.approx(1.0 - 0.082491, abs=1e-6)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: find_glass("flint").refractive_index(300.0),
            "flint: refractive index: 300 nm lies outside 310 to 4600 nm",
        ),
        (
            lambda: find_glass("amber").absorption_per_mm([400.0, 1300.0]),
            "amber: absorption: 1300 nm lies outside 290 to",
        ),
        (lambda: find_glass("amber").absorption_per_mm(float("nan")), "nan nm lies outside"),
        (
            lambda: find_filling("water").refractive_index(1200.0),
            "water: refractive index: 1200 nm lies outside 182 to",
        ),
        (lambda: find_filling("olive_oil").refractive_index(350.0), "olive_oil: .*350 nm"),
    ],
)
def test_outside_its_range_a_formula_is_an_error(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_a_recipe_is_changed_by_whoever_knows_better():
    emerald, deeper = find_glass("emerald"), find_glass("emerald Cr2O3=0.4 redox=0.5")
    assert deeper.name == "emerald Cr2O3=0.4 redox=0.5"
    assert deeper.absorption_per_mm(650.0) > 1.8 * emerald.absorption_per_mm(650.0)
    assert deeper.refractive_index_d == emerald.refractive_index_d
    blue = find_glass("flint CoO=0.05")
    assert np.argmin(blue.rgb_absorption_per_mm()) == 2
    assert find_filling("beer EBC=40").absorption_per_mm(430.0) == pytest.approx(
        np.log(10.0) / 10.0 * 40 / 25, rel=2e-3
    )


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("Emrald", "did you mean 'emerald'"),
        ("xyzzy", r"there is .*amber"),
        ("opal", "glass 'opal': opal glass scatters light inside, which is not traced"),
        ("emerald Cr203=0.1", "colourants: 'Cr203' is not known; did you mean 'Cr2O3'"),
        ("emerald Cr2O3=much", "Cr2O3 must be a number, got 'much'"),
        ("emerald Cr2O3=-1", "colourants: Cr2O3: must not be negative"),
        ("emerald Cr2O3=nan", "colourants: Cr2O3: must be finite"),
        ("emerald redox=2", "redox: must lie between 0"),
        ("clear Fe2O3=0.1", "clear: its absorption was measured as a whole"),
    ],
)
def test_what_is_no_glass_is_told_in_one_sentence(name, message):
    with pytest.raises(InputError, match=message) as caught:
        find_glass(name)
    assert "\n" not in str(caught.value)


def test_an_unknown_filling_suggests_the_nearest():
    with pytest.raises(InputError, match="did you mean 'water'"):
        find_filling("watter")


def test_opal_is_refused_with_its_reason():
    assert "opal" not in catalogue()
    assert refused()["opal"].startswith("opal glass scatters")
