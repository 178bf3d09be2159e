"""Writes the example molds: the outer shapes of six glass containers, as STEP files in the folder beside this script.

Run it with FreeCAD's Python. Lengths are mm, z is up, the base rests on z = 0 and the axis is z.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from glassworkbench.freecad import FreeCAD, Part

MOLDS = Path(__file__).resolve().parent / "molds"
Z_AXIS = FreeCAD.Vector(0, 0, 1)


def point(r: float, z: float) -> FreeCAD.Vector:
    """Return the point of the meridian half-plane y = 0 at radius r and height z."""
    return FreeCAD.Vector(r, 0, z)


def rounded(corners: Sequence[tuple[float, ...]]) -> list[Part.Edge]:
    """Return lines through the corners (r, z), or (r, z, radius) where an arc of that radius rounds the corner."""
    edges = []
    start = point(*corners[0][:2])
    for before, here, after in zip(corners, corners[1:], corners[2:], strict=False):
        corner = point(*here[:2])
        radius = here[2] if len(here) == 3 else 0.0
        back = (point(*before[:2]) - corner).normalize()
        onward = (point(*after[:2]) - corner).normalize()
        half_angle = 0.5 * back.getAngle(onward)
        if radius == 0.0:
            edges.append(Part.makeLine(start, corner))
            start = corner
            continue
        reach = radius / math.tan(half_angle)
        bisector = (back + onward).normalize()
        middle = corner + bisector * (radius / math.sin(half_angle) - radius)
        end = corner + onward * reach
        entry = corner + back * reach
        if start.distanceToPoint(entry) > 1e-9:
            edges.append(Part.makeLine(start, entry))
        edges.append(Part.Arc(entry, middle, end).toShape())
        start = end
    last = point(*corners[-1][:2])
    if start.distanceToPoint(last) > 1e-9:
        edges.append(Part.makeLine(start, last))
    return edges


def spline(poles: Sequence[tuple[float, float]]) -> Part.Edge:
    """Return a cubic B-spline with uniform knots; three collinear poles at an end make it leave without curvature."""
    curve = Part.BSplineCurve()
    spans = len(poles) - 3
    curve.buildFromPolesMultsKnots(
        [point(*pole) for pole in poles], [4] + [1] * (spans - 1) + [4], list(range(spans + 1)), False, 3
    )
    return curve.toShape()


def revolved(edges: Sequence[Part.Edge]) -> Part.Shape:
    """Return the solid that the edges, from the axis up the outside back to the axis, sweep about z."""
    shell = Part.Wire(edges).revolve(FreeCAD.Vector(), Z_AXIS, 360)
    solid = Part.makeSolid(Part.makeShell(shell.Faces))
    if solid.Volume < 0:
        solid.reverse()
    return solid


def wine_bottle() -> Part.Shape:
    """Bordeaux, 75 cl: height 300, diameter 76, push-up 22, flat-topped ring finish of 29.5."""
    push_up_and_body = rounded([(0, 22), (9, 22, 12), (28, 1.5, 10), (31.2, 0, 1.5), (38, 0, 6), (38, 186)])
    shoulder = spline([(38, 186), (38, 193), (38, 200), (37, 216), (17, 218), (14.3, 229), (14.2, 237), (14.1, 245)])
    finish = rounded([(14.1, 245), (13.7, 277), (13.7, 282.6, 0.8), (14.75, 283.6, 0.9), (14.75, 300, 1.6), (0, 300)])
    return revolved([*push_up_and_body, shoulder, *finish])


EXAMPLES: dict[str, Callable[[], Part.Shape]] = {
    "wine_bottle": wine_bottle,
}


def main() -> None:
    """Write every example, each aside first, so that no half-written file is left."""
    MOLDS.mkdir(exist_ok=True)
    for name, make in EXAMPLES.items():
        aside = MOLDS / f".{name}.step"
        make().exportStep(str(aside))
        aside.rename(MOLDS / f"{name}.step")
        print(MOLDS / f"{name}.step")


if __name__ == "__main__":
    main()
