"""Raw tokens to statements.

A statement starts with its keyword as the first word of a line, outside of brackets; `;` outside
of brackets ends one too. Everything up to the next start belongs to the statement, so a line that
doesn't start with a keyword continues the one above. After an operator, comma, colon or `=` a
keyword is an ordinary name, and so it is within brackets, unless what follows it can only be a
statement (`require NAME`, `step 1`): then a forgotten bracket costs one statement, not the file.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import Final

from stlc.diagnostics import Diagnostic
from stlc.grammar import tables
from stlc.source import Source
from stlc.syntax.errors import NestingTooDeep, UnclosedBracket, UnmatchedBracket
from stlc.syntax.lalr import MAX_DEPTH
from stlc.syntax.tokens import NAME, NEWLINE, NUMBER, STRING, SYMBOL, Token

CLOSING: Final = {"(": ")", "[": "]", "{": "}"}
BRACKETS: Final = frozenset("()[]{}")
_WORDS: Final = frozenset(
    {"UNTIL", "RELEASE", "AND", "OR", "IMPLIES", "IFF", "IN", "OUTSIDE", "NOT", "ALWAYS"}
    | {"EVENTUALLY", "NEXT"}
)
_COMPLETE: Final = frozenset({")", "]", "}", ";", "|"})  # a statement may end here


@dataclass(slots=True)
class Chunk:
    """The tokens of one statement; newlines are kept within braces only."""

    tokens: list[Token] = field(default_factory=list)
    mistake: Diagnostic | None = None


@cache
def statement_words() -> dict[str, str]:
    """Terminal of each word that starts a statement."""
    spellings = tables().spellings
    return {word: name for name in spellings if name.startswith("ST_") for word in spellings[name]}


@cache
def operator_words() -> dict[str, str]:
    """Terminal of each operator that is spelled as a word."""
    spellings = tables().spellings
    return {word: kind for kind in _WORDS for word in spellings[kind] if word.isalpha()}


def _continues(previous: Token | None) -> bool:
    """Whether a statement can't be complete after this token."""
    if previous is None:
        return False
    if previous.kind == SYMBOL:
        return previous.text not in _COMPLETE
    return previous.kind == NAME and len(previous.text) > 1 and previous.text in operator_words()


class _Splitter:
    """Walks over the raw tokens; `chunk` is the statement being collected."""

    def __init__(self, source: Source, tokens: list[Token]) -> None:
        self.source = source
        self.tokens = tokens
        self.chunk = Chunk()
        self.open: list[Token] = []
        self.previous: Token | None = None

    def run(self) -> Iterator[Chunk]:
        """Chunks of tokens, one a statement; newlines are kept within braces only."""
        fresh = True
        words = statement_words()
        for position, token in enumerate(self.tokens):
            kind = token.kind
            if kind == NEWLINE:
                fresh = True
                if self.open and self.open[-1].text == "{":
                    self.chunk.tokens.append(token)
                continue
            if fresh and kind == NAME and token.text in words and self._starts(position):
                yield from self._flush()
            elif kind == SYMBOL and token.text == ";" and not self.open:
                yield from self._flush()
                fresh = True
                continue
            fresh = False
            if kind == SYMBOL and token.text in BRACKETS:
                self._bracket(token)
            self.chunk.tokens.append(token)
            self.previous = token
        yield from self._flush()

    def _starts(self, position: int) -> bool:
        """Whether a keyword at the start of a line begins a statement, even in an open bracket.

        A bracket that was never closed must not swallow the rest of the file.
        """
        if not self.open and not _continues(self.previous):
            return True
        after = self._after(position)
        if not _certain(after):
            return False
        if not self.open or self.open[-1].text != "{":
            return True
        # Within braces a keyword is mostly a property: a statement stands at the left margin.
        start = self.tokens[position].start
        at_margin = start == 0 or self.source.text[start - 1] == "\n"
        return at_margin and after[0].kind == NAME and after[1].text in (*"={:", "at")

    def _after(self, position: int) -> tuple[Token, Token]:
        """The two tokens after this one."""
        nothing = Token("", "", 0, 0)
        first, second, *_ = (*self.tokens[position + 1 : position + 3], nothing, nothing)
        return first, second

    def _bracket(self, token: Token) -> None:
        """Keeps count of what is open; blames what doesn't close, or is too deep, and goes on."""
        if token.text in CLOSING:
            self.open.append(token)
            if len(self.open) > MAX_DEPTH:
                span = self.source.span(token.start, token.end)
                self._blame(NestingTooDeep(span=span, limit=MAX_DEPTH))
            return
        if any(CLOSING[opened.text] == token.text for opened in self.open):
            while CLOSING[self.open[-1].text] != token.text:
                self._blame(self._unclosed(self.open.pop()))
            self.open.pop()
        else:
            self._blame(self._unmatched(token))

    def _unclosed(self, token: Token) -> Diagnostic:
        span = self.source.span(token.start, token.end)
        return UnclosedBracket(span=span, opened=token.text, closing=CLOSING[token.text])

    def _unmatched(self, token: Token) -> Diagnostic:
        span = self.source.span(token.start, token.end)
        if not self.open:
            return UnmatchedBracket(span=span, closing=token.text, advice="remove it")
        opened = self.open[-1].text
        advice = f"`{opened}` is open: close it with `{CLOSING[opened]}` first"
        return UnmatchedBracket(span=span, closing=token.text, advice=advice)

    def _blame(self, mistake: Diagnostic) -> None:
        self.chunk.mistake = self.chunk.mistake or mistake

    def _flush(self) -> Iterator[Chunk]:
        if self.open:
            self._blame(self._unclosed(self.open[-1]))
        chunk, self.chunk = self.chunk, Chunk()
        self.open.clear()
        self.previous = None
        if chunk.tokens:
            yield chunk


def _certain(after: tuple[Token, Token]) -> bool:
    """Whether a keyword followed by these tokens can only start a statement."""
    first, second = after
    if first.kind in (NUMBER, STRING):
        return True
    if first.kind != NAME:
        return False
    return first.text not in operator_words() or second.text in (":", "=", "{")


def split(source: Source, tokens: list[Token]) -> Iterator[Chunk]:
    """Statements of a file; comments must have been taken out of the tokens."""
    return _Splitter(source, tokens).run()
