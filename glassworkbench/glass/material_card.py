"""Material cards of FreeCAD (.FCMat): density, and the refractive index where the card has one.

FreeCAD 0.20 writes cards as sections of ``Key = value``; from 1.0 on they are YAML, nested ``Key: "value"``. Keys are
the same. Neither has absorption: a card may name the glass of the catalogue whose colour it has.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from glassworkbench.errors import InputError
from glassworkbench.glass.checks import above_zero
from glassworkbench.glass.dispersion import ScaledDispersion
from glassworkbench.glass.material import HELIUM_D_NM, Glass
from glassworkbench.settings import unknown_name

CARD_ENDING = ".fcmat"

COLOUR_KEY = "GlassWorkbenchColour"
"""The card's own key for the glass of the catalogue whose colour it has."""

INDEX_KEYS = ("RefractiveIndex", "IndexOfRefraction", "Render.Glass.IOR")
"""The last is that of the Render workbench, whose model of glass FreeCAD 1.0 carries."""

COLOURLESS = "flint"

_LINE = re.compile(r"""^\s*([A-Za-z][\w.]*)\s*[:=]\s*(?:"([^"]*)"|'([^']*)'|(.*?))\s*$""")
_DENSITY = re.compile(r"\s*(-?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)\s*(kg/m\^3|g/cm\^3|kg/mm\^3|t/m\^3|kg/l|g/ml)\s*")
_G_PER_CM3 = {"kg/m^3": 1e-3, "g/cm^3": 1.0, "kg/mm^3": 1e6, "t/m^3": 1.0, "kg/l": 1.0, "g/ml": 1.0}


def read_card(path: Path, glasses: Mapping[str, Glass]) -> Glass:
    """Return the glass of a material card.

    Parameters
    ----------
    path : Path
    glasses : dict of str to Glass
        Those whose colour a card may have.

    Raises
    ------
    InputError
        If the file cannot be read, has no density, or does not say that it is glass.
    """
    values = _values(path)
    if "Density" not in values:
        raise InputError(f"{path}: Density is missing; add it to the card, as 2500 kg/m^3")
    density = _DENSITY.fullmatch(values["Density"])
    if density is None:
        raise InputError(f"{path}: Density: expected a number with its unit, as 2500 kg/m^3, got {values['Density']!r}")
    colour = values.get(COLOUR_KEY, COLOURLESS)
    if colour not in glasses:
        raise unknown_name(f"{path}: {COLOUR_KEY}", colour, glasses)
    like = glasses[colour]
    index = next((values[key] for key in INDEX_KEYS if values.get(key)), None)
    if index is None and COLOUR_KEY not in values and not _says_glass(values):
        raise InputError(f"{path}: nothing says that it is glass; add {INDEX_KEYS[0]} or {COLOUR_KEY} to the card")
    assumed = [] if COLOUR_KEY in values else [f"absorption: that of {COLOURLESS}"]
    dispersion = like.dispersion
    if index is None:
        assumed.append(f"refractive index: that of {colour}")
    else:
        try:
            dispersion = ScaledDispersion(like.dispersion, HELIUM_D_NM, float(index))
        except ValueError as error:
            raise InputError(f"{path}: the refractive index must be a number, got {index!r}") from error
        except InputError as error:
            raise InputError(f"{path}: {error}") from error
        assumed.append(f"dispersion: that of {colour}, scaled")
    return replace(
        like,
        name=re.sub(r"\W+", "_", path.stem).strip("_").lower(),
        dispersion=dispersion,
        density_g_per_cm3=above_zero(float(density[1]), f"{path}: Density") * _G_PER_CM3[density[2]],
        description=values.get("Description", path.stem),
        source=f"FreeCAD's material card {path.name}",
        assumed="; ".join(assumed),
    )


def _says_glass(values: Mapping[str, str]) -> bool:
    return any("glass" in values.get(key, "").lower().split() for key in ("Name", "Father"))


def _values(path: Path) -> dict[str, str]:
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError as error:
        raise InputError(f"{path}: there is no such file; check the path") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no material card of FreeCAD (not text)") from error
    found = [match for line in lines if line.lstrip()[:1] not in (";", "#") and (match := _LINE.match(line))]
    return {match[1]: next((value for value in match.groups()[1:] if value is not None), "") for match in found}
