"""Missions to start from: examples, documentation, benchmarks, and those inside the tests."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LARGEST = 300_000  # bytes of a data file that is taken along
_BLOCK = re.compile(r"^```(?:stl|json|csv|stl-library)([^\n]*)\n(.*?)^```", re.M | re.S)
_PRELUDE = re.compile(r"<!-- prelude (\w+)\n(.*?)-->", re.S)
_QUOTED = re.compile(r'"([^"\n]+\.\w+)"')


@dataclass(frozen=True, slots=True)
class Seed:
    """A mission's text and the files that it names, by their relative path."""

    name: str
    text: str
    files: Mapping[str, bytes] = field(default_factory=dict)

    @property
    def is_heavy(self) -> bool:
        """Compiling it takes seconds: fewer of its mutants are compiled."""
        return self.name.startswith(("benchmarks", "examples"))


def corpus(more: tuple[Path, ...] = ()) -> list[Seed]:
    """All seeds, sorted by name. `more` are further folders of missions."""
    folders = [ROOT / "examples", ROOT / "benchmarks" / "missions", ROOT / "tests" / "golden"]
    folders.append(ROOT / "tests" / "cases")
    found = [seed for folder in (*folders, *more) for seed in _folder(folder)]
    found += [s for p in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")] for s in _page(p)]
    found += [s for path in (ROOT / "tests").rglob("test_*.py") for s in _module(path)]
    return sorted(found, key=lambda seed: (seed.name, seed.text))


def _folder(folder: Path) -> Iterator[Seed]:
    for path in folder.rglob("*.stl"):
        text = path.read_bytes().decode("utf-8", "replace")
        files = {n: p.read_bytes() for n in _QUOTED.findall(text) if _small(p := path.parent / n)}
        yield Seed(_label(path), text, files)


def _small(path: Path) -> bool:
    return path.is_file() and path.stat().st_size <= LARGEST


def _label(path: Path) -> str:
    return path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else path.name


def _page(path: Path) -> Iterator[Seed]:
    """Fenced missions after their prelude; the page's other blocks are the files they name."""
    text = path.read_text(encoding="utf-8")
    preludes = dict(_PRELUDE.findall(text))
    blocks = _BLOCK.findall(text)
    files = {m[1]: body for info, body in blocks if (m := re.search(r"file=(\S+)", info))}
    for number, (info, body) in enumerate(blocks):
        place = re.search(r" in (\w+)", info)
        whole = preludes.get(place[1], "") + body if place else body
        if re.search(r"^(agent|signal|require)\b", whole, re.M):
            named = {n: files[n].encode() for n in _QUOTED.findall(whole) if n in files}
            yield Seed(f"{_label(path)}:{number}", whole, named)


def _module(path: Path) -> Iterator[Seed]:
    """Strings of a test module that look like missions."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if not (isinstance(node, ast.Constant) and isinstance(node.value, str)):
            continue
        text = node.value
        if "\n" in text and re.search(r"^\s*(agent|signal)\b", text, re.M) and len(text) < 20_000:
            yield Seed(f"{_label(path)}:{node.lineno}", text)
