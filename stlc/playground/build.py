"""The playground as a folder that works from disk.

    python -m stlc.playground.build OUT --pyodide FOLDER --packages FOLDER --examples FOLDER

A page from disk may load scripts, and nothing else: so everything, Pyodide and the wheels, is in
`bundle.js` as text, and the page makes modules and workers of it.
"""

from __future__ import annotations

import argparse
import base64
import gzip
import json
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

from stlc.files import write_atomic
from stlc.version import __version__

_SCRIPTS: Final = ("pyodide.mjs", "pyodide.asm.mjs")
_PACKED: Final = ("python_stdlib.zip",)
_PLAIN: Final = ("pyodide.asm.wasm",)


def build(out: Path, pyodide: Path, packages: Path, examples: Path, reports: Path | None) -> None:
    """Write `index.html` and `bundle.js`. Raises OSError where a part is missing.

    `pyodide` is its npm package, `packages` has wheels, `examples` missions and, in `data`, what
    they read; `reports` pages that are named as missions are.
    """
    here = files(__package__)
    scripts = {name: _gz((pyodide / name).read_bytes()) for name in _SCRIPTS}
    scripts["worker.js"] = _gz((here / "worker.js").read_bytes())
    content = {
        "version": __version__,
        "scripts": scripts,
        "files": {name: {"gz": True, "word": _gz((pyodide / name).read_bytes())} for name in _PLAIN}
        | {name: {"gz": False, "word": _word((pyodide / name).read_bytes())} for name in _PACKED},
        "lock": _lock(pyodide),
        "wheels": [{"name": p.name, "word": _word(p.read_bytes())} for p in _wheels(packages)],
        "data": {p.relative_to(examples).as_posix(): p.read_text(encoding="utf-8")
                 for p in sorted((examples / "data").rglob("*.csv"))},
        "examples": [_example(path, reports) for path in sorted(examples.glob("*.stl"))],
    }  # fmt: skip
    page = (here / "page.html").read_text(encoding="utf-8")
    for kind in ("css", "js"):
        text = (here / f"page.{kind}").read_text(encoding="utf-8")
        page = page.replace(f"{{{kind}}}", text)
    out.mkdir(parents=True, exist_ok=True)
    write_atomic(out / "bundle.js", f"const STLC = {_script(content)};\n")
    write_atomic(out / "index.html", page)


def _script(content: Any) -> str:
    """JSON that is JavaScript as well."""
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"))
    return text.replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def _wheels(packages: Path) -> Iterable[Path]:
    return sorted(packages.glob("*.whl"))


def _lock(pyodide: Path) -> str:
    """What Pyodide knows of itself, without its packages: they would come from elsewhere."""
    lock = json.loads((pyodide / "pyodide-lock.json").read_text(encoding="utf-8"))
    return json.dumps({**lock, "packages": {}})


def _example(path: Path, reports: Path | None) -> dict[str, str | None]:
    report = reports / f"{path.stem}.html" if reports is not None else None
    page = report.read_text(encoding="utf-8") if report is not None and report.exists() else None
    return {"name": path.stem.replace("_", " "), "text": path.read_text(encoding="utf-8"),
            "report": page}  # fmt: skip


def _word(data: bytes) -> str:
    return base64.b64encode(data).decode()


def _gz(data: bytes) -> str:
    return _word(gzip.compress(data, mtime=0))


def main() -> None:
    """The command line of this module."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    for name in ("pyodide", "packages", "examples", "reports"):
        parser.add_argument(f"--{name}", type=Path, required=name != "reports")
    build(**vars(parser.parse_args()))


if __name__ == "__main__":
    main()
