"""Checks on the characters, before there is any syntax."""

from __future__ import annotations

import unicodedata
from typing import Final

from stlc.diagnostics import Diagnostic, Fix
from stlc.source import Source
from stlc.syntax.errors import TooLarge, UnknownCharacter, UnterminatedString
from stlc.syntax.tokens import STRING, Token

MAX_FILE: Final = 32_000_000  # characters
MAX_LINE: Final = 1_000_000

_LOOKALIKES: Final = {
    "“": '"', "”": '"', "„": '"', "‟": '"', "‘": "'", "’": "'", "–": "-", "—": "-", "×": "x",
    "：": ":", "，": ",", "（": "(", "）": ")", "；": ";", "＝": "=",
    "\u00a0": " ", "\u2003": " ", "\u3000": " ", "\v": " ",
}  # fmt: skip


def oversized(source: Source) -> Diagnostic | None:
    """The mistake of a file, or a line of it, beyond any reasonable size."""
    text = source.text
    if len(text) > MAX_FILE:
        span = source.span(0, min(len(text), 1))
        return TooLarge(span=span, what="the file", size=len(text), limit=MAX_FILE)
    if len(text) <= MAX_LINE:
        return None
    start = 0
    while start < len(text):
        end = text.find("\n", start)
        end = len(text) if end < 0 else end
        if end - start > MAX_LINE:
            span = source.span(start, start + 1)
            return TooLarge(span=span, what="this line", size=end - start, limit=MAX_LINE)
        start = end + 1
    return None


def stray(source: Source, token: Token) -> Diagnostic:
    """The mistake of a character or string that can't be a token."""
    span = source.span(token.start, token.end)
    if token.kind == STRING:
        return UnterminatedString(span=span)
    char = token.text
    lookalike = _LOOKALIKES.get(char)
    if lookalike is not None:
        wanted = f"`{lookalike}`" if lookalike.strip() else "a blank"
        advice = f"write {wanted}; this look-alike comes with text copied from a document"
        fix = Fix(span, lookalike)
        return UnknownCharacter(span=span, shown=_shown(char), advice=advice, fix=fix)
    if char == "%":
        advice, fix = "comments begin with `#` or `//`", Fix(span, "#")
        return UnknownCharacter(span=span, shown=_shown(char), advice=advice, fix=fix)
    return UnknownCharacter(span=span, shown=_shown(char))


def _shown(char: str) -> str:
    """The character itself if it can be seen, and its name."""
    name = unicodedata.name(char, "")
    code = f"U+{ord(char):04X}"
    visible = f"`{char}` " if char.isprintable() and not char.isspace() else ""
    return f"{visible}({name.lower() or 'control character'}, {code})"
