"""What a spectrum looks like: the CIE 1931 observer, illuminants, colour spaces for screens and for differences."""

from glassworkbench.colour.observer import ILLUMINANTS, WAVELENGTHS_NM, illuminant, tristimulus, white
from glassworkbench.colour.spaces import lab, linear_srgb

__all__ = [
    "ILLUMINANTS",
    "WAVELENGTHS_NM",
    "illuminant",
    "lab",
    "linear_srgb",
    "tristimulus",
    "white",
]
