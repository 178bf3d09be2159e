"""What is known of a material, for reports and for readers."""

from __future__ import annotations

import math

import numpy as np

from glassworkbench.colour import lab, white
from glassworkbench.glass.chromophores import Chromophore
from glassworkbench.glass.material import Filling, Glass
from glassworkbench.glass.swatch import shown_colour


def facts(material: Glass | Filling) -> dict[str, object]:
    """Return what a report tells of a material; units are in the names."""
    usual_mm = material.usual_path_mm
    abbe = material.abbe_number
    return {
        "name": material.name,
        "description": material.description,
        "refractive_index_d": material.refractive_index_d,
        "abbe_number": abbe if math.isfinite(abbe) else None,
        "density_g_per_cm3": material.density_g_per_cm3,
        "range_nm": material.range_nm,
        "usual_path_mm": usual_mm,
        "colour": shown_colour(material, usual_mm),
        "lab": lab(material.colour(usual_mm), white()),
        "absorption_per_mm": material.rgb_absorption_per_mm(),
        "recipe": {name: amount for recipe in material.recipes for name, amount in recipe.amounts.items()},
        "redox": next((recipe.redox for recipe in material.recipes), None),
        "source": material.source,
        "refractive_index_source": material.dispersion.source,
        "chromophores": [
            {"name": chromophore.name, "source": chromophore.source, "assumed": chromophore.assumed}
            for chromophore in _chromophores(material)
        ],
        "assumed": material.assumed,
    }


def in_words(material: Glass | Filling) -> list[str]:
    """Return the lines in which a reader is told of a material."""
    told = facts(material)
    low, high = material.range_nm
    lines = [
        f"{material.name}: {material.description}",
        f"refractive index  n_d = {material.refractive_index_d:.5f}"
        + (f", Abbe number {told['abbe_number']:.1f}" if told["abbe_number"] else ", constant"),
        f"density           {material.density_g_per_cm3:g} g/cm3",
        f"known             {low:g} to {high:g} nm",
    ]
    usual_mm = material.usual_path_mm
    for path_mm in (usual_mm / 3.0, usual_mm):
        lightness, red, yellow = lab(material.colour(path_mm), white())
        lines.append(
            f"{f'colour of {path_mm:g} mm':17} {shown_colour(material, path_mm)}, "
            f"L* {lightness:.1f} a* {red:.1f} b* {yellow:.1f} in daylight"
        )
    wavelengths = np.arange(max(400.0, math.ceil(low / 50.0) * 50.0), min(700.0, high) + 1.0, 50.0)
    passed = material.transmittance(wavelengths, usual_mm / 3.0)
    shares = ", ".join(f"{100.0 * share:.3g} % at {nm:g}" for nm, share in zip(wavelengths, passed, strict=True))
    lines.append(f"{f'{usual_mm / 3.0:g} mm pass':17} {shares} nm, reflections left out")
    amounts = [f"{name}={amount:g}" for name, amount in told["recipe"].items()]
    if told["redox"] is not None:
        amounts.append(f"redox={told['redox']:g}")
    if amounts:
        lines.append(f"recipe            {' '.join(amounts)}")
    lines.append(f"source            {material.source}")
    if material.dispersion.source:
        lines.append(f"  index           {material.dispersion.source}")
    for chromophore in _chromophores(material):
        assumed = f"; assumed: {chromophore.assumed}" if chromophore.assumed else ""
        lines.append(f"  {chromophore.name:15} {chromophore.source}{assumed}")
    if material.assumed:
        lines.append(f"assumed           {material.assumed}")
    return lines


def _chromophores(material: Glass | Filling) -> tuple[Chromophore, ...]:
    return tuple(chromophore for recipe in material.recipes for chromophore in recipe.chromophores)
