"""Line cameras: a container turns before one column of pixels, and its side comes out unwrapped."""

from glassworkbench.scanning.unwrapped import unwrapped

__all__ = ["unwrapped"]
