"""`swept` conditions on states and inputs of any agents, in continuous time.

A condition is a minimum and maximum of linear forms of signals; along the paths of the states each
form is quadratic on every piece, so that its extrema are exact (`continuous.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from math import hypot

import numpy as np

from stlc.ir.nodes import And, Const, Linear, Node, Or, Role, Timed
from stlc.plan import Run
from stlc.verify.continuous import Combine, extremum
from stlc.verify.paths import Array, Path
from stlc.verify.sway import Quadratic

Forms = tuple[Array, Array, Array, Array]
"""c0, c1, c2 (rows, leaves) of all leaves, and what a path may put them off by (rows, leaves)."""


@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """Paths of all states and the inputs of a run; T+1 steps of `pieces` rows each.

    `radii` [m] of agents whose position is somewhere in a disc around their path.
    """

    paths: Mapping[str, Path]
    runs: Mapping[str, Run]
    radii: Mapping[str, float] = field(default_factory=dict)

    @property
    def pieces(self) -> int:
        """Pieces of a step."""
        return next((path.pieces for path in self.paths.values()), 1)

    def least(self, condition: Node, steps: int) -> Array:
        """Least robustness (L,) over [t, t + 1], t = 0..L-1, L <= `steps`."""
        count = steps - max((s.shift for leaf in _leaves(condition) for s, _ in leaf.terms),
                            default=0)  # fmt: skip
        frames = condition.cases if isinstance(condition, Timed) else (condition,)
        parts = []
        for t, case in enumerate(frames[:count]):
            last = t == min(len(frames), count) - 1
            parts.append(self._frame(case, slice(t, count if last else t + 1)))
        return np.concatenate([np.empty(0), *parts])

    def _frame(self, condition: Node, steps: slice) -> Array:
        leaves = list(_leaves(condition))
        c0, c1, c2, error = self._forms(leaves, steps)
        found = extremum(
            c0, c1, c2, _combine(condition, {leaf: k for k, leaf in enumerate(leaves)})
        )
        worst = error.max(axis=1, initial=0.0)
        return np.asarray((found.value - worst).reshape(-1, self.pieces).min(axis=1))

    def _forms(self, leaves: list[Linear], steps: slice) -> Forms:
        """Coefficients c0, c1, c2 and error (pieces, leaves) of each predicate as a quadratic of
        time over every piece of these steps."""
        rows = (steps.stop - steps.start) * self.pieces
        out = tuple(np.zeros((rows, len(leaves))) for _ in range(4))
        for k, leaf in enumerate(leaves):
            out[0][:, k] = leaf.constant - self._off(leaf)
            for signal, weight in leaf.terms:
                at = slice(steps.start + signal.shift, steps.stop + signal.shift)
                if signal.role is Role.INPUT:
                    values = self.runs[signal.owner].inputs[at, signal.index]
                    out[0][:, k] += weight * np.repeat(values, self.pieces)
                    continue
                path = self.paths[signal.owner]
                on = slice(at.start * self.pieces, at.stop * self.pieces)
                for into, part in zip(out, (path.c0, path.c1, path.c2), strict=False):
                    into[:, k] += weight * part[on, signal.index]
                if path.error is not None:
                    out[3][:, k] += abs(weight) * path.error[on, signal.index]
            for into, off in zip(out, self._swayed(leaf, steps), strict=False):
                into[:, k] -= off
        return out[0], out[1], out[2], out[3]

    def _swayed(self, leaf: Linear, steps: slice) -> Quadratic:
        """What disturbances may take off a predicate, as quadratics of time."""
        rows: dict[tuple[str, int], Array] = {}
        for signal, weight in leaf.terms:
            path = self.paths[signal.owner]
            if path.sways:
                states, inputs = self.runs[signal.owner].states, self.runs[signal.owner].inputs
                width = states.shape[1] + inputs.shape[1]
                row = rows.setdefault((signal.owner, signal.shift), np.zeros((1, width)))
                behind = 0 if signal.role is Role.STATE else states.shape[1]
                row[0, behind + signal.index] += weight
        off = [np.zeros((steps.stop - steps.start) * self.pieces) for _ in range(3)]
        for (owner, shift), row in rows.items():
            on = slice(*(self.pieces * (end + shift) for end in (steps.start, steps.stop)))
            for into, part in zip(off, self.paths[owner].swayed(row), strict=True):
                into += part[on, 0]
        return off[0], off[1], off[2]

    def _off(self, leaf: Linear) -> float:
        """What a predicate may be less for agents that are anywhere in their discs."""
        lengths: dict[tuple[str, int], float] = {}
        for signal, weight in leaf.terms:
            if signal.owner in self.radii and signal.role is Role.STATE:
                key = signal.owner, signal.shift
                lengths[key] = hypot(lengths.get(key, 0.0), weight)
        return sum(self.radii[owner] * length for (owner, _), length in lengths.items())


def _leaves(node: Node) -> Iterator[Linear]:
    """The distinct predicates of a condition."""
    seen: dict[Linear, None] = {}
    todo = [node]
    while todo:
        part = todo.pop()
        if isinstance(part, Linear):
            seen[part] = None
        todo.extend(part.children)
    return iter(seen)


def _combine(node: Node, index: Mapping[Linear, int]) -> Combine:
    """The condition as a function of its predicates' values (.., leaves)."""
    match node:
        case Linear():
            k = index[node]
            return lambda q: np.asarray(q[..., k])
        case Const(value=value):
            level = np.inf if value else -np.inf
            return lambda q: np.full(q.shape[:-1], level)
        case And(args=args) | Or(args=args):
            parts = [_combine(arg, index) for arg in args]
            join: Callable[[list[Array]], Array] = (
                np.minimum.reduce if isinstance(node, And) else np.maximum.reduce
            )
            return lambda q: np.asarray(join([part(q) for part in parts]))
    raise TypeError(f"{type(node).__name__} in a swept condition")
