"""Which effects a scene calls for, and how the tolerance is spent."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene import Scene
from glassworkbench.scene.validate import finite
from glassworkbench.settings import unknown_name
from glassworkbench.tracer.extent import longest_chord_mm

EFFECTS = ("absorption",)

PRUNED_SHARE = 0.025
"""The cut-off as a share of the tolerance (measured on the peers' bottle: what is left out may lead to light that
differs from all other, and the paths that are kept are found again at a pixel's other corners)."""

LARGEST_CUTOFF = 0.1
"""A first glance should still show a reflection of a tenth."""

NEGLIGIBLE_SHARE = 0.1
"""An effect is left out if all it can change is this share of the tolerance."""


@dataclass(frozen=True)
class Effect:
    """One effect of light, and whether the scene calls for it."""

    name: str
    on: bool
    why: str


@dataclass(frozen=True)
class Plan:
    """How a scene will be traced.

    Parameters
    ----------
    tolerance : float
        Error of a pixel's radiance that the user accepts.
    cutoff : float
        Weight below which a ray is left out.
    effects : tuple of Effect
    """

    tolerance: float
    cutoff: float
    effects: tuple[Effect, ...]

    def is_on(self, name: str) -> bool:
        """Tell whether an effect is traced."""
        return any(effect.name == name and effect.on for effect in self.effects)


def plan(scene: Scene, tolerance: float, overrule: Mapping[str, bool] | None = None) -> Plan:
    """Decide which effects to trace so that leaving out the others stays far below the tolerance.

    Parameters
    ----------
    scene : Scene
    tolerance : float
        Above 0, in units of radiance: a plain panel of radiance 1 is white.
    overrule : mapping of str to bool, optional
        Effects that the user switches on or off.

    Raises
    ------
    InputError
        If the tolerance is not above 0, or an effect is unknown.
    """
    if not finite(tolerance, "tolerance") > 0.0:
        raise InputError(f"tolerance: must be above 0, got {tolerance:g}")
    overrule = dict(overrule or {})
    for name in overrule:
        if name not in EFFECTS:
            raise unknown_name("effect", name, EFFECTS)
    brightest = max(scene.brightest(), 1e-300)
    effects = (_absorption(scene, tolerance, overrule.get("absorption")),)
    return Plan(tolerance, min(PRUNED_SHARE * tolerance / brightest, LARGEST_CUTOFF), effects)


def _absorption(scene: Scene, tolerance: float, wish: bool | None) -> Effect:
    path_mm = longest_chord_mm(scene)
    change = scene.brightest() * -np.expm1(-float(np.max(scene.absorptions_per_mm())) * path_mm)
    if wish is not None:
        return Effect("absorption", bool(wish), f"asked for; it can change a pixel by up to {change:.2g}")
    on = bool(change > NEGLIGIBLE_SHARE * tolerance)
    against = "more" if on else "no more"
    why = (
        f"over {path_mm:.0f} mm it can change a pixel by up to {change:.2g}, {against} than "
        f"{NEGLIGIBLE_SHARE:g} x tolerance"
    )
    return Effect("absorption", on, why)
