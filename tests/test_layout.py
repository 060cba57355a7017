"""The house is as docs/architecture.md says: packages listed, top level fixed, imports one way."""

from __future__ import annotations

import ast
import subprocess
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ALLOWED_TOP = {
    "pyproject.toml", "README.md", "stlc", "grammar", "backends", "tests", "benchmarks",
    "examples", "docs", "Makefile", "constraints.txt", "constraints-lowest.txt", "LICENSE",
    "CONTRIBUTING.md", "CHANGELOG.md",
}  # fmt: skip


def _tracked() -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return [Path(line) for line in listed.stdout.splitlines()]


def _config() -> dict[str, dict[str, object]]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]


def _package_name(folder: Path) -> str:
    parts = folder.relative_to(ROOT).parts
    return ".".join(("stlc", *parts) if parts[0] in ("grammar", "backends") else parts)


def test_packages_list_is_exactly_what_is_on_disk() -> None:
    on_disk = {
        _package_name((ROOT / path).parent)
        for path in _tracked()
        if path.name == "__init__.py" and path.parts[0] in ("stlc", "grammar", "backends")
    }
    assert sorted(on_disk) == sorted(_config()["packages"])


def test_top_level_is_fixed() -> None:
    top = {path.parts[0] for path in _tracked() if not path.parts[0].startswith(".")}
    assert top <= ALLOWED_TOP


def test_links_serve_type_checkers_only() -> None:
    for name in ("grammar", "backends"):
        link = ROOT / "stlc" / name
        assert link.is_symlink()
        assert link.resolve() == ROOT / name


@cache
def _parsed(path: Path) -> ast.Module:
    return ast.parse((ROOT / path).read_text())


def _imports(path: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(_parsed(path)):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
    return names


def test_verifier_has_never_met_the_encoder() -> None:
    for path in (ROOT / "stlc" / "verify").rglob("*.py"):
        met = {
            n
            for n in _imports(path.relative_to(ROOT))
            if n.startswith(("stlc.passes", "stlc.milp", "stlc.bezier"))
        }
        assert not met, f"{path} imports {met}"


def test_nothing_names_this_machine() -> None:
    for path in _tracked():
        full = ROOT / path
        if full.is_symlink() or path.suffix in (".png", ".gz", ".npz"):
            continue
        text = full.read_text(errors="replace")
        assert "/".join(["", "work", ""]) not in text or path.name == "test_layout.py", path
        assert "index" + "-url" not in text, path


BUILDERS = {"ExprBuilder", "StatementBuilder"}
"""Classes whose methods are productions of grammar/stl.lark, where each is told."""


def _functions(
    node: ast.AST, inside: tuple[str, ...] = ()
) -> Iterator[tuple[str, ast.FunctionDef]]:
    """Functions and methods with their qualified names, those within functions left out."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef):
            yield ".".join((*inside, child.name)), child
        elif isinstance(child, ast.ClassDef):
            if child.name not in BUILDERS:
                yield from _functions(child, (*inside, child.name))
        elif not isinstance(child, ast.expr):
            yield from _functions(child, inside)


def _needs_docstring(name: str, function: ast.FunctionDef) -> bool:
    if any(ast.unparse(d) == "overload" for d in function.decorator_list):
        return False
    if function.name.startswith("__"):
        return False
    lines = (function.end_lineno or 0) - function.lineno + 1
    return lines > 10 or not any(part.startswith("_") for part in name.split("."))


def test_what_a_reader_would_stop_at_has_a_docstring() -> None:
    bare = [
        f"{path}: {name}"
        for path in _tracked()
        if path.suffix == ".py" and path.parts[0] in ("stlc", "grammar", "backends")
        and (ROOT / path).is_file()
        for name, function in _functions(_parsed(path))
        if _needs_docstring(name, function) and not ast.get_docstring(function)
    ]  # fmt: skip
    assert not bare, "\n".join(bare)


def test_functions_and_files_stay_short() -> None:
    """Most functions are far below; what is longer is two things. The figures hold everywhere."""
    for path in _tracked():
        if path.suffix != ".py" or (ROOT / path).is_symlink() or not (ROOT / path).is_file():
            continue
        assert (ROOT / path).read_text().count("\n") <= 300, path
        for name, function in _functions(_parsed(path)):
            lines = (function.end_lineno or 0) - function.lineno + 1
            assert lines <= 40, f"{path}: {name} has {lines} lines"
