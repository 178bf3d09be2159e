"""Who may import whom: docs/architecture.md as a test."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "glassworkbench"
FILES = sorted(PACKAGE.rglob("*.py"))
ROOMS_WITH_FREECAD = {"mold", "wall", "document", "gui"}
FREECAD = {"FreeCAD", "FreeCADGui", "App", "Gui", "Part", "Mesh", "MeshPart", "Import", "Sketcher", "BOPTools", "pivy"}
QT = {"PySide", "PySide2", "PySide6", "shiboken2", "shiboken6", "PyQt5", "PyQt6"}
COMMON = {"errors", "output", "settings"}
MAY_IMPORT = {
    "errors": set(),
    "output": {"errors"},
    "settings": {"errors"},
    "freecad": {"errors"},
    "spatial": {"errors"},
    "colour": COMMON,
    "glass": COMMON | {"colour", "images"},
    "images": COMMON,
    "scene": COMMON | {"glass", "images"},
    "staging": COMMON | {"glass", "images", "scene"},
    "judging": COMMON | {"images", "scene"},
    "scanning": COMMON | {"glass", "images", "scene", "staging", "tracer"},
    "tracer": COMMON | {"scene", "images"},
    "flaws": COMMON | {"scene", "tracer"},
    "pricing": COMMON | {"scene", "images", "tracer"},
    "mold": COMMON | {"freecad", "scene", "spatial"},
    "wall": COMMON | {"freecad", "scene", "glass", "mold", "spatial", "flaws"},
}


def room(path):
    """The folder of the package that a file is in, or its own name."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(path):
    """Every module that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_the_package_is_found():
    assert {"scene", "glass", "images", "staging"} <= {room(path) for path in FILES}


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_only_its_own_rooms_import_freecad_and_only_gui_imports_qt(path):
    for module in imported(path):
        top = module.split(".")[0]
        if top in FREECAD:
            assert room(path) in ROOMS_WITH_FREECAD | {"freecad"}, f"{path} imports {module}"
        if top in QT:
            assert room(path) == "gui", f"{path} imports {module}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_data_go_one_way(path):
    allowed = MAY_IMPORT.get(room(path))
    if allowed is None:
        return
    for module in imported(path):
        parts = module.split(".")
        if parts[0] == "glassworkbench" and parts[1] != "__version__":
            assert parts[1] in allowed | {room(path)}, f"{path} imports {module}"
