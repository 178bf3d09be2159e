"""What the material does to light: glasses, and the liquids that fill them."""

from glassworkbench.glass.catalogue import catalogue, fillings, find_filling, find_glass, refused
from glassworkbench.glass.facts import facts
from glassworkbench.glass.material import Filling, Glass

__all__ = ["Filling", "Glass", "catalogue", "facts", "fillings", "find_filling", "find_glass", "refused"]
