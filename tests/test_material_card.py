"""FreeCAD's material cards, as 0.20 and as 1.0 write them."""

import pytest

from glassworkbench.errors import InputError
from glassworkbench.glass import catalogue, find_glass

OLD = """; Glass-Generic
; (c) a comment with Density = 1 kg/m^3
[General]
Name = Glass
Description = Generic soda-lime glass
Father = Glass

[Mechanical]
Density = 2520 kg/m^3
PoissonRatio = 0.22
"""
NEW = """---
# File created by ConvertFCMat.py
General:
  UUID: "3e3a3e13-04a4-410e-8e36-bbd83ca66847"
  Name: "Flacon"
  Description: "Heavy glass for flacons"
Models:
  Density:
    UUID: '454661e5-265b-4320-8e6f-fcf6223ac3af'
    Density: "2.65 g/cm^3"
AppearanceModels:
  Render Glass:
    UUID: 'd76a56f5-7250-4efb-bb89-8ea0a9ccaa6b'
    Render.Glass.IOR: "1.56"
"""


def card(folder, text, name="My glass.FCMat"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_a_card_of_freecad_0_20_gives_the_density(tmp_path):
    glass = find_glass(card(tmp_path, OLD))
    assert glass.name == "my_glass"
    assert glass.density_g_per_cm3 == pytest.approx(2.52)
    assert glass.description == "Generic soda-lime glass"
    assert glass.refractive_index_d == find_glass("flint").refractive_index_d
    assert glass.assumed == "absorption: that of flint; refractive index: that of flint"


def test_a_card_of_freecad_1_0_gives_density_and_index(tmp_path):
    glass = find_glass(card(tmp_path, NEW))
    assert glass.density_g_per_cm3 == pytest.approx(2.65)
    assert glass.refractive_index_d == pytest.approx(1.56, abs=1e-9)
    assert glass.refractive_index(450.0) > 1.565
    assert "dispersion: that of flint, scaled" in glass.assumed


def test_a_card_may_name_the_glass_whose_colour_it_has(tmp_path):
    text = OLD.replace("Father = Glass", "Father = Glass\nGlassWorkbenchColour = amber")
    glass = find_glass(card(tmp_path, text))
    assert glass.absorption_per_mm(450.0) == find_glass("amber").absorption_per_mm(450.0)
    assert glass.assumed == "refractive index: that of amber"


def test_cards_in_the_users_folder_join_the_catalogue(tmp_path, monkeypatch):
    monkeypatch.setenv("GLASSWORKBENCH_GLASSES", str(tmp_path))
    card(tmp_path, NEW, "Flacon.FCMat")
    assert catalogue()["flacon"].density_g_per_cm3 == pytest.approx(2.65)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("Density = 2520 kg/m^3", "", "Density is missing"),
        ("2520 kg/m^3", "2520", "Density: expected a number with its unit, as 2500 kg/m.3, got '2520'"),
        ("2520 kg/m^3", "-1 kg/m^3", "Density: must be above 0, got -1"),
        (
            "Name = Glass\nDescription = Generic soda-lime glass\nFather = Glass",
            "Name = Steel",
            "nothing says that it is glass",
        ),
        ("[Mechanical]", "RefractiveIndex = high\n[Mechanical]", "refractive index must be a number, got 'high'"),
        ("[Mechanical]", "RefractiveIndex = 0.7\n[Mechanical]", "must lie between 1 and 5, but is"),
        ("[Mechanical]", "GlassWorkbenchColour = ambre\n[Mechanical]", "did you mean 'amber'"),
    ],
)
def test_a_faulty_card_is_told_in_one_sentence(tmp_path, old, new, message):
    assert old in OLD
    path = card(tmp_path, OLD.replace(old, new, 1))
    with pytest.raises(InputError, match=message) as caught:
        find_glass(path)
    assert str(caught.value).startswith(path)


def test_a_card_that_is_not_there_is_told(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        find_glass(str(tmp_path / "none.FCMat"))
