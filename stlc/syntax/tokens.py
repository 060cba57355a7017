"""Text to raw tokens: one compiled regular expression, no look at the neighbours."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from typing import Final, NamedTuple

from stlc.grammar import tables
from stlc.grammar.units import UNITS

NEWLINE: Final = "NL"
COMMENT: Final = "COMMENT"
NAME: Final = "NAME"
NUMBER: Final = "NUMBER"
STRING: Final = "STRING"
SYMBOL: Final = "SYMBOL"
BAD: Final = "BAD"


class Token(NamedTuple):
    """A token: its kind (raw kind, later the grammar's terminal) and characters [start, end)."""

    kind: str
    text: str
    start: int
    end: int


def _alternatives(words: frozenset[str]) -> str:
    return "|".join(map(re.escape, sorted(words, key=lambda word: (-len(word), word))))


@cache
def _pattern() -> re.Pattern[str]:
    """One alternative a kind of token, the first that matches wins; blanks are skipped before."""
    unit = rf"(?:{_alternatives(UNITS)})(?:\^-?\d+)?"
    symbols = {
        text
        for name, words in tables().spellings.items()
        for text in words
        if not (text[0].isalpha() or text[0] == "_")
    }
    parts = {
        NEWLINE: r"\n",
        COMMENT: r"(?:\#|//)[^\n]*",
        # A unit belongs to the number when it follows on the same line: `2 m/s`, `10 dB^2`, `5s`.
        NUMBER: r"(?:\d+(?:\.(?!\.)\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
        rf"(?:[ \t]*{unit}(?:[/*]{unit})*(?!\w))?",
        # `10x10` is two numbers joined by x.
        NAME: r"(?<=\d)x(?=\d)|[^\W\d]\w*",
        STRING: r'"(?:[^"\\\n]|\\[^\n])*"?',
        SYMBOL: r"\[[ \t]*\]|" + _alternatives(frozenset(symbols)),
        BAD: r"[^ \t\r\f]",
    }
    body = "|".join(f"(?P<{name}>{pattern})" for name, pattern in parts.items())
    return re.compile(rf"[ \t\r\f]*(?:{body})")


def tokenize(text: str, start: int = 0) -> Iterator[Token]:
    """All tokens from `start` on, newlines and comments included."""
    for match in _pattern().finditer(text, start, len(text.rstrip(" \t\r\f"))):
        kind = match.lastgroup
        if kind is not None:
            first, end = match.span(kind)
            yield Token(kind, match[kind], first, end)


_NUMBER = re.compile(r"([\d.]+(?:[eE][+-]?\d+)?)[ \t]*(.*)")


def split_number(text: str) -> tuple[str, str | None]:
    """Digits and unit of a NUMBER token: `10 dB^2` is (`10`, `dB^2`)."""
    match = _NUMBER.fullmatch(text)
    assert match is not None
    return match[1], match[2] or None
