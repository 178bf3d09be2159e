"""The method `revolved` on every round mold and kind of wall: is the wall right, the solid sound, and how long it took.

The wall is measured by brute force: in the meridian half-plane against points of the outer meridian 20 micrometres
apart, and in space against the outside's triangles. Molds of others are read where they lie beside the project.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from glassworkbench.errors import GlassWorkbenchError, InputError  # noqa: E402
from glassworkbench.freecad import Part  # noqa: E402
from glassworkbench.mold import Mold, read_mold, tessellate  # noqa: E402
from glassworkbench.scene import Mesh  # noqa: E402
from glassworkbench.wall import parse_thickness  # noqa: E402
from glassworkbench.wall.asking.asked import AskedThickness  # noqa: E402
from glassworkbench.wall.asking.bore import Bore  # noqa: E402
from glassworkbench.wall.measuring.outside import Outside, outside  # noqa: E402
from glassworkbench.wall.methods.revolved import revolved  # noqa: E402
from glassworkbench.wall.turning.along_meridian import AlongMeridian  # noqa: E402
from glassworkbench.wall.turning.bezier import crossings, evaluate, polyline  # noqa: E402
from glassworkbench.wall.turning.profile import WallMeridian, below_bore, wall_meridian  # noqa: E402
from glassworkbench.wall.turning.unfolding import clearance  # noqa: E402

EXAMPLES, OTHERS = ROOT / "examples" / "molds", ROOT.parent.parent / "shared" / "molds"
MOLDS = (
    (EXAMPLES / "wine_bottle.step", {}),
    (EXAMPLES / "beer_bottle.step", {}),
    (EXAMPLES / "jar.step", {}),
    (EXAMPLES / "wine_glass.step", {}),
    (OTHERS / "myfreecad_vase.step", {"outer_shell": True}),
    (OTHERS / "besumit_day02_beverage_bottle.step", {"outer_shell": True}),
    (OTHERS / "pp_mould_cup.step", {"block": True}),
    (OTHERS / "pp_mould_bowl.step", {"block": True}),
)
WALLS_MM, WIDTH_SHARES = (1.0, 2.0, 3.0), (0.02, 0.04, 0.08)
REGIONS = "finish=2.5 neck=3 shoulder=2.2 body=2 heel=4 base=5"
BORE_WALLS = 1.5
"""A bore leaves this many times the wall at the lower end of the finish."""

SPACING_MM, SAMPLES = 0.02, 4000
P99_SHARE, P99_MM, THINNER_SHARE, VOLUME_SHARE = 0.02, 0.02, 0.05, 0.005
SECONDS = 5.0


def specifications(mold: Mold) -> list[tuple[str, bool]]:
    """Return walls as text, and whether a bore is prescribed with them."""
    anatomy = mold.anatomy
    top = anatomy.finish_height_mm
    uniform = [*WALLS_MM, *(share * anatomy.smallest_width_mm for share in WIDTH_SHARES)]
    tables = [f"0:{base:g} {0.5 * top:.6g}:3 {top:.6g}:{finish:g}" for base, finish in ((5, 2), (2, 5))]
    return [
        *((f"{wall:.4g}", False) for wall in uniform),
        *((text, False) for text in (*tables, REGIONS)),
        ("2.5", True),
    ]


def asked_of(mold: Mold, text: str, bored: bool) -> AskedThickness:
    """Return the thickness asked on a mold."""
    anatomy = mold.anatomy
    over_height = parse_thickness(text).over_height(anatomy)
    bore = None
    if bored:
        low, high = anatomy.regions["finish"]
        outline = polyline(mold.core, 200)
        radius = outline[outline[:, 1] < low][-1, 0]
        below = max(region for region in anatomy.regions.values() if region[1] <= low)
        bore = Bore(float(radius) - BORE_WALLS * float(over_height.at(low)), low, max(low - (high - low), below[0]))
    along = AlongMeridian(over_height, bore)

    def at(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
        radius = np.hypot(points[:, 0], points[:, 1])
        underside = (radius < anatomy.bearing_radius_mm) & (points[:, 2] <= anatomy.push_up_mm)
        return along.at(np.column_stack([radius, points[:, 2]]), underside)

    return AskedThickness(at, over_height.minimum_mm, over_height.maximum_mm, over_height, bore)


def deviations(inside: np.ndarray, wall: WallMeridian, asked: AskedThickness) -> np.ndarray:
    """Return how much thicker (mm) than asked the wall is at points (n, 2) of the inner meridian."""
    along = AlongMeridian(asked.over_height, asked.bore)
    if asked.bore is not None:
        wall = below_bore(wall, asked.bore)
    feet, thickness = [], []
    for segment, underside in zip(wall.segments, wall.underside, strict=True):
        length = np.linalg.norm(np.diff(polyline(segment[None], 32), axis=0), axis=1).sum()
        points = evaluate(segment, np.linspace(0.0, 1.0, int(length / SPACING_MM) + 2))[0]
        feet.append(points)
        thickness.append(along.at(points, underside))
    measured = inside[inside[:, 1] < wall.lip[1]]
    return clearance(measured, np.concatenate(feet), np.concatenate(thickness))


def spread(chain: np.ndarray, up_to_mm: float) -> np.ndarray:
    """Return points (n, 2) of a meridian below a height, evenly by the area that they turn through."""
    points = polyline(chain, 1000)
    area = np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1) * 0.5 * (points[:-1, 0] + points[1:, 0]))
    points = points[1:][np.searchsorted(area, (np.arange(SAMPLES) + 0.5) / SAMPLES * area[-1])]
    return points[points[:, 1] < up_to_mm]


def thinner(inside: np.ndarray, outer: Outside) -> float:
    """Return by which share of what is asked the wall is thinner anywhere, points (n, 2) turned by the golden angle."""
    angle = np.arange(len(inside)) * np.pi * (3.0 - np.sqrt(5.0))
    points = np.column_stack([inside[:, 0] * np.cos(angle), inside[:, 0] * np.sin(angle), inside[:, 1]])
    decisive = outer.clearance(points)
    return float(np.max(-decisive.clearance_mm / (decisive.distance_mm - decisive.clearance_mm)))


def sound(solid: Part.Shape) -> bool:
    """Tell whether OCC's check of a solid and its parts finds nothing; some files' molds do not pass it themselves."""
    try:
        solid.check(True)
    except ValueError:
        return False
    return True


def volume_mm3(mesh: Mesh) -> float:
    """Return the volume of a closed mesh."""
    a, b, c = (mesh.vertices_mm[mesh.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def run(mold: Mold, text: str, bored: bool) -> tuple[str, float]:
    """Return the line of one case, with what is wrong at its end, and the seconds the method took."""
    asked = asked_of(mold, text, bored)
    outer = outside(mold, asked.at)
    start = time.perf_counter()
    try:
        made = revolved(mold, asked, outer, 120.0)
    except InputError as error:
        return f"{'':>39} cannot be: {error}", time.perf_counter() - start
    except GlassWorkbenchError as error:
        return f"{'':>39} WRONG: {error}", time.perf_counter() - start
    seconds = time.perf_counter() - start

    inside = spread(made.cavity.meridian, mold.anatomy.finish_height_mm)
    deviation = np.abs(deviations(inside, wall_meridian(mold.core, mold.anatomy, asked.over_height), asked))
    p99, thin = float(np.percentile(deviation, 99)), thinner(inside, outer)
    body, cavity, glass = (
        volume_mm3(mesh) for mesh in (tessellate(mold.upright, 0.05), made.inside, tessellate(made.solid, 0.05))
    )
    missing = abs(glass - (body - cavity)) / body
    faults = []
    if p99 > max(P99_SHARE * asked.minimum_mm, P99_MM):
        faults.append("deviates")
    if thin > THINNER_SHARE:
        faults.append("too thin")
    if len(crossings(polyline(made.cavity.meridian, 50))):
        faults.append("crosses itself")
    if not (made.solid.isValid() and len(made.solid.Solids) == 1 and all(s.isClosed() for s in made.solid.Shells)):
        faults.append("not one valid closed solid")
    if sound(mold.upright) and not sound(made.solid):
        faults.append("fails OCC's check of its parts")
    if missing > VOLUME_SHARE:
        faults.append("volume")
    verdict = "WRONG: " + ", ".join(faults) if faults else "right"
    return f"{p99:>8.4f} {deviation.max():>8.4f} {100.0 * thin:>9.2f} {100.0 * missing:>9.3f} {verdict}", seconds


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("molds", nargs="*", help="only molds whose name begins so")
    names = parser.parse_args().molds
    print(f"{'mold':<16} {'wall (mm)':<24} {'s':>5} {'p99 mm':>8} {'max mm':>8} {'thinner %':>9} {'volume %':>9}")
    times, wrong = [], 0
    for path, how in MOLDS:
        if not path.exists() or (names and not path.name.startswith(tuple(names))):
            continue
        mold = read_mold(path, **how)
        if not mold.is_nearly_round:
            print(f"{path.stem:<16.16} is not round: {mold.anatomy.departure_mm:.3g} mm", flush=True)
            continue
        for text, bored in specifications(mold):
            line, seconds = run(mold, text, bored)
            times.append(seconds)
            wrong += "WRONG" in line
            print(f"{path.stem:<16.16} {text + ' bore' * bored:<24.24} {seconds:>5.2f} {line}", flush=True)
    median = float(np.median(times))
    print(f"{len(times)} walls, {wrong} wrong; {median:.2f} s each in the median, {max(times):.2f} s at most")
    return 1 if wrong or median > SECONDS else 0


if __name__ == "__main__":
    sys.exit(main())
