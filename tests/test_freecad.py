"""FreeCAD is found where it is, and its absence is said in one sentence."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def run(code: str, **environment: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False, env=environment
    )


def test_importing_the_package_imports_no_freecad():
    result = run("import sys, glassworkbench.errors; print('FreeCAD' in sys.modules)")
    assert result.stdout.strip() == "False"


def test_freecad_is_importable_through_the_door():
    result = run("from glassworkbench.freecad import Part; print(round(Part.makeBox(1, 2, 3).Volume, 9))")
    assert result.stdout.strip() == "6.0"


def test_a_python_without_freecad_says_what_to_do():
    code = """
import sys
class Nothing:
    def find_spec(self, name, *rest):
        if name == "FreeCAD":
            raise ImportError(name)
sys.meta_path.insert(0, Nothing())
from glassworkbench.errors import GlassWorkbenchError
try:
    import glassworkbench.freecad
except GlassWorkbenchError as error:
    print(error)
"""
    result = run(code)
    assert "FREECAD_PATH" in result.stdout
    assert len(result.stdout.strip().splitlines()) == 1
