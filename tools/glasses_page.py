"""Draw the pictures of docs/glasses.md and write its tables, from the catalogue of the installation."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "glasses.md"
PICTURES = ROOT / "docs" / "pictures"

sys.path.insert(0, str(ROOT))
# The page is of the installation: glasses of whoever runs this do not belong there.
os.environ["GLASSWORKBENCH_GLASSES"] = str(ROOT / "none")

from glassworkbench.glass import catalogue, facts, fillings  # noqa: E402
from glassworkbench.glass.pictures import save_curves, save_swatches  # noqa: E402


def main() -> None:
    """Write pictures and page."""
    save_swatches(catalogue(), fillings(), PICTURES / "glass_swatches.png")
    save_curves(catalogue(), fillings(), PICTURES / "glass_curves.png")
    PAGE.write_text(with_tables(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


def with_tables(page: str) -> str:
    """Return the page with its tables written anew, each between its own marks."""
    known = [facts(material) for material in (*catalogue().values(), *fillings().values())]
    tables = {"materials": _materials(known), "chromophores": _chromophores(known)}
    for name, table in tables.items():
        marks = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end -->)", re.DOTALL)
        page, count = marks.subn(lambda match, table=table: match[1] + table + match[2], page)
        assert count == 1, f"{PAGE}: expected one place for {name}, found {count}"
    return page


def _materials(known: list[dict]) -> str:
    rows = ["| material | n_d | Abbe | g/cm³ | known, nm | recipe | sources; *assumed* |", "|" + " --- |" * 7]
    for told in known:
        recipe = ", ".join(f"{name} {amount:g}" for name, amount in told["recipe"].items())
        if told["redox"] is not None:
            recipe += f", redox {told['redox']:g}"
        sources = f"{told['source']}. Index: {told['refractive_index_source']}"
        assumed = f"; *{told['assumed']}*" if told["assumed"] else ""
        low, high = told["range_nm"]
        rows.append(
            f"| `{told['name']}`: {told['description']} | {told['refractive_index_d']:.5f} | {told['abbe_number']:.1f} "
            f"| {told['density_g_per_cm3']:g} | {low:g}–{high:g} | {recipe or 'measured as a whole'} "
            f"| {sources}{assumed} |"
        )
    return "\n".join(rows) + "\n"


def _chromophores(known: list[dict]) -> str:
    rows = ["| chromophore | source | assumed |", "| --- | --- | --- |"]
    found = {row["name"]: row for told in known for row in told["chromophores"]}
    rows += [f"| {name} | {row['source']} | {row['assumed'] or 'nothing'} |" for name, row in found.items()]
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    main()
