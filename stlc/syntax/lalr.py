"""Runs the compiled LALR(1) table over the tokens of one statement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, Protocol

from stlc.grammar import Rule, Tables, tables
from stlc.syntax.tokens import Token

MAX_DEPTH: Final = 200  # levels of the tree, so that every later stage may recurse

Builder = Callable[[int, int, list[Any]], Any]


class Builders(Protocol):
    """Finds the builder of a callback."""

    def __getitem__(self, name: str, /) -> Builder: ...


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


def run(tokens: Sequence[Token], builders: Builders) -> Any | Stuck | TooDeep:
    """The node of one statement. `builders[callback](start, end, children)` makes nodes."""
    stack = _Stack(tables(), builders)
    outcome: Stuck | TooDeep | None
    for index, token in enumerate(tokens):
        outcome = stack.feed(token, token.kind, index)
        if outcome is not None:
            return outcome
    end = tokens[-1].end if tokens else 0
    outcome = stack.feed(Token("$END", "", end, end), "$END", len(tokens))
    return stack.values[-1] if outcome is None else outcome


@cache
def _climbs() -> dict[tuple[int, int, str], tuple[int, int | None]]:
    """Memory of `_climb`: (state below, state, terminal) to (state, action) at the top."""
    return {}


def _climb(table: Tables, below: int, state: int, kind: str) -> tuple[int, int | None]:
    """State and action once all steps of the precedence ladder (`sum: product`) are taken."""
    while True:
        action = table.actions[state].get(kind)
        if action is None or action >= 0 or not table.rules[-1 - action].is_step:
            return state, action
        state = table.gotos[below][table.rules[-1 - action].left]


class _Stack:
    """The four parallel stacks of a run: states, values, first characters, depths."""

    __slots__ = ("builders", "climbs", "depths", "end", "starts", "states", "table", "values")

    def __init__(self, table: Tables, builders: Builders) -> None:
        self.table = table
        self.builders = builders
        self.climbs = _climbs()
        self.states = [table.start]
        self.values: list[Any] = []
        self.starts: list[int] = []
        self.depths: list[int] = []
        self.end = 0  # where the last token shifted ends

    def feed(self, token: Token, kind: str, index: int) -> Stuck | TooDeep | None:
        """Reduce as long as the table says so, then shift the token."""
        states, climbs = self.states, self.climbs
        while len(states) > 1:
            below, state = states[-2], states[-1]
            if state == self.table.end and kind == "$END":
                return None
            found = climbs.get((below, state, kind))
            if found is None:
                found = climbs[below, state, kind] = _climb(self.table, below, state, kind)
            states[-1], action = found
            if action is None:
                return Stuck(states[-1], index)
            if action >= 0:
                self._shift(token, action)
                return None
            if self._reduce(self.table.rules[-1 - action]) > MAX_DEPTH:
                return TooDeep(self.starts[-1], self.end)
        first = self.table.actions[self.table.start].get(kind)
        if first is None:
            return Stuck(self.table.start, index)
        self._shift(token, first)
        return None

    def _shift(self, token: Token, state: int) -> None:
        self.states.append(state)
        self.values.append(token)
        self.starts.append(token.start)
        self.depths.append(0)
        self.end = token.end

    def _reduce(self, rule: Rule) -> int:
        size, values = rule.size, self.values
        base = len(values) - size
        children = [values[base + k] if k >= 0 else None for k in rule.plan]
        start = self.starts[base]
        depth: int = max(self.depths[base:])
        value: Any
        if rule.callback is not None:
            value = self.builders[rule.callback](start, self.end, _splice(children))
            depth += 1
        else:
            value = _splice(children) if rule.is_sequel else children[0]
        del values[base:], self.starts[base:], self.depths[base:], self.states[base + 1 :]
        self.states.append(self.table.gotos[self.states[-1]][rule.left])
        values.append(value)
        self.starts.append(start)
        self.depths.append(depth)
        return depth


class Sequel(list[Any]):
    """Children of a repetition, to be spliced into the rule that repeats."""


def _splice(children: list[Any]) -> list[Any]:
    """Children with repetitions laid flat; a repetition that grows is reused, so it is linear."""
    if not any(type(child) is Sequel for child in children):
        return Sequel(children)
    flat = children[0] if type(children[0]) is Sequel else Sequel(children[:1])
    for child in children[1:]:
        if type(child) is Sequel:
            flat.extend(child)
        else:
            flat.append(child)
    return flat
