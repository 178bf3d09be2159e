"""The scene: bodies, media, camera and lights as plain arrays and frozen dataclasses.

No FreeCAD, no Qt: a scene can be pickled, sent to another machine and traced there.
Units are millimetres and radians unless a name says otherwise.
"""

from glassworkbench.scene.bodies import Body, ContainerGeometry, Ellipsoid, Revolved, Surface
from glassworkbench.scene.cameras import Camera, Pinhole, Telecentric
from glassworkbench.scene.ellipsoids import Ellipsoids
from glassworkbench.scene.lights import Environment, Light, Panel
from glassworkbench.scene.media import Medium, medium_table
from glassworkbench.scene.mesh import Mesh
from glassworkbench.scene.patches import Patches, Sheet
from glassworkbench.scene.scene import Scene
from glassworkbench.scene.symmetry import is_mirror_symmetric

__all__ = [
    "Body",
    "Camera",
    "ContainerGeometry",
    "Ellipsoid",
    "Ellipsoids",
    "Environment",
    "Light",
    "Medium",
    "Mesh",
    "Panel",
    "Patches",
    "Pinhole",
    "Revolved",
    "Scene",
    "Sheet",
    "Surface",
    "Telecentric",
    "is_mirror_symmetric",
    "medium_table",
]
