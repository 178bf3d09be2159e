"""What is asked of a place and yet not made there, as something else that is asked goes before it."""

from __future__ import annotations

from glassworkbench.mold import Mold
from glassworkbench.wall.asking.asked import AskedThickness
from glassworkbench.wall.asking.thickness import BoredThickness, FaceThickness, RegionalThickness, Thickness


def notes_on_what_gives_way(thickness: Thickness, asked: AskedThickness, mold: Mold) -> tuple[str, ...]:
    """Return a sentence for each thickness that a bore replaces, or that blends into those of other faces."""
    if isinstance(thickness, BoredThickness):
        return _gives_way_to_bore(thickness)
    if isinstance(thickness, FaceThickness) and asked.by_face is not None:
        return _blends(thickness, asked, mold)
    return ()


def _gives_way_to_bore(thickness: BoredThickness) -> tuple[str, ...]:
    if not isinstance(thickness.wall, RegionalThickness):
        return ()
    named = dict(thickness.wall.regions)
    if "finish" not in named:
        return ()
    return (
        f"finish={named['finish']:g} gives way to bore={thickness.bore_mm:g}: in the finish the inside is the bore, "
        "whatever wall that leaves",
    )


def _blends(thickness: FaceThickness, asked: AskedThickness, mold: Mold) -> tuple[str, ...]:
    told = []
    for blend in asked.by_face.blends:
        of_file = {mold.file_faces[number - 1] for number in blend.faces}
        named = [f"Face{number}={value:g}" for number, value in thickness.faces if number in of_file]
        if named:
            runs = "runs" if len(named) == 1 else "run"
            told.append(
                f"{' and '.join(named)} {runs} smoothly into a face that asks for another wall: within "
                f"{blend.reach_mm:.2g} mm of that edge the wall goes from one to the other"
            )
    return tuple(told)
