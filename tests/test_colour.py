"""Colours against colour-science (make test installs it into .venv), and against what must hold without it."""

import sys
from pathlib import Path

import numpy as np
import pytest

from glassworkbench.colour import ILLUMINANTS, WAVELENGTHS_NM, illuminant, lab, linear_srgb, tristimulus
from glassworkbench.colour import white as white_of
from glassworkbench.errors import InputError
from glassworkbench.glass import catalogue, fillings

COLOUR_SCIENCE = Path(__file__).resolve().parent.parent / ".venv" / "colour-science"
MATERIALS = {**catalogue(), **fillings()}


@pytest.fixture(scope="module")
def colour_science():
    sys.path.append(str(COLOUR_SCIENCE))
    try:
        return pytest.importorskip("colour", reason="make test installs colour-science; this is a run without it")
    finally:
        sys.path.remove(str(COLOUR_SCIENCE))


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("light", ILLUMINANTS)
@pytest.mark.parametrize("name", MATERIALS)
def test_colours_agree_with_colour_science(colour_science, name, light):
    material = MATERIALS[name]
    observer = colour_science.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    shape = colour_science.SpectralShape(380, 780, 1)
    fine_nm = np.arange(380.0, 781.0)
    power = colour_science.SDS_ILLUMINANTS[light].copy().align(shape)
    for path_mm in (0.5, 3.0, 12.0):
        spectrum = colour_science.SpectralDistribution(material.transmittance(fine_nm, path_mm), fine_nm)
        theirs = colour_science.sd_to_XYZ(spectrum, observer, power, method="Integration") / 100.0
        one = colour_science.SpectralDistribution(np.ones_like(fine_nm), fine_nm)
        their_white = colour_science.sd_to_XYZ(one, observer, power, method="Integration") / 100.0
        their_lab = colour_science.XYZ_to_Lab(theirs, colour_science.XYZ_to_xy(their_white))
        ours = tristimulus(material.transmittance(WAVELENGTHS_NM, path_mm), light)
        our_lab = lab(ours, white_of(light))
        assert colour_science.delta_E(our_lab, their_lab, method="CIE 2000") <= 0.1
        assert np.allclose(
            linear_srgb(ours),
            ours @ np.array(colour_science.models.RGB_COLOURSPACE_sRGB.matrix_XYZ_to_RGB).T,
            atol=2e-4,
        )


def test_the_whites_are_those_of_the_standard():
    for light, chromaticity in {"D65": (0.31272, 0.32903), "A": (0.44758, 0.40745), "E": (1 / 3, 1 / 3)}.items():
        xyz = white_of(light)
        assert xyz[:2] / xyz.sum() == pytest.approx(chromaticity, abs=5e-5)
        assert xyz[1] == pytest.approx(1.0, abs=1e-12)


def test_grey_is_grey_in_every_light():
    grey = np.full(len(WAVELENGTHS_NM), 0.18418651851244416)
    for light in ILLUMINANTS:
        assert lab(tristimulus(grey, light), white_of(light)) == pytest.approx((50.0, 0.0, 0.0), abs=1e-9)
    assert linear_srgb(tristimulus(grey)) == pytest.approx([0.1842] * 3, abs=1e-4)


def test_an_unknown_illuminant_suggests_the_nearest():
    with pytest.raises(InputError, match="illuminant 'D56' is not known; did you mean 'D65'"):
        illuminant("D56")
    with pytest.raises(InputError, match="expected 81 wavelengths"):
        tristimulus(np.ones(3))
