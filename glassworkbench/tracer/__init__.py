"""From a scene to an image: the plan, the native core and its numpy reference."""

from glassworkbench.tracer.control import Cancel
from glassworkbench.tracer.path import RayPath, ray_path
from glassworkbench.tracer.plan import Effect, Plan, plan
from glassworkbench.tracer.render import render
from glassworkbench.tracer.result import Crossing, Radiance

__all__ = ["Cancel", "Crossing", "Effect", "Plan", "Radiance", "RayPath", "plan", "ray_path", "render"]
