"""Problems of one pair: its part of the costs, cells merged where there are many."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stlc.arrays import Floats
from stlc.solve.relaxation.problem import Axis, Body, Problem


def pair_share(problem: Problem, pair: tuple[int, int]) -> Problem:
    """The pair alone, with its part of both agents' own costs."""
    degree = [sum(i in p for p in problem.pairs) for i in pair]
    bodies = tuple(lighter(problem.bodies[i], d) for i, d in zip(pair, degree, strict=True))
    alone = tuple(
        tuple(None if c is None else c / d for c in problem.alone[i])
        for i, d in zip(pair, degree, strict=True)
    )
    pairs = {(0, 1): problem.pairs[pair]}
    return replace(problem, bodies=bodies, alone=alone, pairs=pairs, rest=0.0, apart=())


def lighter(body: Body, degree: int) -> Body:
    """With an equal part of its effort for each of `degree` pairs."""

    def axis(a: Axis) -> Axis:
        """An axis at an agent's share of its costs, one for each pair that it is in."""
        return replace(a, rate_cost=a.rate_cost / degree, change_cost=a.change_cost / degree)

    return replace(body, axes=(axis(body.axes[0]), axis(body.axes[1])))


def coarsened(problem: Problem, most: int) -> Problem:
    """At most about `most` cells, merged in blocks with the least cost of their pairs: a
    relaxation. The problem itself where it has no more."""
    factor = int(np.ceil(np.sqrt(problem.cells / most) - 1e-9))
    if factor <= 1:
        return problem
    edges = [np.unique(np.append(e[::factor], e[-1])) for e in problem.edges]
    numbers = [np.arange(n) // factor for n in problem.shape]
    width = len(edges[1]) - 1
    block = (numbers[0][:, None] * width + numbers[1][None]).ravel()
    count = (len(edges[0]) - 1) * width
    owner = np.full(count, -1, np.int64)
    known = np.flatnonzero(problem.owner >= 0)
    owner[block[known]] = 0
    made: dict[int, Floats] = {}

    def least(costs: Floats | None) -> Floats | None:
        """Costs over merged cells: the least of the cells merged, so a lower bound; kept by
        identity."""
        if costs is not None and id(costs) not in made:
            out = np.full((count,) * costs.ndim, np.inf)
            index = [block[known]] * costs.ndim
            np.minimum.at(out, np.ix_(*index), costs[np.ix_(*[known] * costs.ndim)])
            made[id(costs)] = out
        return None if costs is None else made[id(costs)]

    return replace(
        problem,
        edges=(edges[0], edges[1]),
        pairs={k: tuple(map(least, v)) for k, v in problem.pairs.items()},
        alone=tuple(tuple(map(least, v)) for v in problem.alone),
        owner=owner,
    )


def stage_cost(problem: Problem, t: int) -> Floats:
    """(n, n): link costs of the only pair and both agents' own, at step t."""
    out = np.zeros((problem.cells, problem.cells))
    table, a, b = problem.pairs[0, 1][t], problem.alone[0][t], problem.alone[1][t]
    out += 0.0 if table is None else table
    out += 0.0 if a is None else a[:, None]
    out += 0.0 if b is None else b[None]
    return out
