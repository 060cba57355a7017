"""A text as its statements, each read by itself: what still stands after a key is not read again.

A statement begins where the parser knows nothing of what stands before it
(`stlc.syntax.split`), so its characters alone have the same tree, moved.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
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

_AROUND = 2
"""Pieces around a change that are cut anew."""

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
    """A text and its pieces, in order, with where each starts, and the comments, those within
    pieces too."""

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


def cut(source: Source, before: Pieces | None = None) -> Pieces:
    """A text in pieces; those that stood `before`, wherever, are not read again."""
    if oversized(source) is not None:
        return Pieces(source, (0,), (Piece(parse(source)),), ())
    known = before.known if before else {}
    found = None if before is None else _patched(source, before, known)
    return found or _cut(source, 0, len(source.text), known)


def _cut(source: Source, start: int, end: int, known: Mapping[str, Piece]) -> Pieces:
    """The characters [start, end) of a text in pieces."""
    text = source.text[:end]
    tokens = list(tokenize(text, start))
    comments = tuple(token for token in tokens if token.kind == COMMENT)
    starts, pieces = [], []
    for chunk in split(source, [token for token in tokens if token.kind != COMMENT]):
        first, last = chunk.tokens[0].start, chunk.tokens[-1].end
        own = text[first:last]
        starts.append(first)
        pieces.append(known.get(own) or Piece(parse(Source(source.name, own))))
    return Pieces(source, tuple(starts), tuple(pieces), comments)


def _patched(source: Source, before: Pieces, known: Mapping[str, Piece]) -> Pieces | None:
    """A text that differs from one before in one place, cut anew around that only; None where the
    cuts don't meet again.

    A cut depends on nothing before it, and on the first words of what follows: two pieces on either
    side are more than enough.
    """
    old, new, starts = before.source.text, source.text, before.starts
    same, end = _common(old, new)
    first = bisect_right(starts, same) - _AROUND
    last = bisect_left(starts, len(old) - end) + _AROUND
    if first < 0 or last + _AROUND >= len(starts):
        return None
    by = len(new) - len(old)
    middle = _cut(source, starts[first], starts[last + _AROUND] + by, known)
    if starts[last] + by not in middle.starts:
        return None
    met = middle.starts.index(starts[last] + by)
    ahead = [c for c in before.comments if c.start < starts[first]]
    inner = [c for c in middle.comments if c.start < starts[last] + by]
    rest = [
        c._replace(start=c.start + by, end=c.end + by)
        for c in before.comments
        if c.start >= starts[last]
    ]
    return Pieces(
        source,
        (*starts[:first], *middle.starts[:met], *(s + by for s in starts[last:])),
        (*before.pieces[:first], *middle.pieces[:met], *before.pieces[last:]),
        (*ahead, *inner, *rest),
    )


def _common(one: str, other: str) -> tuple[int, int]:
    """How many characters two texts begin with, and how many of the rest they end with, alike."""
    most = min(len(one), len(other))
    same = bisect_left(range(1, most + 1), True, key=lambda n: one[:n] != other[:n])
    most -= same
    end = bisect_left(range(1, most + 1), True, key=lambda n: one[-n:] != other[-n:])
    return same, end


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
