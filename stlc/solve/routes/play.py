"""A bound on the effort of agents that move by their inputs alone, over space, time and progress.

Let x(t+1) = x(t) + g u(t) along each axis, and follow x by a point y of a set of lines, one of
them through x(0): while x is strictly between the lines beside y, it stays; else it moves towards x
to the last line before it (the play operator of hysteresis: Krasnosel'skii and Pokrovskii, Systems
with Hysteresis, 1989). Each move of y by d shortens |x - y| by d, so

    x strictly between the lines beside y,    sum |y(t+1) - y(t)|  <=  sum |x(t+1) - x(t)|.

So whatever run fulfils the mission, some run of y costs no more, and x is somewhere in the open
boxes around it. Formulas are monotone: the cheapest run of y under predicates that hold where they
may hold bounds the effort of all plans, and no state leaks from cell to cell. With lines through
the edges of regions and obstacles it sees these as they are (Hanan's grid). It is found step by
step over (point, progress); what cannot end below the cost of a known plan is dropped.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.ir.nodes import Node
from stlc.milp.compile import Compiled
from stlc.mission import Agent, Mission
from stlc.solve.routes.agenda import Agenda
from stlc.solve.routes.loose import EDGE, Grid, Loosened, Spread, lines_of, weight_of
from stlc.solve.routes.moves import LevelOf, Moves
from stlc.solve.routes.progress import Open, Progress

_ROOM = 1e-3  # m beyond the outermost lines: the ranges end there
MOST_MOVES = 3_000_000  # grid points times moves: what a step judges
MOST_STATES = 200_000_000  # states times moves at a step


class Layer(NamedTuple):
    """States (k,) at a step: index in `opens`, cell, cost so far."""

    opens: Sequence[Open]
    where: Ints
    which: Ints
    cost: Floats


@dataclass(slots=True, eq=False)
class Play:
    """The grid of one agent: `points` (N, 2) on `lines`, `ends` (2, N, 2) of the open box that x
    is in while y is there, `moves` (C, 2) in lines, prices (2,) a metre.

    `most`: runs at that cost or above are of no interest.
    """

    mission: Mission
    agent: Agent
    progress: Progress
    judge: Loosened
    lower: Floats  # (T+1, 2) ranges
    upper: Floats
    lines: tuple[Floats, Floats]
    most: float
    over: Callable[[], bool]
    shape: tuple[int, int] = field(init=False)
    points: Floats = field(init=False)
    ends: Floats = field(init=False)
    fastest: Floats = field(init=False)
    moves: Ints = field(init=False)
    prices: Floats = field(init=False)
    places: Grid = field(init=False)
    layers: list[Layer] = field(default_factory=list)  # of the last `bound`, by step

    def __post_init__(self) -> None:
        self.shape = (len(self.lines[0]), len(self.lines[1]))
        self.points = _crossed(self.lines)
        low = [np.append(g[0] - _ROOM, g[:-1]) for g in self.lines]
        high = [np.append(g[1:], g[-1] + _ROOM) for g in self.lines]
        self.ends = np.stack([_crossed((low[0], low[1])), _crossed((high[0], high[1]))])
        gains = np.abs(np.diag(self.agent.dynamics.B))
        push = np.maximum(np.abs(self.agent.input_lower), np.abs(self.agent.input_upper))
        self.fastest = push * gains
        most = [
            int((np.searchsorted(g, h + d + EDGE) - np.arange(len(g))).max(initial=1))
            for g, h, d in zip(self.lines, high, self.fastest, strict=True)
        ]
        back = [
            int((np.arange(len(g)) - np.searchsorted(g, h - d - EDGE) + 1).max(initial=1))
            for g, h, d in zip(self.lines, low, self.fastest, strict=True)
        ]
        axes = [np.arange(-b, m + 1) for b, m in zip(back, most, strict=True)]
        self.moves = _crossed((axes[0], axes[1])).astype(np.int64)
        weight = weight_of(self.mission, self.agent.name) or 0.0
        self.prices = weight * self.agent.effort_input / gains
        self.places = Grid(
            self.progress, self.judge, self.agent, self.points[0], np.ones(2), self.shape,
            np.ones(len(self.points), bool), lines=self.lines, ends=self.ends, prices=self.prices,
        )  # fmt: skip

    @property
    def widest(self) -> float:
        """The widest gap between lines [m]."""
        return float(max(np.diff(line).max(initial=0.0) for line in self.lines))

    def size(self) -> int:
        """Moves that a step has to judge."""
        return len(self.points) * len(self.moves)

    def bound(self) -> float | None:
        """The least cost of a run of the grid, `most` where all cost that much; None if not
        found out."""
        start = int(np.abs(self.points - self.agent.start).sum(axis=1).argmin())
        label = self._judged(0, np.array([start]), np.array([start]))
        after = self.progress.after(frozenset(), 0, label[1][0], {}) if label[0].all() else None
        if after is None:
            return self.most
        layer = Layer([after], np.array([start]), np.zeros(1, np.int64), np.zeros(1))
        self.layers = [layer]
        for t in range(1, len(self.lower)):
            found = None if self.over() else self._step(t, layer)
            if found is None:
                return None
            layer = found
            self.layers.append(layer)
            if not len(layer.where):
                return self.most
        return float(min(layer.cost[self.finished()].min(initial=self.most), self.most))

    def finished(self) -> Bools:
        """The states of the last layer that leave nothing open."""
        done = np.array([not open_ for open_ in self.layers[-1].opens], bool)
        return np.asarray(done[self.layers[-1].which])

    def _step(self, t: int, layer: Layer) -> Layer | None:
        """All moves of step t: the cheapest cost of each open formula and cell. None where there
        would be too many states."""
        moves, (opens, where, which, cost) = self.moves, layer
        if len(where) * len(moves) > MOST_STATES:
            return None
        origins, row = np.unique(where, return_inverse=True)
        pairs = np.repeat(origins, len(moves)), np.tile(moves, (len(origins), 1))
        fine, labels, label = self.classes(t, *pairs)
        shape = (len(origins), len(moves))
        fine, label = fine.reshape(shape), label.reshape(shape)
        met = np.zeros((len(opens), len(labels)), bool)
        for p in range(len(opens)):
            here = row[which == p]
            met[p, label[here][fine[here]]] = True
        table, after = self._table(t, opens, labels, met)
        best: dict[int, Floats] = {}
        shift = moves @ np.array([self.shape[1], 1])
        ends = np.clip(origins[:, None] + shift, 0, len(self.points) - 1)
        price = np.abs(self.points[ends] - self.points[origins][:, None]) @ self.prices
        for p in range(len(opens)):
            own = np.flatnonzero(which == p)
            here = row[own]
            next_ = np.where(fine[here], table[p][label[here]], -1)
            value = cost[own, None] + price[here]
            next_[value >= self.most] = -1
            target = where[own, None] + shift
            for q in np.unique(next_[next_ >= 0]).tolist():
                mask = next_ == q
                least = best.setdefault(q, np.full(len(self.points), np.inf))
                np.minimum.at(least, target[mask], value[mask])
        return self._kept(t, after, best)

    def _kept(self, t: int, opens: list[Open], best: dict[int, Floats]) -> Layer:
        """The states after a step that may still end below `most`."""
        wheres, whiches, costs = [], [], []
        due = np.isfinite(Agenda.of(self.places, opens, t).due)
        numbers = sorted(best)
        table = np.array([best[q] for q in numbers]).reshape(len(numbers), len(self.points))
        for q, row in zip(numbers, table, strict=True):
            kept = np.flatnonzero(np.isfinite(row))
            dear = row[kept] + self._to_go(due[q], kept) >= self.most
            row[kept[dear]] = np.inf
        eased = self.progress.eased([opens[q] for q in numbers])
        for k, (q, row) in enumerate(zip(numbers, table, strict=True)):
            rivals = np.flatnonzero(eased[:, k])
            better = table[rivals[rivals != k]].min(axis=0, initial=np.inf)
            row[row >= better] = np.inf
            kept = np.flatnonzero(np.isfinite(row))
            wheres.append(kept)
            whiches.append(np.full(len(kept), q))
            costs.append(row[kept])
        none = np.empty(0, np.int64)
        where, which = np.concatenate([none, *wheres]), np.concatenate([none, *whiches])
        return Layer(opens, where, which, np.concatenate([np.empty(0), *costs]))

    def _to_go(self, due: Bools, where: Ints) -> Floats:
        """What a way through all places that are due costs at the least (k,)."""
        places = np.flatnonzero(due).tolist()
        if not places:
            return np.zeros(len(where))
        first = np.array([self.places.ways[k][where] for k in places])
        return np.asarray((first + self.places.tours(places)[:, None]).min(axis=0))

    def classes(
        self, t: int, where: Ints, moves: Ints
    ) -> tuple[Bools, list[dict[int, bool]], Ints]:
        """Which moves may be (k,), what holds after them by class, and the class of each."""
        fine, target = self._inside(t, where, moves)
        atoms = self.progress.atoms_at.get(t, [])
        label = np.zeros(len(where), np.int64)
        own = np.flatnonzero(fine)
        good, holds = self._judge(t, where[own], target[own])
        fine[own[~good]] = False
        if not len(own):
            return fine, [dict.fromkeys(atoms, False)], label
        packed = np.packbits(holds, axis=1) if atoms else np.zeros((len(own), 1), np.uint8)
        keys = np.ascontiguousarray(packed).view(f"V{packed.shape[1]}").ravel()
        _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
        label[own] = inverse.ravel()
        return fine, [dict(zip(atoms, holds[k].tolist(), strict=True)) for k in first], label

    def _inside(self, t: int, where: Ints, moves: Ints) -> tuple[Bools, Ints]:
        """Moves that end on the grid, within the ranges, and the points where they do."""
        at = np.column_stack(np.divmod(where, self.shape[1])) + moves
        fine = ((at >= 0) & (at < np.array(self.shape))).all(axis=1)
        target = np.where(fine, at[:, 0] * self.shape[1] + at[:, 1], where)
        fine &= (self.ends[1][target] >= self.lower[t] - EDGE).all(axis=1)
        fine &= (self.ends[0][target] <= self.upper[t] + EDGE).all(axis=1)
        least, most = self._ways(where, target)
        fine &= ((least <= self.fastest + EDGE) & (most >= -self.fastest - EDGE)).all(axis=1)
        return np.asarray(fine), target

    def _ways(self, where: Ints, target: Ints) -> tuple[Floats, Floats]:
        """Least and greatest way of x (k, 2) while y moves: it ends beyond the line y moves to."""
        low, high = self.ends
        here, there = self.points[where], self.points[target]
        least = np.where(there > here, there, low[target]) - high[where]
        most = np.where(there < here, there, high[target]) - low[where]
        return least, most

    def _judge(self, t: int, where: Ints, target: Ints) -> tuple[Bools, Bools]:
        """Whether what is asserted holds (k,), and the other atoms (k, atoms)."""
        (low, high), name = self.ends, self.agent.name
        ways = [np.clip(w, -self.fastest, self.fastest) for w in self._ways(where, target)]
        inputs = np.sort(np.array(ways) / np.diag(self.agent.dynamics.B), axis=0)
        inputs += np.array([-EDGE, EDGE])[:, None, None]  # its ends may be reached
        below = Moves(name, t, low[where], inputs[0], low[target])
        both = Spread(name, t, high[where], inputs[1], high[target], below)
        memos: dict[int, dict[Node, Bools]] = {}

        def judged(number: int) -> Bools:
            atom = self.progress.atoms[number]
            memo = memos.setdefault(atom.source, {})
            return self.judge.holds(atom.node, atom.source, both, memo)

        good = np.ones(len(where), bool)
        for number in self.progress.asserted.get(t, ()):
            good &= judged(number)
        atoms = self.progress.atoms_at.get(t, [])
        holds = np.zeros((len(where), len(atoms)), bool)
        for k, number in enumerate(atoms):
            holds[:, k] = judged(number)
        return good, holds

    def _judged(self, t: int, where: Ints, target: Ints) -> tuple[Bools, list[dict[int, bool]]]:
        good, holds = self._judge(t, where, target)
        atoms = self.progress.atoms_at.get(t, [])
        return good, [dict(zip(atoms, row.tolist(), strict=True)) for row in holds]

    def _table(
        self, t: int, opens: Sequence[Open], labels: Sequence[dict[int, bool]], met: Bools
    ) -> tuple[Ints, list[Open]]:
        """Progress after a step by (progress before, class) for those that are `met`, -1 where
        there is none."""
        made: dict[Open, int] = {}
        table = np.full((len(opens), len(labels)), -1)
        for k, label in enumerate(labels):
            memo: dict[int, int] = {}
            for p in np.flatnonzero(met[:, k]).tolist():
                after = self.progress.after(opens[p], t, label, memo)
                if after is not None:
                    table[p, k] = made.setdefault(after, len(made))
        return table, list(made)


def _crossed(axes: tuple[Floats, Floats] | tuple[Ints, Ints]) -> Floats:
    """All pairs (N, 2), the second axis fastest."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 2)


def play_of(
    compiled: Compiled, name: str, progress: Progress, levels: Sequence[LevelOf], cut: int,
    most: float, over: Callable[[], bool],
) -> Play:  # fmt: skip
    """The grid of one agent: no lines are further apart than its fastest move, cut by `cut`."""
    agent, ranges = compiled.mission.agents[name], compiled.ranges[name]
    push = np.maximum(np.abs(agent.input_lower), np.abs(agent.input_upper))
    spacing = float((push * np.abs(np.diag(agent.dynamics.B))).max()) / cut
    lines = lines_of(compiled, name, levels, spacing)
    judge = Loosened(compiled.mission, compiled.channels, levels)
    return Play(
        compiled.mission, agent, progress, judge, ranges.state_lower, ranges.state_upper, lines,
        most, over,
    )  # fmt: skip
