"""A run of the grid of `play.py` in little time: only the most promising states of each step stay.

Lines go through the edges of all regions and obstacles, so that gaps are found that a lattice of
steps from the start has no point in, and an agent that goes from one of their crossings to another
has an exact run, which costs hardly more than any.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.ir.nodes import Linear, walk
from stlc.solve.routes.agenda import Agenda
from stlc.solve.routes.board import Board, Form
from stlc.solve.routes.moves import Moves
from stlc.solve.routes.play import Layer, Play
from stlc.solve.routes.progress import Open

_LATE = 1e-6


@dataclass(eq=False)
class Crossings(Board):
    """The board for an agent that is at its points itself, instead of around them."""

    def __post_init__(self) -> None:
        Board.__post_init__(self)
        self.ends = np.stack([self.points, self.points])

    def is_steady(self, number: int) -> bool:
        """Where others are changes from step to step."""
        node = self.progress.atoms[number].node
        signals = (part.terms for part in walk(node) if isinstance(part, Linear))
        return all(s.owner == self.agent.name for terms in signals for s, _ in terms)

    def form(self, number: int, t: int) -> Form:
        """The atom itself where it isn't steady."""
        if self.is_steady(number):
            return Board.form(self, number, t)
        atom = self.progress.atoms[number]
        return atom.source, atom.node

    def _ways(self, where: Ints, target: Ints) -> tuple[Floats, Floats]:
        way = self.points[target] - self.points[where]
        return way, way

    def _moving(self, t: int, where: Ints, target: Ints) -> Moves:
        before, after = self.points[where], self.points[target]
        return Moves(self.agent.name, t, before, self.inputs(before, after), after)

    def inputs(self, before: Floats, after: Floats) -> Floats:
        """Inputs (k, 2) that lead from one position to the next."""
        return np.asarray((after - before) / np.diag(self.agent.dynamics.B))


@dataclass(slots=True, eq=False)
class GridBeam(Play):
    """The grid, `width` states wide: half of them those that cost least so far and, counted
    `greed` times, to go; half the best of each set of places left to go to."""

    width: int = 1000
    greed: float = 2.0

    def finds(self) -> bool:
        """Whether a run was found, which is then in `layers`."""
        cost = self.bound()
        return cost is not None and bool(np.isfinite(cost))

    def _kept(self, t: int, after: list[Open], table: Floats) -> Layer:
        """The most promising of what the whole grid would keep."""
        layer = Play._kept(self, t, after, table)
        due = np.isfinite(Agenda.of(self.places, layer.opens, t).due)
        way = np.zeros(len(layer.where))
        for q in np.unique(layer.which).tolist():
            own = layer.which == q
            way[own] = self._to_go(due[q], layer.where[own])
        fine = np.flatnonzero(way <= self._fastest() * (len(self.board.lower) - 1 - t) + _LATE)
        score = layer.cost[fine] + self.greed * way[fine]
        todo = due[layer.which[fine]] @ 2.0 ** np.arange(due.shape[1])
        kept = fine[_chosen(score, todo, self.width)]
        return Layer(layer.opens, layer.where[kept], layer.which[kept], layer.cost[kept])

    def _fastest(self) -> float:
        """What a step can cost at most."""
        allowed = self.places.allowed()
        return np.inf if allowed is None else float(allowed.data.max(initial=0.0))


def _chosen(score: Floats, group: Floats, width: int) -> Ints:
    """The `width` best of all (k,): by score, or by their rank in their own group."""
    if len(score) <= width:
        return np.arange(len(score))
    rank = np.empty(len(score), np.int64)
    rank[np.argsort(score, kind="stable")] = np.arange(len(score))
    inner = np.lexsort((score, group))
    fresh: Bools = np.append(True, np.diff(group[inner]) != 0)
    starts = np.flatnonzero(fresh)
    sizes = np.diff(np.append(starts, len(inner)))
    within = np.empty(len(score), np.int64)
    within[inner] = np.arange(len(score)) - np.repeat(starts, sizes)
    best = np.argsort(np.minimum(2 * rank, 2 * within * len(starts) + 1), kind="stable")
    return np.sort(best[:width])
