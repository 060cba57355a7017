"""The packages that the playground runs on, as wheels for Pyodide, by pip.

    python -m stlc.playground.packages OUT --pyodide FOLDER [--wheels FOLDER]

What is pure Python comes from the package index. NumPy, SciPy, Shapely and HiGHS have to be
compiled for WebAssembly: pip takes such wheels from the index as soon as there are any, and from
`--wheels`, where a distribution of Pyodide is unpacked. Without them the page parses and lays out.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Final

from stlc.playground.engine import SOLVING

PURE: Final = ("lark", "pygments")


def tags(pyodide: Path) -> list[str]:
    """pip's words for what a Pyodide takes, from what its npm package says of itself."""
    info = json.loads((pyodide / "pyodide-lock.json").read_text(encoding="utf-8"))["info"]
    python = "".join(info["python"].split(".")[:2])
    platform = f"pyemscripten_{info['abi_version']}_wasm32"
    return ["--platform", platform, "--python-version", python, "--implementation", "cp",
            "--abi", f"cp{python}", "--abi", "abi3", "--abi", "none"]  # fmt: skip


def fetch(package: str, out: Path, pyodide: Path, wheels: Path | None) -> str | None:
    """Put a wheel of a package into `out`; what pip said where there is none."""
    found = [] if wheels is None else ["--find-links", str(wheels)]
    done = subprocess.run(
        [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check",
         "--no-deps", "--only-binary", ":all:", "-d", str(out), *tags(pyodide), *found, package],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return None if done.returncode == 0 else (done.stderr.strip().splitlines() or ["no wheel"])[-1]


def main() -> int:
    """Exit 1 where a package is missing without which there is no page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--pyodide", type=Path, required=True)
    parser.add_argument("--wheels", type=Path, default=None)
    given = parser.parse_args()
    wheels = given.wheels if given.wheels is not None and given.wheels.is_dir() else None
    missing = {p: fetch(p, given.out, given.pyodide, wheels) for p in (*PURE, *SOLVING)}
    lacks = {p: said for p, said in missing.items() if said is not None}
    for package, said in lacks.items():
        print(f"without {package}: {said}")
    if lacks.keys() & set(SOLVING):
        print("so the page does not check what texts mean, nor solve; WHEELS=FOLDER names a folder "
              "with wheels for Pyodide")  # fmt: skip
    return 1 if lacks.keys() & set(PURE) else 0


if __name__ == "__main__":
    raise SystemExit(main())
