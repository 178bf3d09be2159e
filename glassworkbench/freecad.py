"""Makes FreeCAD importable in whichever Python runs, and hands out the modules that the rooms of the house use.

Inside FreeCAD (its window, freecadcmd) the modules are simply there. In FreeCAD's own Python started by itself they
lie in folders that are not on the path; those of the usual installations are tried, and the environment variable
FREECAD_PATH may name more (separated like PATH). A Python of another version cannot load them.
"""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path
from types import ModuleType

from glassworkbench.errors import GlassWorkbenchError

LIBRARY_FOLDERS = (
    "/usr/lib/freecad-python3/lib",
    "/usr/lib/freecad/lib",
    "/usr/lib64/freecad/lib",
    "/usr/local/lib/freecad/lib",
    "/usr/share/freecad/Ext",
)


def _import_freecad() -> ModuleType:
    """Import FreeCAD, with the installation's folders on the path if it is not there already.

    Raises
    ------
    GlassWorkbenchError
        If no FreeCAD fits this Python.
    """
    named = [folder for folder in os.environ.get("FREECAD_PATH", "").split(os.pathsep) if folder]
    for folders in ((), named, LIBRARY_FOLDERS):
        added = [str(folder) for folder in folders if Path(folder).is_dir() and str(folder) not in sys.path]
        sys.path.extend(added)
        try:
            return importlib.import_module("FreeCAD")
        except ImportError:
            for folder in added:
                sys.path.remove(folder)
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    raise GlassWorkbenchError(
        f"FreeCAD: none fits this Python {version} ({sys.executable}); run this with FreeCAD's own Python or "
        "freecadcmd, or name the folder that holds its modules in FREECAD_PATH"
    )


FreeCAD = _import_freecad()
Part = importlib.import_module("Part")

__all__ = ["FreeCAD", "Part"]
