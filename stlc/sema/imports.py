"""`import "lib.stl"`: the statements of other files, each file once, circles reported."""

from __future__ import annotations

from pathlib import Path

from stlc.loader import LoadError
from stlc.sema.files import Files
from stlc.sema.name_errors import ImportCycle, TooDeep
from stlc.sema.report import Mistake, Report
from stlc.source import Source
from stlc.syntax import ast

MOST_DEEP = 50


def statements(file: ast.File, files: Files, report: Report) -> list[ast.Statement]:
    """All statements, imported ones in the place of their `import`."""
    return _expand(file, files, report, (_own_name(file, files),), set())


def _own_name(file: ast.File, files: Files) -> str:
    """The resolved name of the mission itself, if it is a file."""
    try:
        return files.loader.resolve(Path(file.source.name).name, "")
    except LoadError:
        return file.source.name


def _expand(
    file: ast.File, files: Files, report: Report, path: tuple[str, ...], done: set[str]
) -> list[ast.Statement]:
    """Statements with those of imported files in the place of their imports."""
    found: list[ast.Statement] = []
    for statement in file.statements:
        if isinstance(statement, ast.Import):
            with report.guard():
                found.extend(_imported(statement, files, report, path, done))
        else:
            found.append(statement)
    return found


def _imported(
    statement: ast.Import, files: Files, report: Report, path: tuple[str, ...], done: set[str]
) -> list[ast.Statement]:
    """Statements of one file, nothing if it was imported before; `path` is the way to it."""
    from stlc.syntax.parse import parse

    name, span = statement.path.value, statement.path.span
    resolved = files.resolve(name, span)
    if resolved in path:
        raise Mistake(ImportCycle(span=span, path=name))
    if resolved in done:
        return []
    if len(path) > MOST_DEEP:
        raise Mistake(TooDeep(span=span, limit=MOST_DEEP))
    done.add(resolved)
    source = Source(files.loader.shown(resolved), files.text(name, span))
    files.known[source] = resolved
    result = parse(source)
    for diagnostic in result.diagnostics:
        report.add(diagnostic)
    return _expand(result.file, files, report, (*path, resolved), done)
