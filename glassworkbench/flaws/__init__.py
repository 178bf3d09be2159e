"""Flaws: what manufacturing does to glass, by the industry's names, each with its own geometry or refractive index."""

from glassworkbench.flaws.asked import DrawnDefects, ListedDefects, parse_defects
from glassworkbench.flaws.bubbles import Blister, Seed
from glassworkbench.flaws.cords import Cord
from glassworkbench.flaws.defect import CLASSES, Defect
from glassworkbench.flaws.defect_file import make_defect, read_defects
from glassworkbench.flaws.films import Check, Split
from glassworkbench.flaws.flawed_scene import with_defects
from glassworkbench.flaws.kinds import KINDS, kinds
from glassworkbench.flaws.population import day, find_population, populations, sample
from glassworkbench.flaws.shapes import Lean, Ovality
from glassworkbench.flaws.stones import Stone
from glassworkbench.flaws.threads import BirdSwing, Spike
from glassworkbench.flaws.walls import ChokedNeck, Slug, ThinSpot, Washboard

__all__ = [
    "CLASSES",
    "KINDS",
    "BirdSwing",
    "Blister",
    "Check",
    "ChokedNeck",
    "Cord",
    "Defect",
    "DrawnDefects",
    "Lean",
    "ListedDefects",
    "Ovality",
    "Seed",
    "Slug",
    "Spike",
    "Split",
    "Stone",
    "ThinSpot",
    "Washboard",
    "day",
    "find_population",
    "kinds",
    "make_defect",
    "parse_defects",
    "populations",
    "read_defects",
    "sample",
    "with_defects",
]
