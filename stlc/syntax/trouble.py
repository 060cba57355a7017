"""Turns a stuck parser into a diagnostic."""

from __future__ import annotations

import difflib
from dataclasses import dataclass

from stlc.diagnostics import Diagnostic, Fix
from stlc.grammar import tables
from stlc.source import Source, Span
from stlc.syntax.errors import (
    BadNumber,
    SingleEquals,
    SyntaxMistake,
    UnexpectedEnd,
    UnknownStatement,
)
from stlc.syntax.friendly import expectation, message_for, opener
from stlc.syntax.misspelt import misspelt
from stlc.syntax.past import PAST, past_operator
from stlc.syntax.split import BRACKETS, statement_words
from stlc.syntax.tokens import NAME, NUMBER, SYMBOL, Token, split_number


@dataclass(frozen=True, slots=True)
class Trouble:
    """Where the parser stopped: its state, and the index of the token it can't use.

    `raw` are the tokens as written, `tokens` the same with the grammar's terminals.
    """

    source: Source
    raw: list[Token]
    tokens: list[Token]
    state: int
    index: int

    @property
    def token(self) -> Token:
        """The token that doesn't fit; the last one when the statement ends too early."""
        return self.tokens[min(self.index, len(self.tokens) - 1)]

    @property
    def at_end(self) -> bool:
        """Whether it is the end of the statement that doesn't fit."""
        return self.index >= len(self.tokens)

    @property
    def kind(self) -> str:
        """Terminal that doesn't fit."""
        return "$END" if self.at_end else self.token.kind

    def span(self, token: Token) -> Span:
        """Span of a token."""
        return self.source.span(token.start, token.end)

    def allows(self, terminal: str) -> bool:
        """Whether the parser could go on with this terminal."""
        return terminal in tables().actions[self.state]


@dataclass(frozen=True, slots=True)
class Explained:
    """The mistake, and the raw tokens before and after it that are worth parsing alone."""

    mistake: Diagnostic
    before: tuple[Token, ...] = ()
    after: tuple[Token, ...] = ()


def explain(trouble: Trouble) -> Explained:
    """What is wrong, in the words that fit best."""
    if _alien_line(trouble):
        return _unknown_statement(trouble)
    mistake = (
        _dashes(trouble)
        or _past(trouble)
        or _bad_number(trouble)
        or _single_equals(trouble)
        or misspelt(trouble.source, trouble.tokens, trouble.index)
        or _by_sample(trouble)
    )
    return Explained(mistake or _plain(trouble))


def _alien_line(trouble: Trouble) -> bool:
    """Whether a complete statement is followed by a line that is none."""
    token = trouble.token
    if trouble.at_end or (trouble.index > 0 and not trouble.allows("$END")):
        return False
    if not token.text[:1].isalpha() and trouble.index > 0:
        return False
    line = trouble.source.text.rfind("\n", 0, token.start) + 1
    first = not trouble.source.text[line : token.start].strip()
    return first and _depth_before(trouble.raw, token.start) == 0


def _depth_before(raw: list[Token], start: int) -> int:
    texts = [t.text for t in raw if t.start < start and t.kind == SYMBOL and t.text in BRACKETS]
    return sum(1 if text in "([{" else -1 for text in texts)


def _unknown_statement(trouble: Trouble) -> Explained:
    """A line without a keyword; the nearest one is read instead, so that more is found."""
    token = trouble.token
    before = tuple(t for t in trouble.raw if t.start < token.start)
    rest = [t for t in trouble.raw if t.start >= token.start]
    span = trouble.span(token)
    near = difflib.get_close_matches(token.text.lower(), statement_words(), 1, 0.7)
    if not near:
        advice = "start the line with a keyword such as `require`, `region` or `let`"
        return Explained(UnknownStatement(span=span, word=token.text, advice=advice), before)
    meant = Token(NAME, near[0], token.start, token.end)
    advice, fix = f"did you mean `{near[0]}`?", Fix(span, near[0])
    mistake = UnknownStatement(span=span, word=token.text, advice=advice, fix=fix)
    return Explained(mistake, before, (meant, *rest[1:]))


def _dashes(trouble: Trouble) -> Diagnostic | None:
    """A line that begins with `--`, as comments do elsewhere."""
    start, text = trouble.token.start, trouble.source.text
    line = text.rfind("\n", 0, start) + 1
    if trouble.at_end or text[line:start].strip() or text[start : start + 2] != "--":
        return None
    span = trouble.source.span(start, start + 2)
    what, place = "a line begins with `--`", "no comment here"
    return SyntaxMistake(
        span=span, what=what, place=place, advice="comments begin with `#` or `//`"
    )


def _past(trouble: Trouble) -> Diagnostic | None:
    """A past operator where the parser stops, or just before: `x since y`, `H[0,5] x`."""
    if trouble.at_end:
        return None
    token = trouble.token
    if token.kind == NAME and token.text in PAST:
        return past_operator(trouble.span(token))
    position = trouble.index - 1
    if position >= 0 and trouble.tokens[position].kind == "RSQB":
        while position > 0 and trouble.tokens[position].kind not in ("INDEX", "LSQB"):
            position -= 1
        position -= 1
    if position < 0:
        return None
    suspect = trouble.tokens[position]
    if suspect.kind == NAME and suspect.text in PAST:
        return past_operator(trouble.span(suspect))
    return None


def _bad_number(trouble: Trouble) -> Diagnostic | None:
    """Letters that follow a number without a blank: `3x`, `2 m/sec`."""
    if trouble.at_end or trouble.index == 0:
        return None
    token, before = trouble.token, trouble.tokens[trouble.index - 1]
    if token.kind not in (NAME, NUMBER) or before.kind != NUMBER or before.end != token.start:
        return None
    span = trouble.source.span(before.start, token.end)
    digits, _ = split_number(before.text)
    advice = f"for a product write `{digits} * {token.text}`; units are m, s, kg, dB, dBm, ..."
    return BadNumber(span=span, text=span.text, tail=token.text, advice=advice)


def _single_equals(trouble: Trouble) -> Diagnostic | None:
    if trouble.kind != "EQ" or not trouble.allows("EQEQ") or trouble.index < 2:
        return None
    kinds = [token.kind for token in trouble.tokens[: trouble.index]]
    if kinds[0] in ("ST_REQUIRE", "ST_PREFER") and "COLON" not in kinds:
        return None  # `require reach = ..` lacks its colon
    span = trouble.span(trouble.token)
    return SingleEquals(span=span, fix=Fix(span, "=="))


def _by_sample(trouble: Trouble) -> Diagnostic | None:
    message = message_for((trouble.state, trouble.kind, opener(trouble.tokens, trouble.index)))
    if message is None:
        return None
    span, found = trouble.span(trouble.token), trouble.token.text
    what, place, advice = (
        text.replace("{found}", found) for text in (message.what, message.place, message.advice)
    )
    kind = UnexpectedEnd if trouble.at_end else SyntaxMistake
    return kind(span=span, what=what, place=place, advice=advice)


def _plain(trouble: Trouble) -> Diagnostic:
    """What was found and what could stand there instead."""
    expected = expectation(trouble.state)
    span = trouble.span(trouble.token)
    if trouble.at_end:
        what, place = "the statement is incomplete", f"expected {expected} after this"
        return UnexpectedEnd(span=span, what=what, place=place)
    what = f"unexpected `{trouble.token.text}`" if trouble.token.text.strip() else "unexpected end"
    return SyntaxMistake(span=span, what=what, place=f"expected {expected}")
