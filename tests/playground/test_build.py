"""The playground's folder: everything is in it, nothing is asked of anybody."""

from __future__ import annotations

import base64
import gzip
import json
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest
from py_mini_racer import MiniRacer

from stlc.playground import packages
from stlc.playground.build import build

PYODIDE = {
    "pyodide.mjs": b"export const loadPyodide = 1;",
    "pyodide.asm.mjs": b"export default 2;",
    "pyodide.asm.wasm": b"\0asm" + bytes(100),
    "python_stdlib.zip": b"PK",
    "pyodide-lock.json": json.dumps({
        "info": {"python": "3.14.2", "abi_version": "2026_0"}, "packages": {"numpy": {}},
    }).encode(),
}  # fmt: skip


@pytest.fixture
def parts(tmp_path: Path) -> Path:
    for folder in ("pyodide", "packages", "examples/data", "reports"):
        (tmp_path / folder).mkdir(parents=True)
    for name, data in PYODIDE.items():
        (tmp_path / "pyodide" / name).write_bytes(data)
    (tmp_path / "packages" / "lark-1-py3-none-any.whl").write_bytes(b"wheel")
    (tmp_path / "examples" / "two_carts.stl").write_text("# </script> \u2028\n")
    (tmp_path / "examples" / "data" / "day.csv").write_text("time,price\n0,1\n")
    (tmp_path / "reports" / "two_carts.html").write_text("<p>report</p>")
    return tmp_path


def made(parts: Path) -> tuple[str, dict[str, Any]]:
    """The page, and the bundle as a browser has it."""
    build(parts / "out", *(parts / n for n in ("pyodide", "packages", "examples", "reports")))
    engine = MiniRacer()
    engine.eval((parts / "out" / "bundle.js").read_text(encoding="utf-8"))
    return (parts / "out" / "index.html").read_text(), json.loads(
        engine.eval("JSON.stringify(STLC)")
    )


def test_the_bundle_has_every_part(parts: Path) -> None:
    _, bundle = made(parts)
    unpacked = {k: gzip.decompress(base64.b64decode(v)) for k, v in bundle["scripts"].items()}
    assert unpacked["pyodide.mjs"] == PYODIDE["pyodide.mjs"]
    assert b"self.onmessage" in unpacked["worker.js"]
    wasm = bundle["files"]["pyodide.asm.wasm"]
    assert gzip.decompress(base64.b64decode(wasm["word"])) == PYODIDE["pyodide.asm.wasm"]
    assert [w["name"] for w in bundle["wheels"]] == ["lark-1-py3-none-any.whl"]
    assert bundle["data"] == {"data/day.csv": "time,price\n0,1\n"}
    assert bundle["examples"] == [
        {"name": "two carts", "text": "# </script> \u2028\n", "report": "<p>report</p>"}
    ]
    assert json.loads(bundle["lock"])["packages"] == {}


def test_the_page_asks_nobody(parts: Path) -> None:
    page, bundle = made(parts)
    assert re.findall(r'(?:src|href)="([^"]*)"', page) == ["data:,", "bundle.js"]
    worker = gzip.decompress(base64.b64decode(bundle["scripts"]["worker.js"])).decode()
    assert set(re.findall(r"https?://[^\"/]+", page + worker)) == {"https://nowhere.invalid"}
    assert "{css}" not in page
    assert "{js}" not in page


def test_pip_is_asked_for_what_this_pyodide_takes(parts: Path) -> None:
    words = packages.tags(parts / "pyodide")
    assert words[:4] == ["--platform", "pyemscripten_2026_0_wasm32", "--python-version", "314"]


def test_make_builds_a_wheel_of_this_checkout_and_names_folders_only_where_given() -> None:
    root = Path(__file__).parents[2]
    said = [
        subprocess.run(["make", "-n", "playground", *words], cwd=root, capture_output=True,
                       text=True, check=True).stdout
        for words in ([], ["WHEELS=somewhere"])
    ]  # fmt: skip
    assert all(re.search(r"-m pip wheel .*--no-deps -w out/packages \.", text) for text in said)
    assert ["--wheels 'somewhere'" in text for text in said] == [False, True]
    assert "--wheels ''" not in said[0]
