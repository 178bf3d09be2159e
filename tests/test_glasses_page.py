"""The page about glasses tells what the catalogue holds."""

import subprocess
import sys
from pathlib import Path

from glassworkbench.glass import find_filling, find_glass

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "glasses.md"


def test_the_tables_are_those_of_the_catalogue():
    program = f"import sys; sys.path.insert(0, {str(ROOT / 'tools')!r}); import glasses_page as page; " + (
        "text = page.PAGE.read_text(encoding='utf-8'); sys.exit(page.with_tables(text) != text)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, f"run tools/glasses_page.py: {done.stderr}"


def test_the_file_that_the_page_shows_is_one(tmp_path):
    text = PAGE.read_text(encoding="utf-8")
    example = text[text.index("```toml\n") + 8 :]
    path = tmp_path / "example.toml"
    path.write_text(example[: example.index("```")], encoding="utf-8")
    for name in ("our_green", "measured", "lilac"):
        assert find_glass(f"{path}:{name}").refractive_index_d > 1.5


def test_the_changed_recipes_that_the_page_names_are_understood():
    assert find_glass("emerald Cr2O3=0.15 redox=0.4").name.startswith("emerald")
    assert find_filling("beer EBC=20").name.startswith("beer")
