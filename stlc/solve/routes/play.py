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
from stlc.milp.compile import Compiled
from stlc.solve.routes.agenda import Agenda
from stlc.solve.routes.board import Board
from stlc.solve.routes.grid_places import Grid
from stlc.solve.routes.loose import Loosened, lines_of, weight_of
from stlc.solve.routes.moves import LevelOf
from stlc.solve.routes.progress import Open, Progress

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
    """The search over a board; `most`: runs at that cost or above are of no interest."""

    board: Board
    most: float
    over: Callable[[], bool]
    places: Grid
    layers: list[Layer] = field(default_factory=list)  # of the last `bound`, by step

    @property
    def widest(self) -> float:
        """The widest gap between lines [m]."""
        return float(max(np.diff(line).max(initial=0.0) for line in self.board.lines))

    def size(self) -> int:
        """Moves that a step has to judge."""
        return len(self.board.points) * len(self.board.moves)

    def bound(self) -> float | None:
        """The least cost of a run of the grid, `most` where all cost that much; None if not
        found out."""
        board, progress = self.board, self.board.progress
        start = int(np.abs(board.points - board.agent.start).sum(axis=1).argmin())
        label = board.judged(0, np.array([start]), np.array([start]))
        after = progress.after(frozenset(), 0, label[1][0], {}) if label[0].all() else None
        if after is None:
            return self.most
        layer = Layer([after], np.array([start]), np.zeros(1, np.int64), np.zeros(1))
        self.layers = [layer]
        for t in range(1, len(board.lower)):
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
        board, (opens, where, which, cost) = self.board, layer
        if len(where) * len(board.moves) > MOST_STATES:
            return None
        origins, row = np.unique(where, return_inverse=True)
        fine, labels, label = board.around(t, origins)
        met = np.zeros((len(opens), len(labels)), bool)
        for p in range(len(opens)):
            here = row[which == p]
            met[p, label[here][fine[here]]] = True
        table, after = self._table(t, opens, labels, met)
        size = len(board.points)
        best = np.full(len(after) * size, np.inf)
        table, label = np.column_stack([table, np.full(len(table), -1)]), np.where(fine, label, -1)
        target = origins[:, None] + board.shifts
        price = board.way(origins[:, None], np.clip(target, 0, size - 1))
        for p in range(len(opens)):
            own = np.flatnonzero(which == p)
            here = row[own]
            next_, value = table[p][label[here]], cost[own, None] + price[here]
            may = (next_ >= 0) & (value < self.most)
            np.minimum.at(best, (next_ * size + target[here])[may], value[may])
        return self._kept(t, after, best.reshape(len(after), size))

    def _kept(self, t: int, opens: list[Open], table: Floats) -> Layer:
        """The states after a step that may still end below `most`: costs (opens, points)."""
        wheres, whiches, costs = [], [], []
        due = np.isfinite(Agenda.of(self.places, opens, t).due)
        for q, row in enumerate(table):
            kept = np.flatnonzero(np.isfinite(row))
            dear = row[kept] + self._to_go(due[q], kept) >= self.most
            row[kept[dear]] = np.inf
        eased = self.board.progress.eased(opens)
        for q, row in enumerate(table):
            rivals = np.flatnonzero(eased[:, q])
            better = table[rivals[rivals != q]].min(axis=0, initial=np.inf)
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
        found = np.zeros(len(where))
        for places in self.places.small(np.flatnonzero(due)):
            first = np.array([self.places.ways[k][where] for k in places])
            way = (first + self.places.tours(places)[:, None]).min(axis=0)
            np.maximum(found, way, out=found)
        return found

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
                after = self.board.progress.after(opens[p], t, label, memo)
                if after is not None:
                    table[p, k] = made.setdefault(after, len(made))
        return table, list(made)


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
    gains = np.abs(np.diag(agent.dynamics.B))
    prices = (weight_of(compiled.mission, name) or 0.0) * agent.effort_input / gains
    board = Board(agent, progress, judge, ranges.state_lower, ranges.state_upper, lines, prices)
    return Play(board, most, over, Grid.on(board))
