"""What bounds alone say about a formula's robustness: an interval that holds for every run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import cos, hypot, inf, pi
from typing import assert_never

import numpy as np

from stlc.ir.networks import Count, Network
from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Iff,
    Implies,
    Linear,
    Link,
    Node,
    Not,
    Or,
    Quantity,
    Relation,
    Release,
    Role,
    Signal,
    Timed,
    Until,
)
from stlc.ir.norms import Norms, Sum
from stlc.mission import Agent, Array, PolygonKind
from stlc.places import Polytope

Interval = tuple[float, float]

_QUANTITY: dict[Quantity, Interval] = {
    Quantity.BER: (0.0, 0.5),
    Quantity.BER_AT_MEAN: (0.0, 0.5),
    Quantity.PRR: (0.0, 1.0),
}


@dataclass(slots=True)
class StaticRange:
    """Intervals of robustness; `starts`, if given, fixes the states at step 0.

    `later` are those that hold at any step, by node: they don't depend on the starts.
    """

    boxes: Mapping[tuple[str, Role], list[Interval]]
    starts: Mapping[str, Array] = field(default_factory=dict)
    later: dict[int, Interval] = field(default_factory=dict)
    early: dict[int, Interval] = field(default_factory=dict)  # at the start
    kept: list[Node] = field(default_factory=list)

    def of(self, node: Node, first: bool) -> Interval:
        """Interval of the formula, judged at step 0 (`first`) or at any step."""
        known = self.early if first else self.later
        found = known.get(id(node))
        if found is not None:
            return found
        todo = [(node, first)]
        while todo:  # deeper than Python's stack, maybe
            part, start = todo[-1]
            unknown = self._unknown(part, False)
            if start:
                unknown += self._unknown(part, True)
            todo += unknown
            if not unknown:
                self._keep(part, start)
                todo.pop()
        return known[id(node)]

    def _unknown(self, node: Node, first: bool) -> list[tuple[Node, bool]]:
        """The parts that are to be looked at before; predicates, most of all nodes, are at once."""
        known, unknown = self.early if first else self.later, []
        for child in node.children:
            if id(child) in known:
                continue
            if child.children:
                unknown.append((child, first))
            else:
                self._keep(child, first)
        return unknown

    def _keep(self, node: Node, first: bool) -> None:
        (self.early if first else self.later)[id(node)] = self._compute(node, first)
        self.kept.append(node)

    def _compute(self, node: Node, first: bool) -> Interval:
        """An interval that holds the robustness at the start (`first`), or at any step."""
        if node.norms is not None:  # the lengths themselves, not the faces that stand for them
            return self._lengths(node.norms, first)
        match node:
            case Const(value=value):
                return (inf, inf) if value else (-inf, -inf)
            case Linear():
                return self._linear(node, first)
            case Link():
                return _link(node)
            case Not(arg=arg):
                low, high = self.of(arg, first)
                return -high, -low
            case And(args=args):
                return _least(self._all(args, first))
            case Or(args=args):
                return _most(self._all(args, first))
            case Count(args=args) | Network(args=args):
                return _hull([self.of(a, first) for a in args])
            case Implies(left=left, right=right):
                return self._implies(left, right, first)
            case Iff(left=left, right=right):
                there = self._implies(left, right, first)
                return _least([there, self._implies(right, left, first)])
            case Always(arg=arg):
                return _least(self._window(node, arg, first))
            case Eventually(arg=arg):
                return _most(self._window(node, arg, first))
            case Until(left=left, right=right):
                return _least([_hull(self._near(c, first)) for c in (left, right)])
            case Release(left=left, right=right):
                return _most([_hull(self._near(c, first)) for c in (left, right)])
            case Timed(cases=cases):
                return _hull([self.of(c, first) for c in cases])
        raise TypeError(f"no range for {type(node).__name__}")

    def _all(self, args: Sequence[Node], first: bool) -> list[Interval]:
        """Intervals of parts that are known."""
        known = self.early if first else self.later
        return [known[id(arg)] for arg in args]

    def _implies(self, left: Node, right: Node, first: bool) -> Interval:
        low, high = self.of(left, first)
        return _most([(-high, -low), self.of(right, first)])

    def _window(self, node: Always | Eventually, arg: Node, first: bool) -> list[Interval]:
        if not first or node.start > 0:
            return [self.of(arg, False)]
        return [self.of(arg, True)] if node.end == 0 else self._near(arg, True)

    def _near(self, arg: Node, first: bool) -> list[Interval]:
        later = self.of(arg, False)
        return [self.of(arg, True), later] if first else [later]

    def _lengths(self, norms: Norms, first: bool) -> Interval:
        """rest + sum of coefficient * sqrt(x^2 + y^2 + ..) over the intervals of x, y, .."""
        low, high = self._linear(norms.rest, first)
        for coefficient, components in norms.lengths:
            parts = [self._linear(c, first) for c in components]
            least = hypot(*(max(a, -b, 0.0) for a, b in parts))
            most = hypot(*(max(-a, b) for a, b in parts))
            ends = (coefficient * least, coefficient * most)
            low, high = low + min(ends), high + max(ends)
        return low, high

    def _linear(self, node: Linear | Sum, first: bool) -> Interval:
        low = high = node.constant
        for signal, coefficient in node.terms:
            least, most = self._signal(signal, first)
            ends = (coefficient * least, coefficient * most)
            low, high = low + min(ends), high + max(ends)
        return low, high

    def _signal(self, signal: Signal, first: bool) -> Interval:
        start = self.starts.get(signal.owner)
        if first and signal.shift == 0 and signal.role is Role.STATE and start is not None:
            value = float(start[signal.index])
            return value, value
        box = self.boxes.get((signal.owner, signal.role))
        if box is None:
            return -inf, inf
        return box[signal.index]


def _least(parts: list[Interval]) -> Interval:
    return min([p[0] for p in parts], default=inf), min([p[1] for p in parts], default=inf)


def _most(parts: list[Interval]) -> Interval:
    return max([p[0] for p in parts], default=-inf), max([p[1] for p in parts], default=-inf)


def _hull(parts: list[Interval]) -> Interval:
    return min(p[0] for p in parts), max(p[1] for p in parts)


def _link(node: Link) -> Interval:
    """The quality's natural range against the threshold; a chance is left open."""
    if node.probability is not None:
        return -inf, inf
    low, high = _QUANTITY.get(node.quantity, (-inf, inf))
    match node.relation:
        case Relation.AT_LEAST:
            ends = low - node.threshold, high - node.threshold
        case Relation.AT_MOST:
            ends = node.threshold - high, node.threshold - low
        case _:
            assert_never(node.relation)
    return node.factor * ends[0], node.factor * ends[1]


def boxes(
    agents: Mapping[str, Agent], workspace: Polytope | None
) -> dict[tuple[str, Role], list[Interval]]:
    """Intervals of every state and input, from bounds, norms and the workspace."""
    found: dict[tuple[str, Role], list[Interval]] = {}
    for name, agent in agents.items():
        found[(name, Role.STATE)] = _pairs(*_state_box(agent, workspace))
        lower, upper = agent.input_lower.copy(), agent.input_upper.copy()
        found[(name, Role.INPUT)] = _pairs(*_with_norms(lower, upper, agent, "input"))
    return found


def _pairs(lower: Array, upper: Array) -> list[Interval]:
    return [(float(low), float(high)) for low, high in zip(lower, upper, strict=True)]


def _state_box(agent: Agent, workspace: Polytope | None) -> tuple[Array, Array]:
    """Bounds of the states, with the workspace where one state is one coordinate of the place."""
    lower, upper = agent.state_lower.copy(), agent.state_upper.copy()
    rows = agent.dynamics.position
    if workspace is not None and rows is not None:
        for axis, row in enumerate(rows):
            used = np.flatnonzero(row)
            if len(used) == 1 and row[used[0]] == 1.0:
                corner = workspace.vertices[:, axis]
                lower[used] = np.maximum(lower[used], corner.min())
                upper[used] = np.minimum(upper[used], corner.max())
    return _with_norms(lower, upper, agent, "state")


def _with_norms(lower: Array, upper: Array, agent: Agent, what: str) -> tuple[Array, Array]:
    """A state's norm holds from step 1 on, so its value at step 0 is let in as well."""
    for norm in agent.state_norms if what == "state" else agent.input_norms:
        outer = norm.kind is PolygonKind.OUTER
        reach = norm.limit / cos(pi / norm.sides) if outer else norm.limit
        for k in norm.indices:
            start = float(agent.start[k]) if what == "state" else 0.0
            lower[k] = max(lower[k], min(-reach, start))
            upper[k] = min(upper[k], max(reach, start))
    return lower, upper
