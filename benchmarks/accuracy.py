"""Do price lists come true? Seconds and errors as predicted and as measured, on a few scenes of 90x120 pixels.

    accuracy.py [--seconds S] [SCENE ...]

A point holds if its seconds are within 1.5 times and its error within 2 times of what was predicted. Beside the
seconds stand processor seconds, by which the prediction is judged, too: on a busy machine the clock tells of others.
The price lists are left in out/bench/accuracy.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import glassworkbench as gw  # noqa: E402
from glassworkbench.staging.sample import sample_container  # noqa: E402

SIZE = (90, 120)
SCENES = {
    "tumbler before a panel": lambda: gw.station("sidewall", sample_container(), "emerald", size=SIZE),
    "tumbler in the studio": lambda: gw.station("studio", sample_container(), "emerald", size=SIZE),
    "tumbler with wine": lambda: gw.station("sidewall", sample_container(), "flint", "red_wine:60", size=SIZE),
    "ball lens": lambda: replace(gw.read_scene(ROOT / "examples" / "scenes" / "ball_lens.toml"), size=SIZE),
}
SECONDS_WITHIN, ERROR_WITHIN, GOAL = 1.5, 2.0, 0.9
FOLDER = ROOT / "out" / "bench" / "accuracy"


def within(predicted, measured, factor):
    """Tell whether two numbers above 0 are within a factor; None where one is not known."""
    if measured is None:
        return None
    return max(predicted, measured) <= factor * max(min(predicted, measured), 1e-12)


def show(values, form):
    """Return numbers as text, with a dash for what is not known."""
    return "".join(f"{'-':>11}" if value is None else f"{value:>11{form}}" for value in values)


def main(names, seconds):
    held = {"seconds": [], "CPU seconds": [], "error": []}
    for name in names:
        prices = gw.accuracy(SCENES[name](), seconds=seconds, measure=True)
        FOLDER.mkdir(parents=True, exist_ok=True)
        prices.save(FOLDER / name.replace(" ", "_"))
        print(f"{name}: pilot {prices.pilot_seconds:.1f} s, errors against {prices.reference}")
        print(f"{'':28}{'seconds':>11}{'measured':>11}{'CPU s':>11}{'measured':>11}{'error':>11}{'measured':>11}")
        for price in prices.prices:
            times = (price.predicted_seconds, price.seconds, price.predicted_cpu_seconds, price.cpu_seconds)
            print(
                f"  {price.name:26}{show(times, '.2f')}{show((price.predicted_error, price.error), '.1e')}", flush=True
            )
            held["seconds"].append(within(*times[:2], SECONDS_WITHIN))
            held["CPU seconds"].append(within(*times[2:], SECONDS_WITHIN))
            held["error"].append(within(price.predicted_error, price.error, ERROR_WITHIN))
    missed = False
    for what, found in held.items():
        known = [hold for hold in found if hold is not None]
        share = sum(known) / max(len(known), 1)
        missed |= share < GOAL
        print(f"{what} as predicted: {share:.0%} of {len(known)} points")
    return missed


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    options = parser.parse_args()
    sys.exit(main(options.scenes or SCENES, options.seconds))
