"""Text to syntax tree, with every mistake reported at its characters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from stlc.diagnostics import Diagnostic, Severity
from stlc.grammar import tables
from stlc.source import Source
from stlc.syntax import ast
from stlc.syntax.build_stmt import StatementBuilder
from stlc.syntax.context import classify
from stlc.syntax.errors import NestingTooDeep, TooManyMistakes
from stlc.syntax.lalr import MAX_DEPTH, Builder, Stuck, TooDeep, run
from stlc.syntax.screen import oversized, stray
from stlc.syntax.split import Chunk, split
from stlc.syntax.tokens import BAD, COMMENT, STRING, Token, tokenize

MAX_MISTAKES: Final = 50


@dataclass(frozen=True, slots=True)
class ParseResult:
    """The statements that could be read, and all diagnostics in the order of the text."""

    file: ast.File
    diagnostics: tuple[Diagnostic, ...]

    @property
    def ok(self) -> bool:
        """Whether there is no error (warnings don't count)."""
        return all(d.severity is not Severity.ERROR for d in self.diagnostics)


def parse(source: Source) -> ParseResult:
    """Parse a mission file. Never raises on any text: mistakes are in `diagnostics`."""
    too_large = oversized(source)
    if too_large is not None:
        return ParseResult(ast.File(source, ()), (too_large,))
    return _Parser(source).run()


class _Parser:
    """State of one parse: what was read, what was wrong."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.builder = StatementBuilder(source)
        self.builders: dict[str, Builder] = {
            rule.callback: getattr(self.builder, rule.callback)
            for rule in tables().rules
            if rule.callback is not None
        }
        self.statements: list[ast.Statement] = []
        self.comments: list[ast.Comment] = []
        self.mistakes: list[Diagnostic] = []
        self.stopped = False

    def run(self) -> ParseResult:
        for chunk in split(self.source, list(self._meaningful())):
            if self._full(chunk.tokens[0]):
                break
            self._chunk(chunk)
        found = [*self.mistakes, *self.builder.mistakes, *self.builder.mixes.warnings]
        found.sort(key=lambda d: d.span.start if d.span else 0)
        file = ast.File(self.source, tuple(self.statements), tuple(self.comments))
        return ParseResult(file, tuple(found))

    def _full(self, token: Token) -> bool:
        """Whether enough mistakes were told; says so, once, at the token where reading ends."""
        if len(self.mistakes) >= MAX_MISTAKES and not self.stopped:
            span = self.source.span(token.start, token.end)
            self.mistakes.append(TooManyMistakes(span=span, count=MAX_MISTAKES))
            self.stopped = True
        return self.stopped

    def _meaningful(self) -> list[Token]:
        """Raw tokens without comments and without characters that mean nothing."""
        kept: list[Token] = []
        for token in tokenize(self.source.text):
            if token.kind == COMMENT:
                span = self.source.span(token.start, token.end)
                self.comments.append(ast.Comment(token.text.rstrip(), span))
            elif token.kind == BAD or (token.kind == STRING and not _closed(token)):
                if len(self.mistakes) < MAX_MISTAKES:
                    self.mistakes.append(stray(self.source, token))
                kept.append(token)
            else:
                kept.append(token)
        return kept

    def _chunk(self, chunk: Chunk) -> None:
        if any(token.kind == BAD or not _closed(token) for token in chunk.tokens):
            return  # told already
        elif chunk.mistake is not None:
            self.mistakes.append(chunk.mistake)
        else:
            self._statements(chunk.tokens)

    def _statements(self, raw: list[Token]) -> None:
        """One statement, and those behind it where the line between them is alien."""
        while raw and not self._full(raw[0]):
            raw = self._statement(raw)

    def _statement(self, raw: list[Token]) -> list[Token]:
        """Read one statement; the tokens that are left after a line that is alien."""
        tokens = classify(raw)
        noticed = len(self.builder.mixes.warnings)
        outcome: Any = run(tokens, self.builders)
        if isinstance(outcome, Stuck | TooDeep):
            del self.builder.mixes.warnings[noticed:]  # of half a statement
        match outcome:
            case Stuck():
                return self._recover(raw, tokens, outcome)
            case TooDeep(start, end):
                span = self.source.span(start, end)
                self.mistakes.append(NestingTooDeep(span=span, limit=MAX_DEPTH))
            case _:
                self.statements.append(outcome)
        return []

    def _recover(self, raw: list[Token], tokens: list[Token], stuck: Stuck) -> list[Token]:
        """Report the mistake; read the part before a line that is alien, return that after it."""
        from stlc.syntax.trouble import Trouble, explain  # only mistakes need explanations

        explained = explain(Trouble(self.source, raw, tokens, stuck.state, stuck.index))
        if explained.before:
            self._statement(list(explained.before))
        self.mistakes.append(explained.mistake)
        return list(explained.after)


def _closed(token: Token) -> bool:
    """False for a string without its closing quote."""
    if token.kind != STRING:
        return True
    text = token.text
    body = text[:-1]
    slashes = len(body) - len(body.rstrip("\\"))
    return len(text) > 1 and text[-1] == '"' and slashes % 2 == 0
