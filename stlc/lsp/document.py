"""A mission as the editor holds it: tree, index, diagnostics, and what was last checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from stlc.diagnostics import Diagnostic
from stlc.errors import MissionError, StlcError
from stlc.loader import FolderLoader, LoadError
from stlc.lsp.index import Index, index
from stlc.mission import Mission
from stlc.source import Source
from stlc.syntax import ast
from stlc.syntax.parse import parse

MOST_DEEP = 50  # of imports, as the checker has it


@dataclass(frozen=True, slots=True, eq=False)
class Imported:
    """A file that the mission imports."""

    path: Path
    source: Source
    index: Index


@dataclass(frozen=True, slots=True, eq=False)
class Document:
    """One text. `mission` is the checked mission, of this text or of the last that had none of the
    mistakes; None while there was none."""

    source: Source
    file: ast.File
    index: Index
    diagnostics: tuple[Diagnostic, ...]
    mission: Mission | None
    imports: tuple[Imported, ...]
    readable: bool  # no mistake of syntax

    @property
    def text(self) -> str:
        """The text itself."""
        return self.source.text


def read_document(
    text: str, path: Path | None, before: Document | None = None, params: Mapping[str, str] = {}
) -> Document:
    """Parse and check a text that stands, or will, at `path`. Never raises for any text."""
    from stlc.sema import load_mission

    source = Source(path.name if path else "mission.stl", text)
    result = parse(source)
    folder = path.parent if path else None
    mission, found = (before.mission if before else None), result.diagnostics
    try:
        mission = load_mission(source, dict(params), folder)
        found = mission.warnings
    except MissionError as error:
        found = error.diagnostics
    except StlcError:
        pass  # what the parser found stands
    imports = tuple(_imports(result.file, folder, set(), 0)) if folder else ()
    return Document(source, result.file, index(result.file), tuple(found), mission, imports,
                    result.ok)  # fmt: skip


def glance(text: str, path: Path | None, before: Document | None) -> Document:
    """A text parsed but not checked, for questions between two keys: a third of the time.

    The mission and the imported files are those of `before`, diagnostics those of the parser.
    """
    if before is None:
        return read_document(text, path)
    source = Source(path.name if path else "mission.stl", text)
    result = parse(source)
    return Document(source, result.file, index(result.file), tuple(result.diagnostics),
                    before.mission, before.imports, result.ok)  # fmt: skip


def _imports(file: ast.File, folder: Path, seen: set[str], deep: int) -> list[Imported]:
    """Imported files that can be read, each once."""
    loader = FolderLoader(folder)
    found: list[Imported] = []
    for statement in file.statements:
        if not isinstance(statement, ast.Import) or deep >= MOST_DEEP:
            continue
        try:
            path = loader.resolve(statement.path.value, "")
            text = loader.read_bytes(statement.path.value, "").decode("utf-8-sig")
        except (LoadError, UnicodeDecodeError):
            continue  # a diagnostic says so
        if path in seen:
            continue
        seen.add(path)
        source = Source(Path(path).name, text)
        tree = parse(source).file
        found.append(Imported(Path(path), source, index(tree)))
        found += _imports(tree, Path(path).parent, seen, deep + 1)
    return found
