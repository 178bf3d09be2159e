import numpy as np
import pytest

from glassworkbench.errors import InputError
from glassworkbench.glass import Filling, Glass, catalogue, fillings, find_filling, find_glass

RUBY = """
[glass.ruby]
refractive_index = 1.53
absorption_per_mm = [0.02, 0.6, 0.5]
density_g_per_cm3 = 2.6
"""


def test_the_catalogue_has_the_usual_container_glasses():
    assert {"flint", "emerald", "dead_leaf", "amber", "cobalt_blue"} <= set(catalogue())
    assert all(isinstance(glass, Glass) for glass in catalogue().values())
    assert all(glass.description and glass.source for glass in (*catalogue().values(), *fillings().values()))


def test_soda_lime_has_rubins_index():
    # Rubin 1985, wavelength in micrometres, at the helium d line.
    wavelength = 0.5875618
    rubin = 1.5130 - 0.003169 * wavelength**2 + 0.003962 / wavelength**2
    for glass in catalogue().values():
        assert glass.refractive_index == pytest.approx(rubin, abs=1e-5)


def test_clear_glass_absorbs_as_rubin_measured():
    k = np.array([8.371e-7, 2.200e-7, 1.925e-7])
    wavelength_mm = np.array([650e-6, 550e-6, 450e-6])
    assert np.allclose(find_glass("clear").absorption_per_mm, 4 * np.pi * k / wavelength_mm, rtol=1e-3)


def test_amber_protects_from_blue_light():
    assert find_glass("amber").transmittance(2.0)[2] <= 0.10


def test_transmittance_multiplies_along_the_path():
    emerald = find_glass("emerald")
    assert np.allclose(emerald.transmittance(5.0), emerald.transmittance(2.0) * emerald.transmittance(3.0))


def test_fillings_are_liquids():
    assert find_filling("water").refractive_index == pytest.approx(1.33335)
    assert isinstance(find_filling("ethanol"), Filling)


def test_an_unknown_name_suggests_the_nearest():
    with pytest.raises(InputError, match="did you mean 'emerald'"):
        find_glass("Emrald")
    with pytest.raises(InputError, match=r"there is .*amber"):
        find_glass("xyzzy")
    with pytest.raises(InputError, match="did you mean 'water'"):
        find_filling("watter")


def test_a_user_brings_a_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(RUBY)
    assert find_glass(str(path)).name == "ruby"
    assert find_glass(f"{path}:ruby").refractive_index == 1.53
    path.write_text(RUBY + RUBY.replace("ruby", "rose"))
    with pytest.raises(InputError, match="holds 2 tables"):
        find_glass(str(path))
    with pytest.raises(InputError, match="did you mean 'rose'"):
        find_glass(f"{path}:rse")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("refractive_index", "refractive_indx", "did you mean 'refractive_index'"),
        ("density_g_per_cm3 = 2.6", "", "'density_g_per_cm3' is missing"),
        ("1.53", "0.9", "at least 1"),
        ("1.53", '"high"', "refractive_index"),
        ("[0.02, 0.6, 0.5]", "[0.02, 0.6]", "three numbers"),
        ("[0.02, 0.6, 0.5]", "[0.02, -0.6, 0.5]", "negative"),
        ("2.6", "nan", "finite"),
        ("2.6", "0", "above 0"),
        ("[glass.ruby]", "[glas.ruby]", "did you mean 'glass'"),
        ("1.53", "1,53", "not valid TOML"),
    ],
)
def test_a_faulty_file_is_told_in_one_sentence(tmp_path, old, new, message):
    path = tmp_path / "mine.toml"
    path.write_text(RUBY.replace(old, new, 1))
    with pytest.raises(InputError, match=message) as caught:
        find_glass(str(path))
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)
