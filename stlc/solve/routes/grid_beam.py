"""A run of the grid of `play.py` in little time: only the most promising states of each step stay.

Lines go through the edges of all regions and obstacles, so that gaps are found that a lattice of
steps from the start has no point in. The run is one under loosened predicates: a place to look for
plans, no bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.solve.routes.agenda import Agenda
from stlc.solve.routes.play import Layer, Play
from stlc.solve.routes.progress import Open

_LATE = 1e-6


@dataclass(slots=True, eq=False)
class GridBeam(Play):
    """The grid, `width` states wide: half of them those that cost least so far and, counted
    `greed` times, to go; half the best of each set of places left to go to."""

    width: int = 1000
    greed: float = 2.0

    def _kept(self, t: int, after: list[Open], table: Floats) -> Layer:
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
