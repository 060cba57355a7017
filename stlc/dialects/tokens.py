"""Tokens of other tools' languages."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from stlc.dialects.errors import DialectSyntax, ImportFailure
from stlc.source import Source, Span

Kind = Literal["number", "name", "symbol", "end"]

_KINDS: dict[str | None, Kind] = {"number": "number", "name": "name", "symbol": "symbol"}
_NUMBER = r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"


@dataclass(frozen=True, slots=True)
class Token:
    """A token; `text` is "" at the end of the file."""

    kind: Kind
    text: str
    span: Span


def pattern(comment: str, name: str, symbols: tuple[str, ...]) -> re.Pattern[str]:
    """The scanner of a language; longer symbols win."""
    ordered = "|".join(map(re.escape, sorted(symbols, key=len, reverse=True)))
    return re.compile(
        rf"(?P<skip>\s+|{comment})|(?P<number>{_NUMBER})|(?P<name>{name})|(?P<symbol>{ordered})"
    )


def tokenize(source: Source, scanner: re.Pattern[str]) -> list[Token]:
    """All tokens and one for the end. Raises ImportFailure at a character that starts none."""
    return list(_scan(source, scanner))


def _scan(source: Source, scanner: re.Pattern[str]) -> Iterator[Token]:
    """Tokens with their spans, and an `end` behind the last character that isn't blank."""
    at, text = 0, source.text
    while at < len(text):
        match = scanner.match(text, at)
        if match is None:
            span = source.span(at, at + 1)
            problem = f"unexpected character {text[at]!a}"
            raise ImportFailure(DialectSyntax(span=span, problem=problem, place="not understood"))
        start, at = at, match.end()
        if match.lastgroup in _KINDS:
            yield Token(_KINDS[match.lastgroup], match.group(), source.span(start, at))
    last = len(text.rstrip())
    yield Token("end", "", source.span(last, last))
