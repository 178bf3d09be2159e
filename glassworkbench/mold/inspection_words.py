"""What `inspect` found, in plain words: two columns, names and values with their units."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Mapping

WIDTH, LABEL_WIDTH = 110, 20

TIED = "\N{NO-BREAK SPACE}"
"""Between words that stay in one line."""

SHAPE_ENTITY = re.compile(
    r"(?!.*(STYLE|REPRESENTATION|PCURVE|DRAUGHTING))"
    r".*(SURFACE|PLANE$|CURVE|^LINE$|CIRCLE|ELLIPSE|PARABOLA|HYPERBOLA|POLYLINE|BREP|SHELL|FACE$)"
)
"""Which of a STEP file's entities are told; JSON has all."""

SURFACES = {
    "Plane": ("plane", "planes"),
    "Cylinder": ("cylinder", "cylinders"),
    "Cone": ("cone", "cones"),
    "Sphere": ("sphere", "spheres"),
    "Toroid": ("torus", "tori"),
    "BSplineSurface": ("B-spline surface", "B-spline surfaces"),
    "BezierSurface": ("Bezier surface", "Bezier surfaces"),
    "SurfaceOfRevolution": ("surface of revolution", "surfaces of revolution"),
    "SurfaceOfExtrusion": ("extruded surface", "extruded surfaces"),
    "OffsetSurface": ("offset surface", "offset surfaces"),
    "RectangularTrimmedSurface": ("trimmed surface", "trimmed surfaces"),
    "PlateSurface": ("plate surface", "plate surfaces"),
    "Triangle": ("triangle", "triangles"),
}
"""What FreeCAD's kinds of surface are called, one and several."""

LENGTHS = {
    "height_mm": "height",
    "finish_height_mm": "finish height",
    "finish_outer_radius_mm": "finish outer radius",
    "push_up_mm": "push-up",
}


def in_words(found: Mapping) -> Iterator[str]:
    """Yield the lines that tell what `inspect` found; what is not known has none."""
    for name, texts in _told(found):
        label = name
        for text in texts:
            indents = {"initial_indent": f"{label:{LABEL_WIDTH}} ", "subsequent_indent": (LABEL_WIDTH + 1) * " "}
            yield textwrap.fill(text, WIDTH, **indents)
            label = ""


def _told(found: Mapping) -> Iterator[tuple[str, list[str]]]:
    yield "file", [found["path"]]
    yield "SHA-256", [found["sha256"]]
    yield "unit", [found["unit"] or "taken as millimetre: this kind of file names none"]
    entities = [f"{count} {_entity(kind)}" for kind, count in found["entities"].items() if SHAPE_ENTITY.match(kind)]
    if entities:
        yield "STEP entities", [_listed(entities)]
    yield "faces", [_listed(_surfaces(count, kind) for kind, count in found["faces"].items())]
    if found["solids"]:
        yield "solids", [str(found["solids"])]
    elif set(found["faces"]) != {"Triangle"}:
        yield "solids", ["none, only faces"]
    if found["mesh_volume_mm3"] is not None:
        yield "volume", [f"{number(found['mesh_volume_mm3'])} mm3"]
    if found["hollow"] is not None:
        yield "hollow", ["yes" if found["hollow"] else "no"]
    if found["axis"] is None:
        yield "container", ["not found; the faults tell why"]
    else:
        yield from _container(found)
    yield "faults", [f"- {sentence}" for sentence in found["faults"]] or ["none"]
    if found["notes"]:
        yield "notes", [f"- {sentence}" for sentence in found["notes"]]


def _container(found: Mapping) -> Iterator[tuple[str, list[str]]]:
    yield "axis", [f"{', '.join(map(number, found['axis']))}, from base to finish"]
    yield "base point", [f"{', '.join(map(number, found['base_point_mm']))} mm"]
    for key, name in LENGTHS.items():
        if found[key] is not None:
            yield name, [f"{number(found[key])} mm"]
    if found["finish_face"] is not None:
        yield "mouth", [f"face {found['finish_face']}"]
    if found["revolved"] is not None:
        yield "round", [_roundness(found)]
    if found["regions"] is not None:
        ends = {region: (number(low, 4), number(high, 4)) for region, (low, high) in found["regions"].items()}
        yield "regions", [f"{region} from {low} to {high} mm" for region, (low, high) in reversed(ends.items())]


def _roundness(found: Mapping) -> str:
    if found["revolved"]:
        return "yes, a body of revolution"
    place = found["departure_at"]
    departs = (
        f"departs from a body of revolution by up to {number(found['departure_mm'], 3)} mm, the most at height "
        f"{number(place['height_mm'], 4)} mm, {number(place['angle_deg'], 3)} degrees about the axis from x"
    )
    return f"nearly: it {departs}, and its inside can be round" if found["nearly_round"] else f"no: it {departs}"


def _entity(kind: str) -> str:
    return kind.lower().replace("b_spline", "B-spline").replace("brep", "B-rep").replace("_", " ")


def _surfaces(count: int, kind: str) -> str:
    # A kind that no file is known to hold is told by FreeCAD's name.
    one, several = SURFACES.get(kind, (kind, kind))
    return f"{count} {one if count == 1 else several}"


def _listed(items: object) -> str:
    return ", ".join(item.replace(" ", TIED) for item in items)


def number(value: float, digits: int = 6) -> str:
    """Return a number with so many digits, whole where it is large."""
    # Adding 0 makes zero of a minus zero, which rounding leaves of -1e-16.
    return f"{value:.0f}" if abs(value) >= 1e5 else f"{round(value, 9) + 0.0:.{digits}g}"
