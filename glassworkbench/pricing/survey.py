"""What a scene's choices cost and how wrong they are, predicted from some patches of the image.

The patches are traced in one order by all choices, in groups. A fine tolerance affords few of them: its cost on those
is scaled by what the coarsest tolerance, which affords many, costs on all of its groups against the same few. Errors
are differences to the finest tolerance that a few groups afford, with every effect on. Tolerances near that one and
below are predicted by a power law through the two before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from glassworkbench.pricing.choices import Choice, exact, truth
from glassworkbench.scene import Scene
from glassworkbench.tracer import Cancel, Plan
from glassworkbench.tracer.pilot import Pilot, patches

GROUP = 16
"""Patches that are traced together: 1024 pixels."""

LEAST_GROUPS = 3
"""Of the truth: the patches differ too much for fewer."""

STEP = 10.0**-0.5
"""From one tolerance to the next in the search for the truth."""

DEARER = 4.0
"""What such a step costs at most, as a rule."""

TRUE_STEP = 3.0
"""How much coarser than the truth a tolerance is whose error the truth can tell."""

COST_SLOPES, ERROR_SLOPES = (-1.5, 0.0), (0.3, 1.2)
"""Exponents over the tolerance that are believed."""


class Survey:
    """Trials of choices on patches of a scene's image.

    Parameters
    ----------
    scene : Scene
    tolerances : sequence of float
        Of the exact rendering, from coarse to fine.
    seconds : float
        What all trials may take, roughly.
    threads : int
    cancel : Cancel
    """

    def __init__(self, scene: Scene, tolerances: Sequence[float], seconds: float, threads: int, cancel: Cancel) -> None:
        self.scene = scene
        self._seconds, self._threads, self._cancel = seconds, threads, cancel
        parts = patches(scene)
        self._groups = [parts[k : k + GROUP] for k in range(0, len(parts), GROUP)]
        self._pixels = np.array([sum(part.width * part.height for part in group) for group in self._groups])
        self._pilots: dict[int, tuple[Scene, Pilot]] = {}
        self._trials: dict[tuple, _Trial] = {}
        self._truth_tolerance = self._find_truth(tolerances)
        self._truth = self._trial(truth(scene, self._truth_tolerance))
        self._extend(self._truth, 0.3 * seconds)
        self._coarsest = self._trial(truth(scene, tolerances[0]))
        self._extend(self._coarsest, 0.1 * seconds)
        tried = [tolerance for tolerance in tolerances if tolerance > TRUE_STEP * self._truth_tolerance]
        trials = [self._trial(exact(scene, tolerance)) for tolerance in tried]
        for trial in trials:
            self._extend(trial, 0.2 * seconds / len(trials))
        trials.append(self._truth)
        if self._truth_tolerance > 1.001 * tolerances[-1]:
            # What goes on from here by a power law had better begin with a step that was traced.
            trials.append(self._trial(truth(scene, STEP * self._truth_tolerance)))
            self._extend(trials[-1], 0.0)
        self._tolerances = np.array([trial.chosen.tolerance for trial in trials])
        self._costs = np.array([self._cost(trial) for trial in trials])
        self._errors = np.array([self._error(trial) for trial in trials[: len(tried)]])

    def exact(self, tolerance: float) -> tuple[np.ndarray, float, bool]:
        """Predict the exact rendering at any tolerance.

        Returns
        -------
        cost : array (2,)
            Seconds, and processor seconds.
        error : float
            Root mean square over the pixels, of the channel that is most off.
        is_traced : bool
            Whether the pilot's truth is fine enough to tell this error.
        """
        cost = [_power_law(tolerance, self._tolerances, column, COST_SLOPES) for column in self._costs.T]
        error = _power_law(tolerance, self._tolerances[: len(self._errors)], self._errors, ERROR_SLOPES)
        return np.array(cost), error, bool(tolerance > TRUE_STEP * self._truth_tolerance)

    def tried(self, choices: Sequence[Choice]) -> list[tuple[np.ndarray, float]]:
        """Try choices on patches; return of each its cost (2,) and error, as `exact` does."""
        found = []
        for choice in choices:
            trial = self._trial(choice)
            self._extend(trial, 0.4 * self._seconds / len(choices))
            found.append((self._cost(trial), self._error(trial)))
        return found

    def most_differing(self, choice: Choice) -> tuple[int, int]:
        """Return column and row of the middle of the patch where a choice is most off."""
        trial = self._trial(choice)
        groups = min(len(trial.radiance), len(self._truth.radiance))
        parts = [part for group in self._groups[:groups] for part in group]
        off = np.abs(np.concatenate(trial.radiance[:groups]) - np.concatenate(self._truth.radiance[:groups]))
        ends = np.cumsum([part.width * part.height for part in parts])[:-1]
        worst = parts[int(np.argmax([patch.mean() for patch in np.split(off, ends)]))]
        return worst.left + worst.width // 2, worst.top + worst.height // 2

    def _find_truth(self, tolerances: Sequence[float]) -> float:
        """Return the finest tolerance of which `LEAST_GROUPS` are affordable, two steps below the coarsest at least."""
        steps = int(np.floor(np.log(tolerances[-1] / tolerances[0]) / np.log(STEP) + 1e-9))
        for step in range(max(steps, 2) + 1):
            tolerance = tolerances[0] * STEP**step
            trial = self._trial(truth(self.scene, tolerance))
            self._extend(trial, 0.0)
            if step >= 2 and DEARER * LEAST_GROUPS * trial.costs[0][0] > 0.3 * self._seconds:
                break
        return tolerance

    def _trial(self, choice: Choice) -> _Trial:
        chosen = choice.plan()
        key = id(choice.scene), round(np.log10(chosen.tolerance), 6), tuple(effect.on for effect in chosen.effects)
        if key not in self._trials:
            self._trials[key] = _Trial(self._pilot(choice.scene, chosen), chosen)
        return self._trials[key]

    def _pilot(self, scene: Scene, chosen: Plan) -> Pilot:
        # The scene is kept beside, as its identity is the key.
        if id(scene) not in self._pilots:
            self._pilots[id(scene)] = scene, Pilot(scene, chosen, self._threads, self._cancel)
        return self._pilots[id(scene)][1]

    def _extend(self, trial: _Trial, seconds: float) -> None:
        """Trace groups until so many seconds are spent on them; one at least."""
        spent = sum(cost[0] for cost in trial.costs)
        while len(trial.costs) < len(self._groups):
            if trial.costs and spent + spent / len(trial.costs) > seconds:
                break
            cost, radiance = trial.pilot.trace(self._groups[len(trial.costs)], trial.chosen)
            trial.costs.append(cost)
            trial.radiance.append(radiance)
            spent += cost[0]

    def _cost(self, trial: _Trial) -> np.ndarray:
        groups, known = len(trial.costs), len(self._coarsest.costs)
        cost = self._mean(trial.costs)
        if groups < known:
            cost = cost * self._mean(self._coarsest.costs)[1] / self._mean(self._coarsest.costs[:groups])[1]
        return trial.pilot.set_up + cost * trial.pilot.pixels

    def _mean(self, costs: Sequence[np.ndarray]) -> np.ndarray:
        """Return the mean cost of a pixel of the first groups."""
        return np.sum(costs, axis=0) / self._pixels[: len(costs)].sum()

    def _error(self, trial: _Trial) -> float:
        groups = min(len(trial.radiance), len(self._truth.radiance))
        return error(np.concatenate(trial.radiance[:groups]), np.concatenate(self._truth.radiance[:groups]))


@dataclass(frozen=True, eq=False)
class _Trial:
    """The first groups as one choice shows them: of each its cost (2,) and its pixels (n, 3)."""

    pilot: Pilot
    chosen: Plan
    costs: list[np.ndarray] = field(default_factory=list)
    radiance: list[np.ndarray] = field(default_factory=list)


def error(radiance: np.ndarray, true: np.ndarray) -> float:
    """Return the root mean square over pixels (..., 3) of the channel that is most off."""
    return float(np.sqrt(np.mean(np.abs(radiance - true).max(axis=-1) ** 2)))


def _power_law(at: float, tolerances: np.ndarray, values: np.ndarray, slopes: tuple[float, float]) -> float:
    """Return a value at a tolerance: on straight lines between the logarithms known, and beyond the finest on the last.

    Parameters
    ----------
    at : float
    tolerances, values : array (n,)
        Tolerances falling.
    slopes : (float, float)
        The least and the greatest exponent that is believed beyond the finest tolerance.
    """
    x, y = np.log(tolerances[::-1]), np.log(np.maximum(values[::-1], 1e-12))
    if np.log(at) >= x[0]:
        return float(np.exp(np.interp(np.log(at), x, y)))
    slope = np.clip((y[1] - y[0]) / (x[1] - x[0]), *slopes) if len(x) > 1 else np.mean(slopes)
    return float(np.exp(y[0] + slope * (np.log(at) - x[0])))
