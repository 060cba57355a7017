"""A mission as the boxes of `axis_boxes.py` see it: what may hold in each, what it costs at least.

Predicates are taken at their best point of a box, links at the best cell that a box touches; what
says nothing of the position at its own step holds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import NamedTuple

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.ir.nodes import And, Const, Linear, Link, Node, Not, Or, Role, walk
from stlc.milp.compile import Compiled
from stlc.mission import Agent, Mission, ObjectiveTerm, TermKind
from stlc.scales import static_range, steps_of
from stlc.solve.relaxation.problem import Body, Singles
from stlc.solve.routes.axis_boxes import AxisBoxes, Span
from stlc.solve.routes.moves import Judge, LevelOf, Moves
from stlc.solve.routes.progress import Progress

_MISSED = 1e-6  # what solver and verifier let predicates be missed by


class Label(NamedTuple):
    """`of` (nx, ny): the class of each position, -1 where none may be; by class what holds, and
    the positions (of both axes) that it is within."""

    of: Ints
    holds: list[dict[int, bool]]
    spans: list[tuple[Span, Span]]


@dataclass(slots=True, eq=False)
class View:
    """One agent's boxes `x` and `y` against a mission's formulas, at their `levels`."""

    compiled: Compiled
    agent: Agent
    body: Body
    progress: Progress
    levels: Sequence[LevelOf]
    x: AxisBoxes
    y: AxisBoxes
    _judge: Judge = field(init=False)
    _labels: dict[int, Label] = field(default_factory=dict)
    _going: dict[int, Singles] = field(default_factory=dict)
    _memos: dict[int, list[dict[int, int]]] = field(default_factory=dict)
    _tables: dict[int, Floats] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._judge = Judge(self.mission, self.compiled.channels, self.levels)

    @property
    def mission(self) -> Mission:
        """What is looked at."""
        return self.compiled.mission

    @property
    def shape(self) -> tuple[int, int]:
        """Positions along both axes."""
        return len(self.x.p), len(self.y.p)

    def label(self, t: int) -> Label:
        """What may hold at step t."""
        if t not in self._labels:
            self._labels[t] = self._labelled(t)
        return self._labels[t]

    def memo(self, t: int) -> list[dict[int, int]]:
        """For `Progress.after` at step t, by class."""
        return self._memos.setdefault(t, [{} for _ in self.label(t).holds])

    @property
    def sharp(self) -> bool:
        """Whether finer boxes see the same: predicates end at faces along the axes."""
        where = {axis.state for axis in self.body.axes}
        return all(
            sum(signal.index in where for signal, _ in node.terms) < 2
            for number, atom in self.progress.atoms.items()
            if number not in self.progress.asserted.get(atom.step, ())
            for node in walk(atom.node) if isinstance(node, Linear)
        )  # fmt: skip

    def _labelled(self, t: int) -> Label:
        """Classes of positions by what may hold there, where what is asserted may."""
        atoms, good = self.progress.atoms_at.get(t, []), self._within(t)
        for number in self.progress.asserted.get(t, ()):
            good &= self._atom(number, t)
        held = np.array([good, *(self._atom(number, t) for number in atoms)])[:, good].T
        classes, which = np.unique(held, axis=0, return_inverse=True)
        found = np.full(self.shape, -1)
        found[good] = which.ravel()
        spans = [_spanned(found == k) for k in range(len(classes))]
        holds = [dict(zip(atoms, row[1:].tolist(), strict=True)) for row in classes]
        return Label(found, holds, spans)

    def _within(self, t: int) -> Bools:
        """Positions that meet the ranges of a step."""
        x, y = (
            (boxes.p[:, 1] >= axis.box[t, 0] - _MISSED)
            & (boxes.p[:, 0] <= axis.box[t, 1] + _MISSED)
            for boxes, axis in zip((self.x, self.y), self.body.axes, strict=True)
        )
        return np.asarray(x[:, None] & y[None])

    def _atom(self, number: int, t: int) -> Bools:
        atom = self.progress.atoms[number]
        return self._may(atom.node, atom.source, t)

    def _may(self, node: Node, source: int, t: int) -> Bools:
        """Where a formula may hold at step t (nx, ny)."""
        match node:
            case And(args=args):
                return reduce(np.logical_and, [self._may(a, source, t) for a in args])
            case Or(args=args):
                return reduce(np.logical_or, [self._may(a, source, t) for a in args])
            case Const(value=value):
                return np.full(self.shape, value)
            case Linear():
                return self._linear(node, self.levels[source](node.unit), t)
            case Link() | Not():
                parts = [self._judge.holds(node, source, moves, {}) for moves in self._corners(t)]
                return reduce(np.logical_or, parts).reshape(self.shape)
        raise TypeError(f"{type(node).__name__} in an unrolled formula")

    def _linear(self, node: Linear, level: float, t: int) -> Bools:
        """Where a predicate may hold: everywhere if it speaks of more than the state at t."""
        value = np.full(self.shape, node.constant)
        ranges = self.compiled.ranges[self.agent.name]
        for signal, weight in node.terms:
            if signal.role is not Role.STATE or signal.shift != t:
                return np.ones(self.shape, bool)
            ends = ranges.state_lower[t, signal.index], ranges.state_upper[t, signal.index]
            best = np.array(max(weight * ends[0], weight * ends[1]))
            if signal.index == self.body.axes[0].state:
                best = weight * self.x.p[:, 1 if weight > 0 else 0][:, None]
            elif signal.index == self.body.axes[1].state:
                best = weight * self.y.p[:, 1 if weight > 0 else 0][None]
            value = value + best
        return np.asarray(value >= level - _MISSED)

    def _corners(self, t: int) -> Iterator[Moves]:
        """The agent at rest in the corners of all positions: faces of cells are thin boxes, whose
        corners are on both sides."""
        (nx, ny), none = self.shape, np.zeros((1, 0))
        for a in (0, 1):
            for b in (0, 1):
                states = np.zeros((nx * ny, len(self.agent.start)))
                states[:, self.body.axes[0].state] = np.repeat(self.x.p[:, a], ny)
                states[:, self.body.axes[1].state] = np.tile(self.y.p[:, b], nx)
                yield Moves(self.agent.name, t, none, none, states)

    def places(self, t: int) -> Floats:
        """What links cost in each position at step t at the least (nx, ny), infinite outside the
        cells."""
        found = np.zeros(self.shape)
        for k, term in enumerate(link_costs(self.mission)):
            if t in steps_of(self.mission, term)[0]:
                if k not in self._tables:
                    self._tables[k] = self._table(term)
                found = found + self._tables[k]
        return found

    def _table(self, term: ObjectiveTerm) -> Floats:
        """What a term costs at the least in each position."""
        assert term.channel is not None
        weight = term.weight / static_range(self.mission, term, self.compiled.channels)
        channel, least = self.mission.channels[term.channel], np.full(self.shape, np.inf)
        tables = [weight * self.compiled.channels.cost(channel.name, p) for p in term.pairs]
        for moves in self._corners(0):
            cells = self._judge.cells(channel, moves.after @ self._space().T)
            total = sum(table[cells] if table.ndim else table for table in tables)
            least = np.minimum(least, np.where(cells < 0, np.inf, total).reshape(self.shape))
        return least

    def _space(self) -> Floats:
        space = self.agent.dynamics.space
        assert space is not None
        return np.asarray(space)

    def going(self, t: int) -> Singles:
        """What rates cost at step t at the least (mx, my), infinite where both are too fast."""
        if t not in self._going:
            self._going[t] = self._rated(t)
        return self._going[t]

    def _rated(self, t: int) -> Singles:
        low, high = (np.stack(np.meshgrid(self.x.w[:, k], self.y.w[:, k], indexing="ij"), -1)
                     for k in (0, 1))  # fmt: skip
        prices = np.array([axis.rate_cost[t] for axis in self.body.axes])
        found = np.maximum(np.maximum(low, -high), 0.0) @ prices
        for *normal, most in self.body.faces:
            n = np.array(normal)
            found[np.minimum(n * low, n * high).sum(axis=-1) > most + _MISSED] = np.inf
        return np.asarray(found, np.float32)


def link_costs(mission: Mission) -> list[ObjectiveTerm]:
    """The links that cost."""
    return [t for t in mission.objective if t.kind is TermKind.LINK_COST and t.weight != 0]


def faces_of(
    compiled: Compiled, name: str, body: Body, levels: Sequence[LevelOf]
) -> tuple[set[float], set[float]]:
    """Where predicates on a position, and cells, end along both axes."""
    found: tuple[set[float], set[float]] = (set(), set())
    where = {axis.state: own for own, axis in zip(found, body.axes, strict=True)}
    for one, level in zip(compiled.layout.encoded, levels, strict=True):
        for node in walk(one.formula):
            if isinstance(node, Linear) and len(node.terms) == 1:
                ((signal, weight),) = node.terms
                own = where.get(signal.index) if signal.role is Role.STATE else None
                if own is not None and signal.owner == name:
                    own.add(round((level(node.unit) - node.constant) / weight, 9))
    for channel in compiled.mission.channels.values():
        grid = channel.partition.common_grid()[0]
        for edges, faces in zip(grid.edges or (), found, strict=False):
            faces.update(edges.tolist())
    return found


def _spanned(mask: Bools) -> tuple[Span, Span]:
    """The rows and columns of a mask's entries."""
    i, j = np.nonzero(mask)
    return (int(i.min()), int(i.max()) + 1), (int(j.min()), int(j.max()) + 1)
