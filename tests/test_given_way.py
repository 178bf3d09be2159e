"""What a wall asks of a place and does not get there, as something else goes before it, is told."""

import pytest

from glassworkbench.mold import read_mold
from glassworkbench.wall.asking.given_way import notes_on_what_gives_way
from glassworkbench.wall.asking.thickness_text import parse_thickness


@pytest.fixture(scope="module")
def bottle():
    return read_mold("examples/molds/wine_bottle.step")


def told(bottle, text):
    thickness = parse_thickness(text)
    return notes_on_what_gives_way(thickness, thickness.on(bottle), bottle)


def test_faces_that_blend_into_a_neighbour_are_named_with_the_reach(bottle):
    (note,) = told(bottle, "Face12=4 else=2")
    assert note.startswith("Face12=4 runs smoothly into a face that asks for another wall: within 6 mm")


def test_a_finish_that_a_bore_replaces_is_told(bottle):
    assert told(bottle, "finish=2.5 body=3 bore=18.5") == (
        "finish=2.5 gives way to bore=18.5: in the finish the inside is the bore, whatever wall that leaves",
    )


@pytest.mark.parametrize("text", ["3", "3 bore=18.5", "finish=2.5 body=3", "body=3 heel=4 bore=18.5"])
def test_nothing_is_told_where_all_is_made_as_asked(bottle, text):
    assert told(bottle, text) == ()
