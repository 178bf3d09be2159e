"""The objects of a FreeCAD document: a container that follows its mold, and a picture of it.

The module paths of the proxies are written into every saved file, so they stay where they are.
"""

from glassworkbench.document.container import make_container
from glassworkbench.document.render import make_render, render_image

__all__ = ["make_container", "make_render", "render_image"]
