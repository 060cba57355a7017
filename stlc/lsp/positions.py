"""Offsets of characters and positions of the protocol: lines, and UTF-16 units within them."""

from __future__ import annotations

from lsprotocol import types

from stlc.source import Source, Span


def position(source: Source, offset: int) -> types.Position:
    """The position of an offset."""
    line, column = source.position(min(max(offset, 0), len(source.text)))
    before = source.text[offset - column + 1 : offset]
    return types.Position(line - 1, _units(before))


def _units(text: str) -> int:
    return len(text.encode("utf-16-le")) // 2


def offset(source: Source, at: types.Position) -> int:
    """The offset of a position; beyond a line's end, that end."""
    lines = source.text.split("\n")
    if at.line >= len(lines):
        return len(source.text)
    start = sum(len(line) + 1 for line in lines[: at.line])
    units, line = at.character, lines[at.line].rstrip("\r")
    for k, character in enumerate(line):
        if units <= 0:
            return start + k
        units -= _units(character)
    return start + len(line)


def place(span: Span) -> types.Range:
    """The range of a span."""
    return types.Range(position(span.source, span.start), position(span.source, span.end))
