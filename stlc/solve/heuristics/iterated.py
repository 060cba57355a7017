"""Iterated local search over descents: forget what two agents do and let all answer again.

A descent ends where no agent betters its run alone. From the best runs known, those of two agents
at a time are dropped and planned anew, one after the other, before the rest answers them
(Lourenco, Martin and Stutzle, Iterated Local Search, 2003).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.solve import tuning
from stlc.solve.heuristics.descent import Descent
from stlc.solve.relaxation.problem import Axis, Problem
from stlc.solve.states.cells import cells_at

Runs = dict[int, Floats]
"""Positions (T+1, 2) of each agent."""
_BETTER = 1e-6


def iterated(descent: Descent, stop: Callable[[], bool], seed: int = 0) -> Iterator[Runs]:
    """Runs of all agents, each cheaper than those before; ends when told to, or after
    `tuning.DESCENTS.idle` descents in turn that bettered nothing."""
    agents, rng = len(descent.problem.bodies), np.random.default_rng(seed)
    starts = [list(range(agents)), list(range(agents))[::-1]]
    best, least, idle = Runs(), np.inf, 0
    while idle < tuning.DESCENTS.idle and not stop():
        anew = bool(starts)
        order = starts.pop(0) if anew else [int(n) for n in rng.permutation(agents)]
        kept = {} if anew else {n: best[n] for n in order[2:] if n in best}
        runs = descent.run(order, kept, tuning.DESCENTS.sweeps)
        cost = np.inf if runs is None else cost_of(descent.problem, runs)
        idle += 1
        if runs is not None and cost < least - _BETTER:
            best, least, idle = runs, cost, 0
            yield runs


def cost_of(problem: Problem, runs: Runs) -> float:
    """What runs of all agents cost, tables by the cells that their points touch."""
    links = sum(
        _least(table, cells_at(problem, runs[i][t]), cells_at(problem, runs[j][t]))
        for (i, j), tables in problem.pairs.items()
        for t, table in enumerate(tables) if table is not None
    )  # fmt: skip
    return problem.rest + links + sum(_alone(problem, n, run) for n, run in runs.items())


def _alone(problem: Problem, n: int, run: Floats) -> float:
    stations = sum(
        float(table[cells_at(problem, run[t])].min())
        for t, table in enumerate(problem.alone[n]) if table is not None
    )  # fmt: skip
    axes = problem.bodies[n].axes
    return stations + sum(_effort(axis, run[:, d]) for d, axis in enumerate(axes))


def _effort(axis: Axis, places: Floats) -> float:
    """Of the positions (T+1,) along an axis, whose rates follow from them."""
    rate, total = axis.start[1], 0.0
    for t, move in enumerate(np.diff(places)):
        after = (move - (1 - axis.blend) * rate) / axis.blend
        total += axis.rate_cost[t + 1] * abs(after) + axis.change_cost[t] * abs(after - rate)
        rate = after
    return total


def _least(table: Floats, a: Ints, b: Ints) -> float:
    return float(table[np.ix_(a, b)].min())
