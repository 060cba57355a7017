"""A mission as the editor holds it: pieces, diagnostics, and what was last checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from stlc.diagnostics import Diagnostic
from stlc.errors import MissionError, StlcError
from stlc.loader import FolderLoader, LoadError
from stlc.lsp.index import Index, Part, words
from stlc.lsp.pieces import Pieces, cut
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

    pieces: Pieces
    diagnostics: tuple[Diagnostic, ...]
    mission: Mission | None
    imports: tuple[Imported, ...]

    @property
    def source(self) -> Source:
        """The text with its lines."""
        return self.pieces.source

    @property
    def text(self) -> str:
        """The text itself."""
        return self.source.text

    @property
    def index(self) -> Index:
        """Where its names stand."""
        return self.pieces.index

    @property
    def readable(self) -> bool:
        """Whether it has no mistake of syntax."""
        return self.pieces.ok


def read_document(
    text: str, path: Path | None, before: Document | None = None, params: Mapping[str, str] = {}
) -> Document:
    """Parse and check a text that stands, or will, at `path`. Never raises for any text."""
    from stlc.sema import check_parsed

    pieces = _pieces(text, path, before)
    result = pieces.result if pieces.ok else parse(pieces.source)
    folder = path.parent if path else None
    mission, found = (before.mission if before else None), result.diagnostics
    try:
        mission = check_parsed(result, dict(params), folder)
        found = mission.warnings
    except MissionError as error:
        found = error.diagnostics
    except StlcError:
        pass  # what the parser found stands
    imports = tuple(_imports(result.file, folder, set(), 0)) if folder else ()
    return Document(pieces, tuple(found), mission, imports)


def glance(
    text: str, path: Path | None, before: Document | None, latest: Document | None = None
) -> Document:
    """A text of which what is new was parsed, but nothing checked, for questions between two keys:
    a tenth of the time.

    The mission and the imported files are those of `before`, diagnostics those of the parser, and
    what stood in `latest`, or else in `before`, is not parsed again.
    """
    if before is None:
        return read_document(text, path)
    pieces = _pieces(text, path, latest or before)
    return Document(pieces, tuple(pieces.mistakes()), before.mission, before.imports)


def _pieces(text: str, path: Path | None, before: Document | None) -> Pieces:
    """A text in pieces, those of another one taken over."""
    source = Source(path.name if path else "mission.stl", text)
    return cut(source, before.pieces if before else None)


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
        found.append(Imported(Path(path), source, Index((Part(source, 0, words(tree)),))))
        found += _imports(tree, Path(path).parent, seen, deep + 1)
    return found
