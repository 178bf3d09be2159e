"""Writes the example molds: the outer shapes of six glass containers, as STEP files in the folder beside this script.

Run it with FreeCAD's Python. Lengths are mm, z is up, the base rests on z = 0 and the axis is z.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np

from glassworkbench.freecad import FreeCAD, Part

MOLDS = Path(__file__).resolve().parent / "molds"
ORIGIN = FreeCAD.Vector()
Z_AXIS = FreeCAD.Vector(0, 0, 1)

ANGLES = 96
"""Spans around a skin: enough for a cubic to follow the neck's circle within 1e-6 mm."""


def point(r: float, z: float) -> FreeCAD.Vector:
    """Return the point of the meridian half-plane y = 0 at radius r and height z."""
    return FreeCAD.Vector(r, 0, z)


def rounded(corners: Sequence[tuple[float, ...]]) -> list[Part.Edge]:
    """Return lines through the corners (r, z), or (r, z, radius) where an arc of that radius rounds the corner."""
    edges = []
    start = point(*corners[0][:2])
    for before, here, after in zip(corners, corners[1:], corners[2:], strict=False):
        corner = point(*here[:2])
        entry = end = corner
        if len(here) == 3:
            back = (point(*before[:2]) - corner).normalize()
            onward = (point(*after[:2]) - corner).normalize()
            half_angle = 0.5 * back.getAngle(onward)
            entry = corner + back * (here[2] / math.tan(half_angle))
            end = corner + onward * (here[2] / math.tan(half_angle))
            middle = corner + (back + onward).normalize() * (here[2] / math.sin(half_angle) - here[2])
        if start.distanceToPoint(entry) > 1e-9:
            edges.append(Part.makeLine(start, entry))
        if len(here) == 3:
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
    return solid(turned(edges))


def turned(edges: Sequence[Part.Edge]) -> list[Part.Face]:
    """Return the faces that the edges sweep about z."""
    return Part.Wire(edges).revolve(ORIGIN, Z_AXIS, 360).Faces


def solid(faces: Sequence[Part.Face]) -> Part.Shape:
    """Return the solid that the faces, which meet at their edges, enclose."""
    shell = Part.makeShell(faces)
    shell.sewShape()
    enclosed = Part.makeSolid(shell)
    if enclosed.Volume < 0:
        enclosed.reverse()
    return enclosed


Section = tuple[float, float, float, float]
"""Half width, half depth, exponent p and height of the superellipse |x/a|^p + |y/b|^p = 1; p = 2 is an ellipse."""


def skin(sections: Sequence[Section]) -> Part.Face:
    """Return one smooth periodic B-spline face with the sections as its control polygon over the height.

    It is tangent to the first and last step between sections, and twice continuously differentiable everywhere,
    which is what OCC asks of a surface that it is to offset.
    """
    angles = 2.0 * np.pi * np.arange(ANGLES) / ANGLES
    # A uniform cubic passes its poles' circular convolution with (1 4 1)/6; undone, it passes the given points.
    kernel = (4.0 + 2.0 * np.cos(2.0 * np.pi * np.fft.fftfreq(ANGLES))) / 6.0
    poles = []
    for half_width, half_depth, exponent, height in sections:
        cosine, sine = np.cos(angles), np.sin(angles)
        radius = (np.abs(cosine / half_width) ** exponent + np.abs(sine / half_depth) ** exponent) ** (-1.0 / exponent)
        x, y = (np.fft.ifft(np.fft.fft(values) / kernel).real for values in (radius * cosine, radius * sine))
        poles.append([FreeCAD.Vector(*pole, height) for pole in zip(x.tolist(), y.tolist(), strict=True)])
    spans = len(sections) - 3
    surface = Part.BSplineSurface()
    surface.buildFromPolesMultsKnots(
        [list(around) for around in zip(*poles, strict=True)],
        [1] * (ANGLES + 1),
        [4, *[1] * (spans - 1), 4],
        list(range(ANGLES + 1)),
        list(range(spans + 1)),
        True,
        False,
        3,
        3,
    )
    return surface.toShape()


def cap(face: Part.Face, height: float) -> Part.Face:
    """Return the planar face that closes the skin at one of its ends."""
    ends = [edge for edge in face.Edges if edge.isClosed() and edge.BoundBox.ZLength < 1e-3]
    edge = min(ends, key=lambda end: abs(end.CenterOfMass.z - height))
    return Part.Face(Part.Wire([edge]))


def wine_bottle() -> Part.Shape:
    """Bordeaux, 75 cl: height 300, diameter 76, push-up 22, flat-topped ring finish of 29.5."""
    base_and_body = rounded([(0, 22), (13, 22, 15), (27.5, 1.2, 8), (31.5, 0, 2), (38, 0, 6), (38, 178)])
    shoulder = spline(
        [
            (38, 178),
            (38, 188),
            (38, 198),
            (37, 210),
            (28.5, 217),
            (19.5, 222),
            (15.2, 229),
            (14.726, 238),
            (14.463, 248),
            (14.2, 258),
        ]
    )
    finish = rounded([(14.2, 258), (13.7, 277), (13.7, 282.6, 0.8), (14.75, 283.8, 0.9), (14.75, 300, 1.6), (0, 300)])
    return revolved([*base_and_body, shoulder, *finish])


def beer_bottle() -> Part.Shape:
    """Long neck, 33 cl: height 230, diameter 61, crown finish of 26.6 over a carrying ring."""
    base_and_body = rounded([(0, 5), (10, 5, 30), (23.5, 0, 3), (30.5, 0, 5.5), (30.5, 104)])
    shoulder = spline(
        [
            (30.5, 104),
            (30.5, 114),
            (30.5, 124),
            (29.5, 137),
            (23, 149),
            (17, 160),
            (15, 172),
            (14.4, 182),
            (13.9, 193),
            (13.4, 204),
        ]
    )
    finish = rounded(
        [
            (13.4, 204),
            (13.1, 210.6),
            (13, 212.8, 1.2),
            (14.3, 214, 1.1),
            (14.3, 218, 1.6),
            (12.4, 220.2, 1.4),
            (12.4, 223.2, 1.4),
            (13.3, 224.8, 1.2),
            (13.3, 230, 2.4),
            (0, 230),
        ]
    )
    return revolved([*base_and_body, shoulder, *finish])


def whisky_flask() -> Part.Shape:
    """Square, 70 cl: 72 x 72, height 240, edges rounded, the shoulder running smoothly into a round neck."""
    square = [(23, 0, 8), (29, 0, 6), (35, 0, 6), (36, 5, 6), (36, 12, 6), (36, 60, 6), (36, 120, 6), (36, 150, 6)]
    square += [(36, 164, 5), (33.5, 177, 3.5), (22.5, 183, 2.4), (16.3, 190, 2)]
    sections = [(w, w, p, z) for w, z, p in square]
    sections += [(15, 15, 2, z) for z in (197, 203, 209)]
    outside = skin(sections)
    finish = rounded([(15, 209), (15, 216, 6), (17, 221, 6), (17, 240), (0, 240)])
    return solid([cap(outside, 0), outside, *turned(finish)])


def perfume_flacon() -> Part.Shape:
    """Oval, 10 cl: 66 x 37, height 108, with the plain round neck that a spray pump is crimped on."""
    body = [(20, 9, 0), (24.5, 12, 0), (30.5, 16, 0), (33, 18.5, 4), (33, 18.5, 12), (33, 18.5, 34), (33, 18.5, 56)]
    sections = [(a, b, 2.3, z) for a, b, z in body]
    sections += [(31, 17.7, 2.2, 72), (23.5, 14.5, 2.1, 82), (12, 10.5, 2, 86), (8.6, 8.6, 2, 88)]
    sections += [(8.5, 8.5, 2, z) for z in (91, 93.5, 96)]
    outside = skin(sections)
    finish = rounded([(8.5, 96), (8.5, 108), (0, 108)])
    return solid([cap(outside, 0), outside, *turned(finish)])


def jar() -> Part.Shape:
    """Wide mouth, 37 cl: height 112, diameter 76, a twist-off finish of 62 with four thread segments."""
    body = revolved(
        rounded(
            [
                (0, 4),
                (16, 4, 40),
                (28, 0, 4),
                (38, 0, 6),
                (38, 88, 9),
                (33.5, 94, 4),
                (33.5, 96.4, 0.9),
                (31, 97.8, 1.2),
                (31, 112, 1.4),
                (0, 112),
            ]
        )
    )
    return body.multiFuse([thread_segment(31.0, 105.5, turn) for turn in (20, 110, 200, 290)]).Solids[0]


def thread_segment(radius: float, height: float, turn_degrees: float) -> Part.Shape:
    """Return a ridge over an eighth of a turn that stands 1.5 out of a cylinder.

    It is a piece of a torus, so that it meets the cylinder in exact circles and lines, which STEP keeps exact.
    """
    section = Part.Face(Part.Wire([Part.makeCircle(1.9, point(radius - 0.4, height), FreeCAD.Vector(0, 1, 0))]))
    ridge = section.revolve(ORIGIN, Z_AXIS, 45)
    ridge.rotate(ORIGIN, Z_AXIS, turn_degrees)
    return ridge


def wine_glass() -> Part.Shape:
    """Tulip glass: height 215, a foot of 74, a stem of 8, a bowl of 82 that closes to a mouth of 64."""
    foot = rounded([(0, 2.5), (16, 2.5, 60), (31, 0, 12), (37, 0, 0.9), (37, 1.9, 0.9), (33, 2.2)])
    stem = spline([(33, 2.2), (27, 2.65), (18, 3.3), (7, 5.2), (4.2, 12), (4, 24), (4, 40)])
    bowl = spline(
        [
            (4, 40),
            (4, 56),
            (4, 74),
            (5, 88),
            (10, 94),
            (24, 97),
            (38, 110),
            (43, 136),
            (40.5, 168),
            (35.5, 194),
            (32, 215),
        ]
    )
    return revolved([*foot, stem, bowl, *rounded([(32, 215), (0, 215)])])


EXAMPLES: dict[str, Callable[[], Part.Shape]] = {
    "wine_bottle": wine_bottle,
    "beer_bottle": beer_bottle,
    "whisky_flask": whisky_flask,
    "perfume_flacon": perfume_flacon,
    "jar": jar,
    "wine_glass": wine_glass,
}


def main() -> None:
    """Write every example, each aside first, so that no half-written file is left."""
    MOLDS.mkdir(exist_ok=True)
    for name, make in EXAMPLES.items():
        aside = MOLDS / f".{name}.step"
        make().exportStep(str(aside))
        # OCC writes the time of day, which would make every run a change of all files.
        aside.write_text(re.sub(r"'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d'", "'2026-01-01T00:00:00'", aside.read_text()))
        aside.rename(MOLDS / f"{name}.step")
        print(MOLDS / f"{name}.step")


if __name__ == "__main__":
    main()
