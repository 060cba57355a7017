"""Where to cut a node in two: an agent, a step, an axis and a cell along it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stlc.arrays import Ints
from stlc.solve.bounders.arcs import Arcs
from stlc.solve.bounders.ascent import ascend, shares
from stlc.solve.relaxation.problem import Problem

_TRIALS, _ROUNDS = 4, 4
_LEAST = 1e-9  # share of the runs

Cut = tuple[int, int, int, int]
"""Agent, step, axis and the last cell along it of the first part."""


def along(problem: Problem, cell: Ints, d: int) -> Ints:
    """Number of each cell along an axis."""
    return np.divmod(cell, problem.shape[1])[d]


def best_cut(problem: Problem, arcs: Arcs, heat: float, room: float) -> Cut | None:
    """Of the cuts that divide the runs best the one whose parts gain most in a short ascent.

    `room`: what a part may gain before it is closed. None where no cut divides anything.
    """
    trials = sorted(_cuts(problem, arcs, heat), reverse=True)[:_TRIALS]
    scores = [(_gain(problem, arcs, cut, heat, room), cut) for _, cut in trials]
    return max(scores)[1] if scores else None


def _cuts(problem: Problem, arcs: Arcs, heat: float) -> Iterator[tuple[float, Cut]]:
    """For each agent, step and axis the cut with the greatest (smaller share) x (distance)."""
    share = shares(arcs, heat)
    for n, t, d in itertools.product((0, 1), range(1, arcs.steps + 1), (0, 1)):
        states = (arcs.stops[t].i, arcs.stops[t].j)[n]
        place = along(problem, arcs.layers[n][t].cell, d)[states]
        mass = np.bincount(place, share[t], minlength=problem.shape[d])
        low, moment = np.cumsum(mass)[:-1], np.cumsum(mass * np.arange(len(mass)))
        high = 1 - low
        smaller = np.minimum(low, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            apart = (moment[-1] - moment[:-1]) / high - moment[:-1] / low
            score = np.where(smaller > _LEAST, smaller * apart, 0.0)
        if len(score) and score.max() > 0:
            k = int(np.argmax(score))
            yield float(score[k]), (n, t, d, k)


def _gain(problem: Problem, arcs: Arcs, cut: Cut, heat: float, room: float) -> float:
    """Product of what both parts gain in a short ascent."""
    n, t, d, last = cut
    stop, slopes, gains = arcs.stops[t], arcs.slopes, 1.0
    place = along(problem, arcs.layers[n][t].cell, d)[(stop.i, stop.j)[n]]
    base = arcs.through()[0]
    for first in (True, False):
        arcs.stops[t] = replace(stop, cost=np.where((place <= last) == first, stop.cost, np.inf))
        ascend(arcs, heat, _ROUNDS)
        gains *= max(1e-6, min(arcs.through()[0] - base, room))
        arcs.slopes = slopes
    arcs.stops[t] = stop
    return gains
