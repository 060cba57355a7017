"""Whether atoms hold of many moves of one agent at once, the runs of others given."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.analysis.link_tables import link_of
from stlc.arrays import Bools, Floats, Ints
from stlc.channels import ChannelTables
from stlc.ir.nodes import And, Const, Linear, Link, Node, Not, Or, Role, Signal
from stlc.mission import Channel, Mission
from stlc.trajectories import Trajectories

LevelOf = Callable[[str], float]
"""What predicates of a unit have to reach."""
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Moves:
    """Moves (N,) of an agent that end at `step`: states before, inputs (N, m), states after.

    At step 0 there are only states `after` (N, n).
    """

    agent: str
    step: int
    before: Floats
    inputs: Floats
    after: Floats

    def values(self, signal: Signal) -> Floats | None:
        """A signal of the agent over all moves (N,); None where the moves don't show it."""
        if signal.role is Role.INPUT:
            return self.inputs[:, signal.index] if signal.shift == self.step - 1 else None
        if signal.shift == self.step:
            return self.after[:, signal.index]
        return self.before[:, signal.index] if signal.shift == self.step - 1 else None


@dataclass(slots=True, eq=False)
class Judge:
    """Judges atoms. `levels` are by requirement, `others` the runs of agents that are planned.

    What speaks of agents that are not planned yet is taken to hold.
    """

    mission: Mission
    tables: ChannelTables
    levels: Sequence[LevelOf]
    others: Trajectories = field(default_factory=lambda: Trajectories({}, {}))
    miss: float = 0.0  # by which predicates may be missed
    _cells: dict[str, tuple[tuple[Floats, ...], Ints]] = field(default_factory=dict)

    def holds(self, node: Node, source: int, moves: Moves, done: dict[Node, Bools]) -> Bools:
        """Of each move (N,); `done` is a memo of these moves and this source."""
        if node not in done:
            done[node] = self._holds(node, source, moves, done)
        return done[node]

    def _holds(self, node: Node, source: int, moves: Moves, done: dict[Node, Bools]) -> Bools:
        """Which moves satisfy an unrolled formula at the level of its requirement `source`."""
        match node:
            case And(args=args):
                parts = [self.holds(a, source, moves, done) for a in args]
                return np.asarray(np.logical_and.reduce(parts))
            case Or(args=args):
                parts = [self.holds(a, source, moves, done) for a in args]
                return np.asarray(np.logical_or.reduce(parts))
            case Const(value=value):
                return np.full(len(moves.after), value)
            case Linear():
                return self._linear(node, self.levels[source](node.unit), moves)
            case Link() | Not():
                return self._link(node, self.levels[source](""), moves)
        raise TypeError(f"{type(node).__name__} in an unrolled formula")

    def _linear(self, node: Linear, level: float, moves: Moves) -> Bools:
        """A predicate on n moves, others on their runs; true while one of them has none."""
        value = np.full(len(moves.after), node.constant)
        for signal, weight in node.terms:
            if signal.owner == moves.agent:
                own = moves.values(signal)
                if own is None:
                    raise ValueError(f"a move to step {moves.step} says nothing of {signal}")
                value += weight * own
            elif signal.owner in self.others.states:
                value += weight * self._other(signal)
            else:
                return np.ones(len(value), bool)
        return np.asarray(value >= level - _ROUNDING - self.miss)

    def _other(self, signal: Signal) -> float:
        runs = self.others.inputs if signal.role is Role.INPUT else self.others.states
        return float(runs[signal.owner][signal.shift, signal.index])

    def _link(self, node: Link | Not, level: float, moves: Moves) -> Bools:
        """A threshold by the tables over cells; true while an end has no run, false off them."""
        link = link_of(node)
        found = self.tables.thresholds(link)
        table = found.low if isinstance(node, Link) else -found.high
        where = []
        for name in (link.sender, link.receiver):
            if name in self.mission.agents:
                cells = self.cells_of(link.channel, name, link.shift, moves.agent, moves.after)
                if cells is None:
                    return np.ones(len(moves.after), bool)
                where.append(cells)
        value = table[tuple(where)]
        inside = np.logical_and.reduce(np.broadcast_arrays(*(w >= 0 for w in where)))
        return np.broadcast_to((value >= level - _ROUNDING) & inside, len(moves.after))

    def cells_of(self, channel: str, name: str, step: int, own: str, after: Floats) -> Ints | None:
        """Cells of a moving end: (N,) of `own`, whose states are `after`, (1,) of an agent that
        is planned; None for one that is not, and for what stays."""
        if name == own:
            states = after
        elif name in self.others.states:
            states = self.others.states[name][step : step + 1]
        else:
            return None
        return self.cells(self.mission.channels[channel], self._position(name, states))

    def _position(self, name: str, states: Floats) -> Floats:
        space = self.mission.agents[name].dynamics.space
        assert space is not None
        return np.asarray(states @ space.T)

    def cells(self, channel: Channel, points: Floats) -> Ints:
        """The cell of a channel's partition at each point (N, 3), -1 outside all of them."""
        if channel.name not in self._cells:
            grid, owner = channel.partition.common_grid()
            assert grid.edges is not None
            self._cells[channel.name] = (grid.edges, owner)
        every, owner = self._cells[channel.name]
        number, out = np.zeros(len(points), np.int64), np.zeros(len(points), bool)
        for edges, at in zip(every, points.T, strict=False):
            i = np.where(at == edges[0], 0, np.searchsorted(edges, at) - 1)
            out |= (i < 0) | (i >= len(edges) - 1)
            number = number * (len(edges) - 1) + i
        return np.where(out, -1, owner[np.where(out, 0, number)])
