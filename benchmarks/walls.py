"""Hollows every mold by every wall and every method, and prints which came out right.

A result is right if 99 % of the wall is within max(2 % of the wall, 0.02 mm), nowhere more than 5 % too thin, and the
solid valid, closed and free of self-intersections. `too thick` is a wall that cannot be: the answer says where and
how much fits. Results are kept in out/bench/walls.jsonl; only what is missing there is run (`--again` runs all).
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "out" / "bench" / "walls.jsonl"
SHARED = ROOT.parent / "shared" / "molds"
METHODS = ("auto", "revolved", "lofted", "inner_mesh", "thick_solid", "scaled", "scaled_per_axis")
HOLLOW = ("osk00_bottle.step", "besumit_day02_beverage_bottle.step", "myfreecad_vase.step", "occt_bottle.brep")
BLOCKS = ("pp_mould_cup.step", "pp_mould_bowl.step")
WALLS = ("1 mm", "2 mm", "3 mm", "2 %", "4 %", "8 %", "table", "grid")


def molds() -> dict[str, dict]:
    """Return the molds' files and how each is read."""
    found = {path.stem: {"path": str(path)} for path in sorted((ROOT / "examples" / "molds").glob("*.step"))}
    found |= {Path(name).stem: {"path": str(SHARED / name), "outer_shell": True} for name in HOLLOW}
    found |= {Path(name).stem: {"path": str(SHARED / name), "block": True} for name in BLOCKS}
    return {name: how for name, how in found.items() if Path(how["path"]).exists()}


def wall_of(mold: object, name: str) -> object:
    """Return the wall that a column's name stands for on a mold."""
    from glassworkbench.wall import GridThickness, TabulatedThickness, UniformThickness

    width, height = mold.anatomy.smallest_width_mm, mold.anatomy.finish_height_mm
    if name.endswith("mm"):
        return UniformThickness(float(name.split()[0]))
    if name.endswith("%"):
        return UniformThickness(round(0.01 * float(name.split()[0]) * width, 3))
    middle = round(0.03 * width, 3)
    if name == "table":
        # From 2.5 times the thinnest at the base to the thinnest at the shoulder, and some more at the finish.
        rows = ((0.0, 2.5), (0.1, 2.0), (0.3, 1.3), (0.6, 1.0), (0.85, 1.2), (1.0, 1.5))
        return TabulatedThickness(
            tuple(share * height for share, _ in rows), tuple(0.65 * middle * factor for _, factor in rows)
        )
    heights = tuple(share * height for share in (0.0, 0.3, 0.7, 1.0))
    angles = (0.0, 90.0, 180.0, 270.0)
    factors = ((1.0, 1.0, 1.0, 1.0), (1.3, 1.0, 0.7, 1.0), (0.7, 1.0, 1.3, 1.0), (1.0, 1.0, 1.0, 1.0))
    return GridThickness(heights, angles, tuple(tuple(middle * factor for factor in row) for row in factors))


def run(mold_name: str, wall_name: str, method: str, seconds: float) -> dict:
    """Run one case in a process of its own and return its line."""
    case = {"mold": mold_name, "wall": wall_name, "method_asked": method}
    words = [sys.executable, __file__, "--case", mold_name, wall_name, method, "--seconds", str(seconds)]
    start = time.perf_counter()
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=2.0 * seconds + 60.0)
        answer = json.loads(done.stdout.strip().splitlines()[-1])
    except subprocess.TimeoutExpired:
        answer = {"outcome": "past its limit", "why": "killed by the benchmark"}
    except (IndexError, ValueError):
        answer = {"outcome": "crashed", "why": done.stderr.strip().splitlines()[-1:]}
    return {**case, **answer, "whole_seconds": round(time.perf_counter() - start, 2)}


def one_case(mold_name: str, wall_name: str, method: str, seconds: float) -> dict:
    """Hollow one mold here and return what came out."""
    from glassworkbench.errors import GlassWorkbenchError, InputError
    from glassworkbench.mold import read_mold
    from glassworkbench.wall import hollow

    how = dict(molds()[mold_name])
    mold = read_mold(how.pop("path"), **how)
    start = time.perf_counter()
    try:
        report = hollow(mold, wall_of(mold, wall_name), method=method, seconds=seconds).report.to_json()
    except InputError as error:
        return {"outcome": "too thick", "why": str(error), "seconds": round(time.perf_counter() - start, 2)}
    except GlassWorkbenchError as error:
        return {"outcome": "none", "why": str(error), "seconds": round(time.perf_counter() - start, 2)}
    kept = {key: report[key] for key in ("method", "tried", "solid", "weight_g", "seconds")}
    return {"outcome": "right", "measured": report["wall"], **kept}


def cell(line: dict | None) -> str:
    """Return a result as a cell of the table."""
    if line is None:
        return ""
    if line["outcome"] != "right":
        return line["outcome"]
    by = f"{line['method']} " if line["method_asked"] == "auto" else ""
    return f"{by}{line['measured']['deviation_p99_mm']:.3f} mm {line['seconds']:.1f} s"


def show(lines: list[dict], methods: list[str]) -> None:
    """Print the table and its summary."""
    cases = {(line["mold"], line["wall"], line["method_asked"]): line for line in lines}
    rows = list(dict.fromkeys((line["mold"], line["wall"]) for line in lines))
    print("| mold | wall | " + " | ".join(methods) + " |")
    print("| --- | --- |" + " --- |" * len(methods))
    for mold, wall in rows:
        print(f"| {mold} | {wall} | " + " | ".join(cell(cases.get((mold, wall, method))) for method in methods) + " |")
    for method in methods:
        mine = [line for line in lines if line["method_asked"] == method]
        feasible = [line for line in mine if line["outcome"] != "too thick"]
        right = [line for line in feasible if line["outcome"] == "right"]
        if mine:
            print(
                f"{method}: {len(right)} of {len(feasible)} feasible cases right, {len(mine) - len(feasible)} too thick"
            )
        for made in sorted({line["method"] for line in right}):
            seconds = [line["seconds"] for line in right if line["method"] == made]
            print(f"  {made}: {len(seconds)}, median {statistics.median(seconds):.1f} s, longest {max(seconds):.1f} s")


def main() -> int:
    """Run what is asked for and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS))
    parser.add_argument("--molds", nargs="+", help="names that begin so")
    parser.add_argument("--walls", nargs="+", choices=WALLS, default=list(WALLS))
    parser.add_argument("--seconds", type=float, default=120.0, help="limit of one case")
    parser.add_argument("--jobs", type=int, default=1, help="cases at a time; seconds are honest only with 1")
    parser.add_argument("--again", action="store_true", help="forget the results that are kept")
    parser.add_argument("--case", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    sys.path.insert(0, str(ROOT))
    if options.case:
        print(json.dumps(one_case(*options.case, options.seconds)))
        return 0
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    if options.again:
        RESULTS.unlink(missing_ok=True)
    kept = [json.loads(line) for line in RESULTS.read_text().splitlines()] if RESULTS.exists() else []
    done = {(line["mold"], line["wall"], line["method_asked"]) for line in kept}
    chosen = [name for name in molds() if not options.molds or name.startswith(tuple(options.molds))]
    cases = [
        (mold, wall, method)
        for mold in chosen
        for wall in options.walls
        for method in options.methods
        if (mold, wall, method) not in done
    ]
    with ThreadPoolExecutor(options.jobs) as pool, RESULTS.open("a") as file:
        for case, line in zip(cases, pool.map(lambda case: run(*case, options.seconds), cases), strict=True):
            kept.append(line)
            file.write(json.dumps(line) + "\n")
            file.flush()
            print(f"{case[0]}, {case[1]}, {case[2]}: {cell(line)}", file=sys.stderr, flush=True)
    show([line for line in kept if line["mold"] in chosen and line["wall"] in options.walls], options.methods)
    return 0


if __name__ == "__main__":
    sys.exit(main())
