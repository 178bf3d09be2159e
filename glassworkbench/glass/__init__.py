"""What the material does to light: glasses, and the liquids that fill them."""

from glassworkbench.glass.catalogue import catalogue, fillings, find_filling, find_glass
from glassworkbench.glass.material import Filling, Glass

__all__ = ["Filling", "Glass", "catalogue", "fillings", "find_filling", "find_glass"]
