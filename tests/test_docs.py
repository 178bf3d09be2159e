"""The snippets of docs/api.md, run in order in one namespace, as a reader does."""

import re
from pathlib import Path

import numpy as np
import pytest

from glassworkbench.tracer import native

PAGE = Path(__file__).resolve().parent.parent / "docs" / "api.md"


@pytest.mark.skipif(not native.available(), reason="the native tracer is not built")
def test_the_snippets_of_the_macro_api_run(tmp_path, monkeypatch):
    text = PAGE.read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names = {}
    for found in re.finditer(r"^```python\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL):
        line = text[: found.start(1)].count("\n")
        # The line numbers of a failure are the page's.
        exec(compile("\n" * line + found[1], str(PAGE), "exec"), names)
    ball = names["image"]
    assert np.all(np.abs(ball.pixels - 1.0).max(axis=2) <= ball.certificate + 1e-9)
    assert names["seen"].leaks.sum() == 0
    assert names["path"].panel == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["finer.exr", "tumbler.png"]
