"""Runs to follow: exact dynamic programming of one agent on a lattice of its controls.

States of the lattice (`lattice.py`) carry a bit for each disjunction that ranges over time
(eventually, until): with last(i) the last step that alternative i speaks of,

    bit set at step t                where some i with last(i) = t holds at t,
    bit not yet set after step t     only where all i with last(i) > t agree that t is allowed,

and what is asserted at one step (free space, stepping stones) rules out positions of that step.
Predicates may be missed by a part of the lattice's spacing, and controls kept below their bounds,
so a run is only a reference: the search of `dive.py` decides what it is worth. What speaks of
several agents or of rates is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stlc.analysis.goals import Level
from stlc.analysis.ranges import Ranges
from stlc.analysis.stages import LevelOf, single_place
from stlc.arrays import Bools, Floats
from stlc.ir.nodes import And, Linear, Node, Or, Role
from stlc.ir.rewrite import conjuncts
from stlc.mission import Agent
from stlc.solve.heuristics.lattice import Axis, axis_lattice, moved, origins

if TYPE_CHECKING:
    from stlc.milp.compile import Compiled

_MOST = ((2, 10_000_000), (1, 60_000_000))  # parts of a control, lattice states over all steps
_MOST_BITS = 6
_LESS = 0.99
_LATTICES = ((1.0, 0.0), (0.85, 0.3), (0.9, 0.5), (0.65, 0.4), (0.75, 0.5))
"""Share of the controls; share of the spacing by which predicates may be missed. Exact first."""


@dataclass(frozen=True, slots=True, eq=False)
class Witness:
    """A disjunction over time: for each alternative, its last step and its parts at each step."""

    last: tuple[int, ...]
    parts: tuple[Mapping[int, frozenset[Node]], ...]

    @staticmethod
    def of(alternatives: Iterable[Node], agent: str) -> Witness | None:
        """None where they do not differ in time, or one says nothing of the agent."""
        parts = tuple(parts_by_step(a, agent) for a in alternatives)
        if not all(parts):
            return None
        last = tuple(max(p) for p in parts)
        return Witness(last, parts) if len(set(last)) > 1 else None

    def at(self, step: int) -> list[frozenset[Node]]:
        """What the alternatives that end at a step ask of it."""
        return [p[step] for end, p in zip(self.last, self.parts, strict=True) if end == step]

    def until(self, step: int) -> frozenset[Node]:
        """What all alternatives that end later ask of a step."""
        later = [p.get(step, frozenset()) for e, p in zip(self.last, self.parts, strict=True)
                 if e > step]  # fmt: skip
        return frozenset.intersection(*later) if later else frozenset()


def parts_by_step(root: Node, agent: str) -> dict[int, frozenset[Node]]:
    """Conjuncts of a formula that speak of an agent's states at one step."""
    found: dict[int, set[Node]] = {}
    todo = [root]
    while todo:
        node = todo.pop()
        if isinstance(node, And):
            todo.extend(node.args)
            continue
        place = single_place(node) if isinstance(node, Linear | Or) else None
        if place is not None and place[0] == agent:
            found.setdefault(place[1], set()).add(node)
    return {step: frozenset(nodes) for step, nodes in found.items()}


def reference_points(compiled: Compiled, level_of: Callable[[Level], LevelOf]) -> Iterator[Floats]:
    """How much each column (n,) is preferred by runs of lattices, exact runs first: 1 for the
    alternative of a disjunction that holds best on the run, less for the others."""
    for tight, miss in _LATTICES:
        runs = _lattice_runs(compiled, level_of, tight, miss)
        if runs is None:
            continue
        preference = np.zeros(compiled.model.columns)
        for one in compiled.layout.encoded:
            for _, pairs in one.choices:
                values = np.array([robustness(part, runs) for part, _ in pairs])
                if np.isfinite(values.max(initial=-np.inf)):
                    columns = [column for _, column in pairs]
                    preference[columns] = _LESS / (1.0 + values.max() - values)
                    preference[columns[int(values.argmax())]] = 1.0  # one alone where several tie
        yield preference


def _lattice_runs(
    compiled: Compiled, level_of: Callable[[Level], LevelOf], tight: float, miss: float
) -> dict[str, Floats] | None:
    """A run of every agent alone; None where one has none."""
    runs = {}
    for name, agent in compiled.mission.agents.items():
        asserted: dict[int, list[tuple[Node, LevelOf]]] = {}
        witnesses: list[tuple[Witness, LevelOf]] = []
        for one in compiled.layout.encoded:
            level = level_of(one.level)
            for step, nodes in parts_by_step(one.formula, name).items():
                asserted.setdefault(step, []).extend((n, level) for n in nodes)
            top = conjuncts(one.formula)
            for node in top:
                found = Witness.of(node.args, name) if isinstance(node, Or) else None
                if found is not None:
                    witnesses.append((found, level))
        run = find_run(agent, compiled.ranges[name], asserted, witnesses, miss, tight)
        if run is None:
            return None
        runs[name] = run
    return runs


def find_run(
    agent: Agent,
    ranges: Ranges,
    asserted: Mapping[int, Sequence[tuple[Node, LevelOf]]],
    witnesses: Sequence[tuple[Witness, LevelOf]],
    miss: float,
    tight: float,
) -> Floats | None:
    """States (T+1, n) of a lattice run, or None where there is none (or no such lattice).

    `asserted[t]` must hold at step t, one alternative of each witness must hold; predicates may be
    missed by `miss` times the lattice's spacing.
    """
    if len(witnesses) > _MOST_BITS:
        return None
    steps = len(ranges.input_lower)
    for parts, most in _MOST:
        axes = [axis_lattice(agent, ranges, k, parts, tight) for k in range(2)]
        x, y = axes
        if x is None or y is None:
            return None
        size = len(x.points) * len(x.rates) * len(y.points) * len(y.rates)
        if size * (steps + 1) << len(witnesses) <= most:
            return _Lattice(agent, ranges, (x, y), asserted, witnesses, miss).run()
    return None


@dataclass(frozen=True, slots=True, eq=False)
class _Lattice:
    agent: Agent
    ranges: Ranges
    axes: tuple[Axis, Axis]
    asserted: Mapping[int, Sequence[tuple[Node, LevelOf]]]
    witnesses: Sequence[tuple[Witness, LevelOf]]
    miss: float

    def run(self) -> Floats | None:
        """Forward over all steps, then back along one run."""
        x, y = self.axes
        steps, bits = len(self.ranges.input_lower), len(self.witnesses)
        sizes = [len(v) for g in self.axes for v in (g.points, g.rates)]
        f = np.zeros((1 << bits, *sizes), bool)
        f[(0, *x.start, *y.start)] = True
        hits = [self._hits(t) for t in range(steps + 1)]
        self._settle(f, 0, hits[0])
        runs = [f]
        for t in range(1, steps + 1):
            f = moved(moved(runs[-1], x, 1), y, 3)
            f &= self._allowed(t)[None]
            self._settle(f, t, hits[t])
            if not f.any():
                return None
            runs.append(f)
        ends = np.argwhere(runs[-1][-1])
        if not len(ends):
            return None
        return self._trace(runs, hits, tuple(int(i) for i in ends[len(ends) // 2]))

    def _settle(self, f: Bools, t: int, hits: Sequence[Bools]) -> None:
        """Set bits where a witness holds; drop what must not go on without."""
        for g, hit in enumerate(hits):
            pairs = f.reshape(-1, 2, 1 << g, *f.shape[1:])
            pairs[:, 1] |= pairs[:, 0] & hit[:, None, :, None]
        for g, (witness, level) in enumerate(self.witnesses):
            fine = self._all(witness.until(t), level)
            if not fine.all():
                f.reshape(-1, 2, 1 << g, *f.shape[1:])[:, 0] &= fine[:, None, :, None]

    def _hits(self, t: int) -> list[Bools]:
        found = []
        for witness, level in self.witnesses:
            hit = np.zeros(tuple(len(a.points) for a in self.axes), bool)
            for nodes in witness.at(t):
                hit |= self._all(nodes, level)
            found.append(hit)
        return found

    def _allowed(self, t: int) -> Bools:
        """(nx, kx, ny, ky): within the ranges, and what is asserted holds."""
        inside = []
        for axis in self.axes:
            for column, values in ((axis.position, axis.points), (axis.rate, axis.rates)):
                low, high = self.ranges.state_lower[t, column], self.ranges.state_upper[t, column]
                room = self.miss * self._spacing(axis) + 1e-6 if values is axis.points else 1e-6
                inside.append((values >= low - room) & (values <= high + room))
        fine = np.ones(tuple(len(a.points) for a in self.axes), bool)
        for node, level in self.asserted.get(t, ()):
            fine &= self._holds(node, level)
        a, b, c, d = inside
        room_for = (a[:, None] & b)[:, :, None, None] & (c[:, None] & d)[None, None]
        return np.asarray(room_for & fine[:, None, :, None])

    def _spacing(self, axis: Axis) -> float:
        return float(axis.points[1] - axis.points[0]) if len(axis.points) > 1 else 0.0

    def _all(self, nodes: Iterable[Node], level: LevelOf) -> Bools:
        fine = np.ones(tuple(len(a.points) for a in self.axes), bool)
        for node in nodes:
            fine &= self._holds(node, level)
        return fine

    def _holds(self, node: Node, level: LevelOf) -> Bools:
        """(nx, ny): the formula at its level, missed by little at most."""
        match node:
            case And(args=args):
                return np.asarray(np.logical_and.reduce([self._holds(a, level) for a in args]))
            case Or(args=args):
                return np.asarray(np.logical_or.reduce([self._holds(a, level) for a in args]))
            case Linear():
                return self._predicate(node, level)
        raise TypeError(f"{type(node).__name__} at one step")

    def _predicate(self, node: Linear, level: LevelOf) -> Bools:
        """Points (x, y) at which a predicate reaches its level, but for what lattices miss; all of
        them where it is about more than the position."""
        value = np.full(tuple(len(a.points) for a in self.axes), node.constant)
        room = 1e-6
        for signal, weight in node.terms:
            for k, axis in enumerate(self.axes):
                if axis.position == signal.index:
                    value += weight * (axis.points[:, None] if k == 0 else axis.points)
                    room += abs(weight) * self.miss * self._spacing(axis)
                    break
            else:
                return np.ones(value.shape, bool)
        return np.asarray(value >= level(node.unit) - room)

    def _trace(
        self, runs: Sequence[Bools], hits: Sequence[Sequence[Bools]], end: tuple[int, ...]
    ) -> Floats:
        """The states of one run that ends in lattice state `end` with every bit set."""
        x, y = self.axes
        out = np.tile(self.agent.start.astype(float), (len(runs), 1))
        mask, (i, a, j, b) = len(runs[-1]) - 1, end
        for t in range(len(runs) - 1, -1, -1):
            for axis, point, rate in ((x, i, a), (y, j, b)):
                out[t, axis.position] = axis.points[point]
                out[t, axis.rate] = axis.rates[rate]
            if t:
                mask, i, a, j, b = self._before(runs[t - 1], hits[t], (mask, i, a, j, b))
        return out

    def _before(
        self, earlier: Bools, hits: Sequence[Bools], state: tuple[int, int, int, int, int]
    ) -> tuple[int, int, int, int, int]:
        """A state (goals met, x, rate, y, rate) one step earlier from which this one was
        reached."""
        mask, i, a, j, b = state
        new = sum(1 << g for g, hit in enumerate(hits) if mask >> g & 1 and hit[i, j])
        for before in (m for m in range(mask, -1, -1) if m | (mask & new) == mask):
            for ra, pi in origins(self.axes[0], i, a):
                for rb, pj in origins(self.axes[1], j, b):
                    if earlier[before, pi, ra, pj, rb]:
                        return before, pi, ra, pj, rb
        raise AssertionError("every lattice state after the first has one before it")


def robustness(node: Node, states: Mapping[str, Floats]) -> float:
    """Of an unrolled formula on runs (T+1, n); -inf for what is not about states."""
    match node:
        case And(args=args):
            return min((robustness(a, states) for a in args), default=np.inf)
        case Or(args=args):
            return max((robustness(a, states) for a in args), default=-np.inf)
        case Linear(terms=terms) if all(s.role is Role.STATE for s, _ in terms):
            return float(
                node.constant + sum(v * states[s.owner][s.shift, s.index] for s, v in terms)
            )
    return -np.inf
