"""The ways to render a scene that a price list compares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from glassworkbench.pricing.meshing import DENSITIES, meshed, triangle_count
from glassworkbench.scene import Mesh, Scene
from glassworkbench.tracer import Plan, plan
from glassworkbench.tracer.plan import EFFECTS

EVERYTHING = dict.fromkeys(EFFECTS, True)
"""What the truth is traced with."""


@dataclass(frozen=True, eq=False)
class Choice:
    """One way to render a scene.

    Parameters
    ----------
    name : str
    kind : str
        ``exact``, ``mesh``, ``effect`` or ``unbent``.
    scene : Scene
    tolerance : float
    effects : mapping of str to bool
        What overrules the plan.
    """

    name: str
    kind: str
    scene: Scene
    tolerance: float
    effects: Mapping[str, bool] = field(default_factory=dict)

    def plan(self) -> Plan:
        """Return how it is traced."""
        return plan(self.scene, self.tolerance, self.effects)


def exact(scene: Scene, tolerance: float) -> Choice:
    """Return the scene as it is, by its plan."""
    return Choice(f"exact at {tolerance:.2g}", "exact", scene, tolerance)


def truth(scene: Scene, tolerance: float) -> Choice:
    """Return the scene as it is, with every effect on."""
    return Choice(f"everything at {tolerance:.2g}", "exact", scene, tolerance, EVERYTHING)


def simplified(scene: Scene, tolerance: float) -> Sequence[Choice]:
    """Return what does without bending, or without exact surfaces, or goes against the plan in one effect."""
    straight = [replace(medium, refractive_index=1.0) for medium in scene.media]
    choices = [Choice("unbent", "unbent", replace(scene, media=straight), tolerance)]
    if any(not isinstance(body.surface, Mesh) for body in scene.bodies):
        for density in range(DENSITIES):
            faceted = meshed(scene, density)
            name = f"mesh of {triangle_count(faceted)} triangles"
            choices.append(Choice(name, "mesh", faceted, tolerance))
    for effect in plan(scene, tolerance).effects:
        switched = not effect.on
        name = f"{effect.name} {'on' if switched else 'off'}"
        choices.append(Choice(name, "effect", scene, tolerance, {effect.name: switched}))
    return choices
