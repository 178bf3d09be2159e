"""What OCC's offset achieves on the examples: right, rejected, failed or hung, and seconds, each run within a limit."""

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from glassworkbench.errors import GlassWorkbenchError  # noqa: E402
from glassworkbench.mold import Mold, read_mold, tessellate  # noqa: E402
from glassworkbench.spatial import NearestTriangles  # noqa: E402
from glassworkbench.wall.measuring.volumes import mesh_volume  # noqa: E402
from glassworkbench.wall.methods.thick_solid import ThickWall, thick_wall  # noqa: E402

WALLS_MM = (1.0, 2.0, 3.0)
WALL_SHARES = (0.04, 0.08)
"""Of the smallest width."""

WALL_SHARE, RIGHT_SHARE, VOLUME_SHARE = 0.05, 0.95, 0.02
"""Right is: the wall within 5 % on 95 % of the inside, and the solid's volume within 2 % of outside minus inside."""

SAMPLES = 2000
DEVIATION_MM = 0.03


def fault(mold: Mold, made: ThickWall, wall_mm: float) -> str:
    """Return what is wrong with a result, nothing if it is right."""
    solid = made.solid
    if not (solid.isValid() and len(solid.Solids) == 1 and all(shell.isClosed() for shell in solid.Shells)):
        return "not one valid closed solid"
    try:
        outer, cavity, whole = (tessellate(shape, DEVIATION_MM) for shape in (mold.upright, made.cavity, solid))
    except GlassWorkbenchError as error:
        return str(error)
    outside, inside, glass = (mesh_volume(mesh).volume_mm3 for mesh in (outer, cavity, whole))
    if abs(glass - (outside - inside)) > VOLUME_SHARE * glass:
        return f"the solid holds {glass:.0f} mm3 of glass, but outside minus inside is {outside - inside:.0f}"
    random = np.random.default_rng(1)
    corners = cavity.vertices_mm[cavity.triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    chosen = corners[random.choice(len(corners), SAMPLES, p=areas / areas.sum())]
    points = np.einsum("ij,ijk->ik", random.dirichlet([1.0, 1.0, 1.0], SAMPLES), chosen)
    finish = mold.anatomy.finish_height_mm
    points = points[points[:, 2] < finish - wall_mm]
    walls = outer.vertices_mm[outer.triangles]
    walls = walls[~np.all(walls[:, :, 2] > finish - 1e-4, axis=1)]
    distance = NearestTriangles(walls, np.zeros_like(walls)).search(points).distance_mm
    right = np.mean(np.abs(distance - wall_mm) < WALL_SHARE * wall_mm)
    return "" if right >= RIGHT_SHARE else f"only {100.0 * right:.0f} % of the wall is right"


def run(mold: Mold, wall_mm: float, seconds: float) -> tuple[str, str, float]:
    """Return the outcome, why, and the seconds taken."""
    start = time.monotonic()
    finish = mold.anatomy.finish_height_mm
    # A stem stays full.
    low = mold.anatomy.stem_top_mm
    try:
        made = thick_wall(mold.upright, mold.anatomy.finish_face, [(low, finish, wall_mm)], seconds=seconds)
    except GlassWorkbenchError as error:
        outcome = "hung" if "no time is left" in str(error) else "failed"
        return outcome, str(error), time.monotonic() - start
    taken = time.monotonic() - start
    why = fault(mold, made, wall_mm)
    return ("rejected", why, taken) if why else ("right", made.tries[-1], taken)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--molds", default="", help="only files whose name contains this")
    parser.add_argument("--seconds", type=float, default=20.0, help="limit of one run")
    asked = parser.parse_args()
    paths = sorted((ROOT / "examples" / "molds").glob("*.step"))
    paths += sorted((ROOT.parent / "shared" / "molds").glob("*bottle*.*"))
    paths += sorted((ROOT.parent / "shared" / "molds").glob("*vase.step"))
    print(f"{'mold':<30} {'wall':>6} {'outcome':<9} {'seconds':>7}  why")
    count: Counter[str] = Counter()
    for path in (path for path in paths if asked.molds in path.name):
        try:
            mold = read_mold(path, outer_shell=path.parents[1].name == "shared")
        except GlassWorkbenchError as error:
            print(f"{path.stem:<30} {'':>6} {'unread':<9} {'':>7}  {error}")
            continue
        for wall in (*WALLS_MM, *(share * mold.anatomy.smallest_width_mm for share in WALL_SHARES)):
            outcome, why, seconds = run(mold, wall, asked.seconds)
            count[outcome] += 1
            print(f"{path.stem:<30} {wall:>6.2f} {outcome:<9} {seconds:>7.1f}  {why}", flush=True)
    print(", ".join(f"{number} {outcome}" for outcome, number in count.most_common()))


if __name__ == "__main__":
    main()
