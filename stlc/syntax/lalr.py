"""Runs the compiled LALR(1) table over the tokens of one statement."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from stlc.grammar import Tables, tables
from stlc.syntax.tokens import Token

MAX_DEPTH: Final = 200  # levels of the tree, so that every later stage may recurse

Builder = Callable[[int, int, list[Any]], Any]


@dataclass(frozen=True, slots=True)
class Stuck:
    """The parser can't go on: `state` doesn't allow token number `index` (its end if equal)."""

    state: int
    index: int


@dataclass(frozen=True, slots=True)
class TooDeep:
    """The tree is deeper than MAX_DEPTH; the part [start, end) is the innermost that is."""

    start: int
    end: int


def run(tokens: Sequence[Token], builders: Mapping[str, Builder]) -> Any | Stuck | TooDeep:
    """The node of one statement. `builders[callback](start, end, children)` makes nodes."""
    table = tables()
    stack = _Stack(table, builders)
    for index, token in enumerate(tokens):
        outcome = stack.feed(token, token.kind, index)
        if outcome is not None:
            return outcome
    end = tokens[-1].end if tokens else 0
    outcome = stack.feed(Token("$END", "", end, end), "$END", len(tokens))
    return stack.values[-1] if outcome is None else outcome


class _Stack:
    """The four parallel stacks of a run: states, values, first characters, depths."""

    __slots__ = ("builders", "depths", "end", "starts", "states", "table", "values")

    def __init__(self, table: Tables, builders: Mapping[str, Builder]) -> None:
        self.table = table
        self.builders = builders
        self.states = [table.start]
        self.values: list[Any] = []
        self.starts: list[int] = []
        self.depths: list[int] = []
        self.end = 0  # where the last token shifted ends

    def feed(self, token: Token, kind: str, index: int) -> Stuck | TooDeep | None:
        """Reduce as long as the table says so, then shift the token."""
        actions, states = self.table.actions, self.states
        while True:
            if states[-1] == self.table.end and kind == "$END":
                return None
            action = actions[states[-1]].get(kind)
            if action is None:
                return Stuck(states[-1], index)
            if action >= 0:
                self._shift(token, action)
                return None
            depth = self._reduce(-1 - action)
            if depth > MAX_DEPTH:
                return TooDeep(self.starts[-1], self.end)

    def _shift(self, token: Token, state: int) -> None:
        self.states.append(state)
        self.values.append(token)
        self.starts.append(token.start)
        self.depths.append(0)
        self.end = token.end

    def _reduce(self, number: int) -> int:
        rule = self.table.rules[number]
        size = rule.size
        states = self.states
        if size == 1 and rule.callback is None and rule.plan == (0,):
            states[-1] = self.table.gotos[states[-2]][rule.left]
            return 0  # a step of the precedence ladder: value, place and depth stay
        children: list[Any] = []
        values = self.values[-size:]
        for position in rule.plan:
            children.append(None if position < 0 else values[position])
        return self._replace(rule.left, rule.callback, size, children)

    def _replace(self, left: str, callback: str | None, size: int, children: list[Any]) -> int:
        start, depth = self.starts[-size], max(self.depths[-size:])
        value: Any
        if callback is None:
            value = _splice(children) if left.startswith("_") else children[0]
        else:
            value = self.builders[callback](start, self.end, _splice(children))
            depth += 1
        for stack in (self.states, self.values, self.starts, self.depths):
            del stack[-size:]
        self.states.append(self.table.gotos[self.states[-1]][left])
        self.values.append(value)
        self.starts.append(start)
        self.depths.append(depth)
        return depth


class Sequel(list[Any]):
    """Children of a repetition, to be spliced into the rule that repeats."""


def _splice(children: list[Any]) -> list[Any]:
    """Children with repetitions laid flat; a repetition that grows is reused, so it is linear."""
    if children and isinstance(children[0], Sequel):
        flat = children[0]
        rest = children[1:]
    else:
        flat, rest = Sequel(), children
    for child in rest:
        if isinstance(child, Sequel):
            flat.extend(child)
        else:
            flat.append(child)
    return flat
