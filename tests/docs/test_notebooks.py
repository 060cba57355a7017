"""Notebooks in examples/: their cells run in order, and print what they show."""

from __future__ import annotations

import ast
import io
import json
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[2] / "examples").glob("*.ipynb"))


def run(source: str, names: dict[str, Any]) -> tuple[str, object]:
    """What a cell prints, and the value of its last expression."""
    tree, value = ast.parse(source), None
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    out = io.StringIO()
    with redirect_stdout(out):
        exec(compile(tree, "cell", "exec"), names)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
    return out.getvalue(), value


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_notebook(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] != "code":
            continue
        printed, value = run("".join(cell["source"]), names)
        shown = [o for o in cell["outputs"] if o["output_type"] == "stream"]
        assert printed == "".join("".join(o["text"]) for o in shown)
        results = [o["data"] for o in cell["outputs"] if o["output_type"] == "execute_result"]
        assert bool(results) == (value is not None)
        for data in results:
            for kind, hook in (("text/html", "_repr_html_"), ("image/png", "_repr_png_")):
                assert (kind in data) == hasattr(value, hook)


def test_there_is_a_notebook() -> None:
    assert NOTEBOOKS
