"""GlassWorkbench: from the mold of a glass container to the container, and what light makes of it.

The names a macro needs, loaded when first used: a plain scene is rendered without FreeCAD being imported.
"""

from importlib import import_module

__version__ = "0.1.0"

_HOMES = {
    "GlassWorkbenchError": "glassworkbench.errors",
    "InputError": "glassworkbench.errors",
    "Cancelled": "glassworkbench.errors",
    "read_mold": "glassworkbench.mold",
    "inspect": "glassworkbench.mold",
    "hollow": "glassworkbench.wall",
    "read_container": "glassworkbench.wall",
    "Glass": "glassworkbench.glass",
    "glasses": "glassworkbench.glass:catalogue",
    "fillings": "glassworkbench.glass",
    "find_glass": "glassworkbench.glass",
    "find_filling": "glassworkbench.glass",
    "save_swatches": "glassworkbench.glass.pictures",
    "save_curves": "glassworkbench.glass.pictures",
    "station": "glassworkbench.staging",
    "stations": "glassworkbench.staging",
    "defects": "glassworkbench.flaws:kinds",
    "populations": "glassworkbench.flaws",
    "read_defects": "glassworkbench.flaws",
    "sample_defects": "glassworkbench.flaws:sample",
    "with_defects": "glassworkbench.flaws",
    "unwrapped": "glassworkbench.scanning",
    "read_scene": "glassworkbench.scene.file",
    "render": "glassworkbench.tracer",
    "accuracy": "glassworkbench.pricing",
    "Cancel": "glassworkbench.tracer",
    "Image": "glassworkbench.images",
    "read_image": "glassworkbench.images",
    "radiance": "glassworkbench.tracer.native",
    "follow": "glassworkbench.tracer.native",
    "ray_path": "glassworkbench.tracer",
    "compare": "glassworkbench.judging",
    "golden_of": "glassworkbench.judging",
    "read_golden": "glassworkbench.judging",
    "make_container": "glassworkbench.document",
    "make_render": "glassworkbench.document",
    "render_image": "glassworkbench.document",
}

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, original = _HOMES[name].partition(":")
    return getattr(import_module(module), original or name)


def __dir__() -> list[str]:
    return sorted(__all__)
