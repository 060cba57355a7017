"""Places on a terminal: tabs, wide and zero-width characters, lines that are too long."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from typing import Final

from stlc.source import Span

TAB: Final = 4
MAX_WIDTH: Final = 100  # terminal cells of source text that are shown
_LEAD: Final = 40  # cells kept before the mistake in a line that is cut
_CUT: Final = ".."


@dataclass(frozen=True, slots=True)
class Excerpt:
    """A line as shown, and where in it the marks go (terminal cells)."""

    text: str
    offset: int
    width: int


def cells(char: str, at: int = 0) -> int:
    """Terminal cells a character takes; a tab goes to the next multiple of TAB."""
    if char == "\t":
        return TAB - at % TAB
    if unicodedata.combining(char) or unicodedata.category(char) in ("Mn", "Me", "Cf"):
        return 0
    return 2 if unicodedata.east_asian_width(char) in "WF" else 1


def _visible(char: str, at: int) -> str:
    if char == "\t":
        return " " * cells(char, at)
    if char.isprintable() or cells(char) == 0:
        return char
    return "\N{REPLACEMENT CHARACTER}"


def _show(text: str) -> tuple[str, list[int]]:
    """The text with tabs expanded, and the cell at which each character starts (and the end)."""
    shown: list[str] = []
    places = [0]
    for char in text:
        shown.append(_visible(char, places[-1]))
        places.append(places[-1] + cells(char, places[-1]))
    return "".join(shown), places


def excerpt(span: Span) -> Excerpt:
    """The first line of a span, cut to MAX_WIDTH cells around it."""
    line, column = span.source.position(span.start)
    text = span.source.line(line)
    first = min(column - 1, len(text))
    last = min(first + max(span.end - span.start, 0), len(text))
    left = max(0, first - _LEAD) if len(text) > MAX_WIDTH else 0
    right = min(len(text), left + MAX_WIDTH)
    shown, places = _show(text[left:right])
    prefix, suffix = _CUT if left else "", _CUT if right < len(text) else ""
    begin, end = places[first - left], places[min(last, right) - left]
    return Excerpt(prefix + shown + suffix, len(prefix) + begin, max(1, end - begin))
