"""Runs the compiled LALR(1) table over the tokens of one statement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, Protocol

from stlc.grammar import Rule, Tables, tables
from stlc.syntax.nodes import Arithmetic
from stlc.syntax.tokens import Token

MAX_DEPTH: Final = 200  # levels of the tree, so that every later stage may recurse
_CHAINS: Final = frozenset({"add", "subtract", "multiply", "divide"})  # walked without recursion

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
    table = tables()
    stack = _Stack([-1, table.start], [], [], [])
    climbs, states = _climbs(), stack.states
    last = tokens[-1].end if tokens else 0
    end = 0  # where the last token shifted ends
    for index, token in enumerate((*tokens, Token("$END", "", last, last))):
        kind = token.kind
        while True:
            key = (states[-2], states[-1], kind)
            found = climbs.get(key)
            if found is None:
                found = climbs[key] = _climb(table, *key)
            states[-1], action = found
            if action is None:
                return stack.values[-1] if found[0] == table.end else Stuck(found[0], index)
            if action >= 0:
                break
            if stack.reduce(table, table.rules[-1 - action], builders, end) > MAX_DEPTH:
                return TooDeep(stack.starts[-1], end)
        states.append(action)
        stack.values.append(token)
        stack.starts.append(token.start)
        stack.depths.append(0)
        end = token.end
    raise AssertionError("the table accepts or refuses at $END")


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


@dataclass(slots=True)
class _Stack:
    """Parallel stacks of a run: states (one more than symbols, and a bottom), values, first
    characters, depths."""

    states: list[int]
    values: list[Any]
    starts: list[int]
    depths: list[int]

    def reduce(self, table: Tables, rule: Rule, builders: Builders, end: int) -> int:
        """Replace the right side of a rule by its left side; the depth of the new node."""
        values, starts, depths, states = self.values, self.starts, self.depths, self.states
        base = len(values) - rule.size
        children = [values[base + k] if k >= 0 else None for k in rule.plan]
        if rule.splices:
            children = _splice(children)
        start = starts[base]
        depth = depths[base] if rule.size == 1 else max(depths[base:])
        if rule.callback is not None:
            if rule.callback in _CHAINS and isinstance(values[base], Arithmetic):
                depth = max(depths[base] - 1, *depths[base + 1 :])  # `a + b + c` is no deeper
            value = builders[rule.callback](start, end, children)
            depth += 1
        else:
            value = children if rule.splices else children[0]
        del values[base:], starts[base:], depths[base:], states[base + 2 :]
        states.append(table.gotos[states[-1]][rule.left])
        values.append(value)
        starts.append(start)
        depths.append(depth)
        return depth


class Sequel(list[Any]):
    """Children of a repetition, to be spliced into the rule that repeats."""


def _splice(children: list[Any]) -> list[Any]:
    """Children with repetitions laid flat; a repetition that grows is reused, so it is linear."""
    flat = children[0] if type(children[0]) is Sequel else Sequel(children[:1])
    for child in children[1:]:
        if type(child) is Sequel:
            flat.extend(child)
        else:
            flat.append(child)
    return flat
