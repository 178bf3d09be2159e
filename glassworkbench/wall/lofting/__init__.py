"""Curves in half-planes through the axis and the surface through them, for the method `lofted`."""
