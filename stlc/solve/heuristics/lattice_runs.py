"""Runs to follow: exact dynamic programming of one agent on a lattice of its controls.

States of the lattice (`lattice.py`) carry a bit for each disjunction that ranges over time
(eventually, until), and all sets of bits that one position and rate is reached with are one word,
whose bit m stands for the set with binary number m. With last(i) the last step that alternative i
speaks of,

    bit set at step t                where some i with last(i) = t holds at t,
    bit not yet set after step t     only where all i with last(i) > t agree that t is allowed,

and what is asserted at one step (free space, stepping stones) rules out positions of that step.
Predicates may be missed by a part of the lattice's spacing, and controls kept below their bounds,
so a run is only a reference: the search of `dive.py` decides what it is worth. What speaks of
several agents or of rates is left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stlc.analysis.ranges import Ranges
from stlc.analysis.stages import LevelOf, single_place
from stlc.arrays import Bools, Floats
from stlc.ir.nodes import And, Linear, Node, Or
from stlc.mission import Agent
from stlc.solve.heuristics.lattice import Axis, Words, axis_lattice, moved, origins

_MOST = 60_000_000  # bytes of a lattice over all steps; the door puzzle of three doors has 43
# million in half controls, looked through in 0.5 CPU s, and no run in whole ones
_PARTS = (2, 1)  # of a control
_MOST_BITS = 6  # of a word of 64


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


@dataclass(frozen=True, slots=True, eq=False)
class LatticeRun:
    """States (T+1, n), and by how much they may miss a predicate of a unit normal."""

    states: Floats
    room: float


def find_run(
    agent: Agent,
    ranges: Ranges,
    asserted: Mapping[int, Sequence[tuple[Node, LevelOf]]],
    witnesses: Sequence[tuple[Witness, LevelOf]],
    miss: float,
    tight: float,
) -> LatticeRun | None:
    """A lattice run, or None where there is none (or no such lattice).

    `asserted[t]` must hold at step t, one alternative of each witness must hold; predicates may be
    missed by `miss` times the lattice's spacing.
    """
    if len(witnesses) > _MOST_BITS:
        return None
    steps = len(ranges.input_lower)
    for parts in _PARTS:
        axes = [axis_lattice(agent, ranges, k, parts, tight) for k in range(2)]
        x, y = axes
        if x is None or y is None:
            return None
        size = len(x.points) * len(x.rates) * len(y.points) * len(y.rates)
        if size * (steps + 1) * _word(len(witnesses)).itemsize <= _MOST:
            lattice = _Lattice(agent, ranges, (x, y), asserted, witnesses, miss)
            states = lattice.run()
            return None if states is None else LatticeRun(states, lattice.room)
    return None


def _word(bits: int) -> np.dtype[np.unsignedinteger[Any]]:
    """The least word with a bit for every set of so many bits."""
    return np.dtype(f"u{max((1 << bits) // 8, 1)}")


def _without(bit: int, bits: int) -> int:
    """The word of all sets that one bit isn't in."""
    return sum(1 << m for m in range(1 << bits) if not m >> bit & 1)


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
        f = np.zeros(sizes, _word(bits))
        f[(*x.start, *y.start)] = 1
        hits = [self._hits(t) for t in range(steps + 1)]
        self._settle(f, 0, hits[0])
        runs = [f]
        for t in range(1, steps + 1):
            f = moved(moved(runs[-1], x, 0), y, 2)
            f[~self._allowed(t)] = 0
            self._settle(f, t, hits[t])
            if not f.any():
                return None
            runs.append(f)
        ends = np.argwhere(_has(runs[-1], (1 << bits) - 1))
        if not len(ends):
            return None
        return self._trace(runs, hits, tuple(int(i) for i in ends[len(ends) // 2]))

    def _settle(self, f: Words, t: int, hits: Sequence[Bools]) -> None:
        """Set bits where a witness holds; drop what must not go on without."""
        bits, word = len(self.witnesses), f.dtype.type
        for g, hit in enumerate(hits):
            if hit.any():
                where = np.broadcast_to(hit[:, None, :, None], f.shape)
                f[where] |= (f[where] & word(_without(g, bits))) << word(1 << g)
        for g, (witness, level) in enumerate(self.witnesses):
            fine = self._all(witness.until(t), level)
            if not fine.all():
                where = np.broadcast_to(~fine[:, None, :, None], f.shape)
                f[where] &= word(_without(g, bits) << (1 << g))

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

    @property
    def room(self) -> float:
        """By how much a run may miss a predicate of a unit normal."""
        return math.sqrt(2.0) * self.miss * max(self._spacing(axis) for axis in self.axes)

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
        self, runs: Sequence[Words], hits: Sequence[Sequence[Bools]], end: tuple[int, ...]
    ) -> Floats:
        """The states of one run that ends in lattice state `end` with every bit set."""
        x, y = self.axes
        out = np.tile(self.agent.start.astype(float), (len(runs), 1))
        mask, (i, a, j, b) = (1 << len(self.witnesses)) - 1, end
        for t in range(len(runs) - 1, -1, -1):
            for axis, point, rate in ((x, i, a), (y, j, b)):
                out[t, axis.position] = axis.points[point]
                out[t, axis.rate] = axis.rates[rate]
            if t:
                mask, i, a, j, b = self._before(runs[t - 1], hits[t], (mask, i, a, j, b))
        return out

    def _before(
        self, earlier: Words, hits: Sequence[Bools], state: tuple[int, int, int, int, int]
    ) -> tuple[int, int, int, int, int]:
        """A state (goals met, x, rate, y, rate) one step earlier from which this one was
        reached."""
        mask, i, a, j, b = state
        new = sum(1 << g for g, hit in enumerate(hits) if mask >> g & 1 and hit[i, j])
        for before in (m for m in range(mask, -1, -1) if m | (mask & new) == mask):
            for ra, pi in origins(self.axes[0], i, a):
                for rb, pj in origins(self.axes[1], j, b):
                    if _has(earlier[pi, ra, pj, rb], before):
                        return before, pi, ra, pj, rb
        raise AssertionError("every lattice state after the first has one before it")


def _has(words: Words, mask: int) -> Bools:
    """Whether each word has the set of bits with that number."""
    return np.asarray(words >> words.dtype.type(mask) & words.dtype.type(1) == 1)
