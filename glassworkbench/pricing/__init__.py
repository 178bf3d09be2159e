"""What accuracy costs: error against seconds of the ways to render a scene, predicted by a pilot or measured."""

from glassworkbench.pricing.price_list import SECONDS, Price, PriceList, accuracy, writable_folder

__all__ = ["SECONDS", "Price", "PriceList", "accuracy", "writable_folder"]
