"""Messages by parser state: the table of malformed samples, and what could stand there."""

from __future__ import annotations

from functools import cache
from typing import Any, Final

from stlc.grammar import tables
from stlc.grammar.message import Message
from stlc.grammar.messages import MESSAGES
from stlc.source import Source
from stlc.syntax.context import classify
from stlc.syntax.lalr import Stuck, run
from stlc.syntax.tokens import NEWLINE, Token, tokenize

_OPENING: Final = frozenset({"LPAR", "CALL", "LSQB", "INDEX", "IVL", "LBRACE", "ABS_OPEN"})
_CLOSING: Final = frozenset({"RPAR", "RSQB", "RBRACE", "ABS_CLOSE"})
_OPERAND: Final = frozenset({"NUMBER", "NAME", "LPAR", "MINUS"})
_FORMULA: Final = _OPERAND | {"ALWAYS", "NOT"}
_CONNECTIVES: Final = frozenset({"AND", "OR", "IMPLIES"})
_ARITHMETIC: Final = frozenset({"STAR", "SLASH"})
_COMPARISONS: Final = frozenset({"LE", "GE"})
_SHOWN: Final = {
    "NAME": "a name", "KEY": "a property", "NUMBER": "a number", "STRING": "a string",
    "UNIT": "a unit", "$END": "the end of the statement", "SEP": "`;` or a new line",
    "INDEX": "`[`", "CALL": "`(`",
}  # fmt: skip


class _Nothing:
    """Stands for all builders: samples need no tree."""

    def __getitem__(self, name: str) -> Any:
        return lambda start, end, children: None


Place = tuple[int, str, str]  # parser state, terminal it can't use, innermost open bracket


def opener(tokens: list[Token], index: int) -> str:
    """Terminal of the innermost bracket that is open before token `index`, or nothing."""
    open_ones = [""]
    for token in tokens[:index]:
        if token.kind in _OPENING:
            open_ones.append(token.kind)
        elif token.kind in _CLOSING and len(open_ones) > 1:
            open_ones.pop()
    return open_ones[-1]


def stuck_at(sample: str) -> Place | None:
    """Where the parser stops on a sample, None if it is valid."""
    raw = [token for token in tokenize(Source("sample", sample).text) if token.kind != NEWLINE]
    tokens = classify(raw)
    outcome = run(tokens, _Nothing())
    if not isinstance(outcome, Stuck):
        return None
    kind = tokens[outcome.index].kind if outcome.index < len(tokens) else "$END"
    return outcome.state, kind, opener(tokens, outcome.index)


@cache
def _by_place() -> dict[Place, Message]:
    """Messages by place; earlier messages win. Computed at the first mistake."""
    found: dict[Place, Message] = {}
    for message in MESSAGES:
        for sample in message.samples:
            place = stuck_at(sample)
            if place is None:
                continue
            found.setdefault(place, message)
            if message.any_token:
                found.setdefault((place[0], "", place[2]), message)
    return found


def message_for(place: Place) -> Message | None:
    """The message for a parser that stops at this place."""
    exact = _by_place().get(place)
    state, kind, bracket = place
    if exact is not None or kind == "$END":
        return exact
    return _by_place().get((state, "", bracket))


def expectation(state: int) -> str:
    """What could stand here, in words."""
    possible = set(tables().actions[state])
    words: list[str] = []
    for group, name in (
        (_FORMULA, "a formula"),
        (_OPERAND, "a value"),
        (_CONNECTIVES, "an operator such as `and`"),
        (_COMPARISONS, "a comparison"),
        (_ARITHMETIC, "an operator such as `+`"),
    ):
        if group <= possible:
            words.append(name)
            if group & _OPERAND:
                break
    if not words:
        words = [_SHOWN.get(name) or f"`{tables().spellings[name][0]}`" for name in possible]
        words.sort()
    elif "$END" in possible:
        words.append("the end of the statement")
    return " or ".join(words[:4])
