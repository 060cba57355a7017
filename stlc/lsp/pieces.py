"""A text as its statements, each read by itself: what still stands after a key is not read again.

A statement begins where the parser knows nothing of what stands before it
(`stlc.syntax.split`), so its characters alone have the same tree, moved.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from stlc.diagnostics import Diagnostic
from stlc.lsp.index import Index, Part, Words, words
from stlc.record import NamedRecord, Record
from stlc.sema import collector_paused
from stlc.source import Source, Span
from stlc.syntax import ast
from stlc.syntax.parse import ParseResult, parse
from stlc.syntax.screen import oversized
from stlc.syntax.split import split
from stlc.syntax.tokens import COMMENT, Token, tokenize

_PLACELESS = frozenset({str, float, int, bool, type(None)})


@dataclass(frozen=True, eq=False)
class Piece:
    """One statement, or what stands in its place, as a text of its own."""

    read: ParseResult

    @cached_property
    def words(self) -> Words:
        """Its names, counted from its first character."""
        return words(self.read.file)


@dataclass(frozen=True, eq=False)
class Pieces:
    """A text and its pieces, in order, with where each starts."""

    source: Source
    starts: tuple[int, ...]
    pieces: tuple[Piece, ...]
    comments: tuple[Token, ...]

    @property
    def ok(self) -> bool:
        """Whether no piece has a mistake."""
        return all(piece.read.ok for piece in self.pieces)

    @property
    def known(self) -> dict[str, Piece]:
        """The pieces by their characters."""
        return {piece.read.file.source.text: piece for piece in self.pieces}

    @cached_property
    def index(self) -> Index:
        """The names of the text."""
        placed = zip(self.starts, self.pieces, strict=True)
        return Index(tuple(Part(self.source, start, piece.words) for start, piece in placed))

    @cached_property
    def result(self) -> ParseResult:
        """What the parser makes of the whole text, where there is no mistake in it."""
        spans = (self.source.span(c.start, c.end) for c in self.comments)
        told = zip(self.comments, spans, strict=True)
        comments = tuple(ast.Comment(c.text.rstrip(), span) for c, span in told)
        with collector_paused():
            file = ast.File(self.source, tuple(self._statements()), comments)
        return ParseResult(file, tuple(self.mistakes()))

    def mistakes(self) -> Iterator[Diagnostic]:
        """Mistakes and warnings of the pieces, at their places in the text."""
        for start, piece in zip(self.starts, self.pieces, strict=True):
            yield from moved(piece.read.diagnostics, self.source, start)

    def _statements(self) -> Iterator[ast.Statement]:
        for start, piece in zip(self.starts, self.pieces, strict=True):
            yield from moved(piece.read.file.statements, self.source, start)

    def within(self, start: int, end: int) -> Iterator[tuple[int, ast.Statement]]:
        """Statements that the characters [start, end) may hold, each as it stands in its piece,
        with where that starts."""
        first = max(bisect_right(self.starts, start) - 1, 0)
        for at, piece in zip(self.starts[first:], self.pieces[first:], strict=True):
            if at > end:
                return
            yield from ((at, statement) for statement in piece.read.file.statements)


def cut(source: Source, known: Mapping[str, Piece]) -> Pieces:
    """A text in pieces; those that are `known` by their characters are not read again."""
    if oversized(source) is not None:
        return Pieces(source, (0,), (Piece(parse(source)),), ())
    tokens = list(tokenize(source.text))
    comments = tuple(token for token in tokens if token.kind == COMMENT)
    starts, pieces = [], []
    for chunk in split(source, [token for token in tokens if token.kind != COMMENT]):
        start, end = chunk.tokens[0].start, chunk.tokens[-1].end
        text = source.text[start:end]
        starts.append(start)
        pieces.append(known.get(text) or Piece(parse(Source(source.name, text))))
    return Pieces(source, tuple(starts), tuple(pieces), comments)


def moved(node: Any, source: Source, by: int) -> Any:
    """A node, or a tuple of such, with its places `by` characters further on, in another text."""
    kind = type(node)
    if kind is Span:
        return Span(source, node.start + by, node.end + by)
    if kind is tuple:
        return tuple([moved(item, source, by) for item in node])
    if not isinstance(node, Record | NamedRecord):
        return node
    copy = object.__new__(kind)
    for field, put in zip(kind.record_fields, kind.record_setters, strict=True):
        value = getattr(node, field)
        put(copy, value if type(value) in _PLACELESS else moved(value, source, by))
    return copy
