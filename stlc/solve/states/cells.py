"""Which cells touch a point: cells are closed, so a border belongs to both sides."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.arrays import Floats, Ints
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


def cheapest_cells(problem: Problem, paths: Sequence[Floats]) -> list[Ints]:
    """One touched cell for each agent and step (T+1,), so that links are cheap: agents in turn
    choose against the others' cells."""
    touched = [[cells_at(problem, point) for point in path] for path in paths]
    chosen = [np.array([c[0] for c in own], np.int64) for own in touched]
    for _ in range(2):
        for i, own in enumerate(touched):
            for t, cells in enumerate(own):
                if len(cells) > 1:
                    costs = sum(_costs(problem, i, j, t, cells, int(chosen[j][t]))
                                for j in range(len(paths)) if j != i)  # fmt: skip
                    chosen[i][t] = cells[int(np.argmin(costs))]
    return chosen


def _costs(problem: Problem, i: int, j: int, t: int, cells: Ints, other: int) -> Floats:
    tables = problem.pairs.get((min(i, j), max(i, j)))
    table = None if tables is None else tables[t]
    if table is None:
        return np.zeros(len(cells))
    costs: Floats = table[cells, other] if i < j else table[other, cells]
    return costs
