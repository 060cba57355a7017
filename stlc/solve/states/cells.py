"""Which cells touch a point: cells are closed, so a border belongs to both sides."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.solve.relaxation.problem import Body, Problem


def touching(edges: Floats, p: Floats, tolerance: float = 1e-6) -> tuple[Ints, Ints]:
    """Lowest and highest cell of an axis that touches each p."""
    last = len(edges) - 2
    low = np.searchsorted(edges, p - tolerance, side="right") - 1
    high = np.searchsorted(edges, p + tolerance, side="right") - 1
    return np.clip(low, 0, last), np.clip(high, 0, last)


def cells_at(problem: Problem, point: Floats) -> Ints:
    """Cells that touch a point (2,)."""
    spans = [
        np.unique(np.concatenate(touching(e, point[d : d + 1])))
        for d, e in enumerate(problem.edges)
    ]
    cells = (spans[0][:, None] * problem.shape[1] + spans[1][None]).ravel()
    known: Ints = cells[problem.owner[cells] >= 0]
    return known


def met(body: Body, path: Floats) -> list[int]:
    """The first alternative that a path (T+1, 2) meets; all where it meets none."""
    for j, place in enumerate(body.places):
        point = path[place.step]
        if (point >= place.box[:, 0] - 1e-6).all() and (point <= place.box[:, 1] + 1e-6).all():
            return [j]
    return list(range(len(body.places)))


def cheapest_pairs(
    problem: Problem, touched: Sequence[Sequence[Ints]]
) -> dict[tuple[int, int], list[Bools]]:
    """For each pair of agents and step (cells, cells): the cheapest pair of the cells that both
    touch, touched[agent][t] (k,); all of these where nothing costs."""
    return {
        (i, j): [_cheapest(problem, table, touched[i][t], touched[j][t])
                 for t, table in enumerate(tables)]
        for (i, j), tables in problem.pairs.items()
    }  # fmt: skip


def _cheapest(problem: Problem, table: Floats | None, a: Ints, b: Ints) -> Bools:
    found = np.zeros((problem.cells, problem.cells), bool)
    if table is None:
        found[np.ix_(a, b)] = True
        return found
    i, j = np.unravel_index(int(np.argmin(table[np.ix_(a, b)])), (len(a), len(b)))
    found[a[i], b[j]] = True
    return found
