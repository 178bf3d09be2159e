"""Draws what a wall's accuracy costs in time, from what `walls.py` keeps, into docs/pictures/wall_prices.png."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import NullLocator

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "out" / "bench" / "walls.jsonl"
PICTURE = ROOT / "docs" / "pictures" / "wall_prices.png"
MARKS = {"revolved": "o", "thick_solid": "s", "lofted": "^", "inner_mesh": "D", "csg": "v"}


def main() -> int:
    """Draw one point for each case that came out right: seconds against deviation, by method."""
    if not RESULTS.exists():
        print(f"{RESULTS} is not there; run benchmarks/walls.py first", file=sys.stderr)
        return 1
    lines = [json.loads(line) for line in RESULTS.read_text().splitlines()]
    right = [line for line in lines if line["outcome"] == "right"]
    figure, axes = plt.subplots(figsize=(7.5, 4.5), layout="constrained")
    for method, mark in MARKS.items():
        mine = [line for line in right if line["method"] == method]
        seconds = [line["tried"][-1]["seconds"] for line in mine]
        share = [line["measured"]["deviation_p99_mm"] / line["measured"]["tolerance_mm"] for line in mine]
        if mine:
            axes.scatter(seconds, share, marker=mark, s=28, alpha=0.7, label=f"{method} ({len(mine)})")
    axes.axhline(1.0, color="grey", linewidth=1, linestyle="--")
    axes.text(0.01, 1.1, "accepted below this line", color="grey", transform=axes.get_yaxis_transform(), fontsize=8)
    axes.set(xscale="log", yscale="log", xlabel="seconds of the method, making and measuring (2 cores)")
    axes.set_ylabel("99 % deviation ÷ tolerance")
    for axis, ticks in ((axes.xaxis, (1, 2, 5, 10, 20, 50)), (axes.yaxis, (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1))):
        axis.set_ticks(ticks, [f"{tick:g}" for tick in ticks])
        axis.set_minor_locator(NullLocator())
    axes.grid(True, which="major", alpha=0.3)
    axes.legend(title="method (cases)")
    PICTURE.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(PICTURE, dpi=130)
    print(f"{PICTURE.relative_to(ROOT)}: {len(right)} of {len(lines)} cases")
    return 0


if __name__ == "__main__":
    sys.exit(main())
