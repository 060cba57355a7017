"""Random formulas and runs, and the semantics written down word for word."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from stlc.ir.networks import Count
from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Iff,
    Implies,
    Linear,
    Node,
    Not,
    Or,
    Release,
    Role,
    Signal,
    Timed,
    Until,
)
from stlc.verify.trace import Trace

NAMES = ("x", "y")
LENGTH = 24


def signal(name: str, shift: int = 0) -> Signal:
    return Signal(name, Role.FREE, 0, shift)


def at_least(name: str, threshold: float) -> Linear:
    return Linear(((signal(name), 1.0),), -threshold)


def at_most(name: str, threshold: float) -> Linear:
    return Linear(((signal(name), -1.0),), threshold)


def make_trace(values: dict[str, np.ndarray]) -> Trace:
    length = len(next(iter(values.values())))
    return Trace(length, {(n, Role.FREE): v.reshape(-1, 1) for n, v in values.items()})


levels = st.integers(-8, 8).map(lambda k: k / 4)
traces = st.lists(st.tuples(*(levels for _ in NAMES)), min_size=LENGTH, max_size=LENGTH).map(
    lambda rows: dict(zip(NAMES, np.array(rows, dtype=float).T, strict=True))
)

atoms: st.SearchStrategy[Node] = st.builds(
    lambda make, name, level: make(name, level),
    st.sampled_from([at_least, at_most]), st.sampled_from(NAMES), levels,
)  # fmt: skip

windows = st.tuples(st.integers(0, 3), st.integers(0, 3)).map(lambda w: (w[0], w[0] + w[1]))
open_windows = st.tuples(st.integers(0, 3), st.none())


def _temporal(inner: st.SearchStrategy[Node], spans: object, until: bool) -> object:
    unary = st.builds(
        lambda kind, arg, w: kind(arg, *w), st.sampled_from([Always, Eventually]), inner, spans
    )
    if not until:
        return unary
    binary = st.builds(
        lambda kind, left, right, w: kind(left, right, *w),
        st.sampled_from([Until, Release]), inner, inner, spans,
    )  # fmt: skip
    return unary | binary


def formulas(
    *, until: bool, unbounded: bool = False, timed: bool = False, iff: bool = True
) -> st.SearchStrategy[Node]:
    """Formulas whose bounded windows reach at most 6 steps a level."""
    spans = windows | open_windows if unbounded else windows
    base = atoms | st.builds(Const, st.booleans()) if unbounded else atoms

    def extend(inner: st.SearchStrategy[Node]) -> st.SearchStrategy[Node]:
        few = st.lists(inner, min_size=2, max_size=3).map(tuple)
        kinds = [
            st.builds(Not, inner),
            st.builds(And, few),
            st.builds(Or, few),
            st.builds(Implies, inner, inner),
            _temporal(inner, spans, until),
        ]
        if iff:
            kinds.append(st.builds(Iff, inner, inner))
        if timed:
            kinds.append(st.builds(Timed, few))
        return st.one_of(kinds)

    return st.recursive(base, extend, max_leaves=6)


def horizon(node: Node) -> int:
    """Steps that a bounded formula looks ahead."""
    ahead = max(map(horizon, node.children), default=0)
    match node:
        case Linear(terms=terms):
            return max((s.shift for s, _ in terms), default=0)
        case Always(end=int(end)) | Eventually(end=int(end)) | Until(end=int(end)):
            return ahead + end
        case Release(end=int(end)):
            return ahead + end
        case _:
            return ahead


class Naive:
    """Robustness by the definitions, step by step; None where it can't be judged."""

    def __init__(self, values: dict[str, np.ndarray]) -> None:
        self.values = values
        self.length = len(next(iter(values.values())))
        self.memo: dict[tuple[Node, int], float | None] = {}

    def run(self, node: Node) -> list[float]:
        """Values at the leading steps that can be judged."""
        every = [self.at(node, t) for t in range(self.length)]
        return every[: every.index(None)] if None in every else every

    def at(self, node: Node, t: int) -> float | None:
        if (node, t) not in self.memo:
            self.memo[node, t] = self._at(node, t) if t < self.length else None
        return self.memo[node, t]

    def _at(self, node: Node, t: int) -> float | None:
        match node:
            case Const(value=value):
                return np.inf if value else -np.inf
            case Linear(terms=terms, constant=constant):
                if any(t + s.shift >= self.length for s, _ in terms):
                    return None
                return constant + sum(c * self.values[s.owner][t + s.shift] for s, c in terms)
            case Timed():
                return self.at(node.at(t), t)
            case Always() | Eventually() | Until() | Release():
                return self._temporal(node, t)
        parts = [self.at(child, t) for child in node.children]
        return None if None in parts else self._boolean(node, parts)

    def _boolean(self, node: Node, parts: list[float]) -> float:
        match node:
            case Not():
                return -parts[0]
            case And():
                return min(parts, default=np.inf)
            case Or():
                return max(parts, default=-np.inf)
            case Implies():
                return max(-parts[0], parts[1])
            case Iff():
                return min(max(-parts[0], parts[1]), max(-parts[1], parts[0]))
            case Count(least=least):
                return sorted(parts)[-least]
        raise AssertionError(node)

    def _temporal(self, node: Node, t: int) -> float | None:
        last = min(len(self.run(child)) for child in node.children) - 1
        end = last if node.end is None else t + node.end
        if t + node.start > end or end > last:
            return None
        inside = range(t + node.start, end + 1)
        match node:
            case Always(arg=arg):
                return min(self.at(arg, s) for s in inside)
            case Eventually(arg=arg):
                return max(self.at(arg, s) for s in inside)
            case Until(left=left, right=right):
                return max(self._witness(left, right, t, s) for s in inside)
            case Release(left=left, right=right):
                return -max(self._witness(Not(left), Not(right), t, s) for s in inside)
        raise AssertionError(node)

    def _witness(self, left: Node, right: Node, t: int, s: int) -> float:
        return min(self.at(right, s), *(self.at(left, k) for k in range(t, s + 1)))
