"""Turns a stuck parser into a diagnostic."""

from __future__ import annotations

from dataclasses import dataclass

from stlc.diagnostics import Diagnostic
from stlc.source import Source
from stlc.syntax.errors import SyntaxMistake, UnexpectedEnd
from stlc.syntax.tokens import Token


@dataclass(frozen=True, slots=True)
class Trouble:
    """Where the parser stopped: its state, and the index of the token it can't use."""

    source: Source
    raw: list[Token]
    tokens: list[Token]
    state: int
    index: int


def explain(trouble: Trouble) -> tuple[Diagnostic, list[Token], list[Token]]:
    """The mistake, and the raw tokens before and after it that are worth parsing alone."""
    source, tokens, index = trouble.source, trouble.tokens, trouble.index
    if index >= len(tokens):
        last = tokens[-1]
        span = source.span(last.start, last.end)
        return UnexpectedEnd(span=span, what="statement is incomplete", place="ends here"), [], []
    token = tokens[index]
    span = source.span(token.start, token.end)
    return SyntaxMistake(span=span, what=f"unexpected `{token.text}`", place="here"), [], []
