"""Coordinate descent over the agents' lattices."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from stlc.arrays import Floats
from stlc.solve.heuristics.control_lattice import EDGE, Lone, between, lattice
from stlc.solve.relaxation.problem import Problem, Singles
from stlc.solve.states.cells import cells_at, touching


class Descent:
    """Coordinate descent: each agent in turn answers the others best."""

    def __init__(self, problem: Problem, stop: Callable[[], bool]) -> None:
        self.problem, self.stop = problem, stop
        self.grids = [lattice(problem, body) for body in problem.bodies]
        self._base: dict[int, Singles] = {}
        self._known: dict[tuple[object, ...], tuple[float, Floats] | None] = {}

    @property
    def possible(self) -> bool:
        """Whether every agent has a lattice."""
        return all(g is not None for g in self.grids)

    def run(
        self, order: Sequence[int], start: Mapping[int, Floats], sweeps: int
    ) -> dict[int, Floats] | None:
        """Positions (T+1, 2) of every agent, from those of `start`; None where one finds no run."""
        runs, values, stale = dict(start), dict[int, float](), 0
        for _ in range(sweeps):
            for n in order:
                if self.stop():
                    return runs if len(runs) == len(self.problem.bodies) else None
                found = self.answer(n, {k: p for k, p in runs.items() if k != n})
                if found is None:
                    return None
                same = n in runs and abs(values.get(n, np.inf) - found[0]) < 1e-4
                stale = stale + 1 if same else 0
                values[n], runs[n] = found
                if stale >= len(order):
                    return runs
        return runs

    def answer(self, n: int, others: Mapping[int, Floats]) -> tuple[float, Floats] | None:
        """The best run of agent n against fixed positions of others."""
        key = (n, *((m, others[m].tobytes()) for m in sorted(others)))
        if key not in self._known:
            self._known[key] = self._answer(n, others)
        return self._known[key]

    def _answer(self, n: int, others: Mapping[int, Floats]) -> tuple[float, Floats] | None:
        grids = self.grids[n]
        if grids is None:
            return None
        stage = self._own(n).copy()
        for m, path in others.items():
            self._add_links(stage, n, m, path)
            self._add_apart(stage, n, m, path)
        return Lone(self.problem, self.problem.bodies[n], grids, stage).best()

    def _own(self, n: int) -> Singles:
        """Stage costs (T+1, nx, ny) without others: ranges, obstacles, stations."""
        if n in self._base:
            return self._base[n]
        grids, body = self.grids[n], self.problem.bodies[n]
        assert grids is not None
        x, y = (g.positions for g in grids)
        stage = np.zeros((self.problem.steps + 1, len(x), len(y)), np.float32)
        for t in range(1, self.problem.steps + 1):
            spans = [axis.box[t, :2] for axis in body.axes]
            fine = np.logical_and.outer(between(x, spans[0]), between(y, spans[1]))
            for group in body.avoid.get(t, ()):
                some = np.zeros_like(fine)
                for box in group:
                    some |= np.logical_and.outer(between(x, box[0]), between(y, box[1]))
                fine &= some
            stage[t][~fine] = np.inf
            table = self.problem.alone[n][t]
            if table is not None:
                stage[t] += self._least(table, x, y)
        self._base[n] = stage
        return stage

    def _least(self, costs: Floats, x: Floats, y: Floats) -> Singles:
        """(nx, ny): cheapest of the cells that touch each point."""
        width = self.problem.shape[1]
        tx, ty = (touching(e, v) for e, v in zip(self.problem.edges, (x, y), strict=True))
        out = np.full((len(x), len(y)), np.inf, np.float32)
        for a in tx:
            for b in ty:
                out = np.minimum(out, costs[a[:, None] * width + b[None]])
        return out.astype(np.float32)

    def _add_links(self, stage: Singles, n: int, m: int, path: Floats) -> None:
        """Add agent n's link costs to `stage` [step, x, y], agent m on its `path` (T+1, 2) [m]."""
        costs = self.problem.pairs.get((min(n, m), max(n, m)))
        grids = self.grids[n]
        if costs is None or grids is None:
            return
        for t in range(1, self.problem.steps + 1):
            table = costs[t]
            if table is None:
                continue
            cells = cells_at(self.problem, path[t])
            row = table[:, cells].min(1) if n < m else table[cells].min(0)
            stage[t] += self._least(row, grids[0].positions, grids[1].positions)

    def _add_apart(self, stage: Singles, n: int, m: int, path: Floats) -> None:
        """Forbid states of n too near to m on its `path` (T+1, 2): infinite cost in `stage`."""
        grids = self.grids[n]
        assert grids is not None
        x, y = (g.positions for g in grids)
        for apart in self.problem.apart:
            if {apart.first, apart.second} != {n, m}:
                continue
            own, other = (0, 2) if apart.first == n else (2, 0)
            fine = np.zeros(stage.shape[1:], bool)
            for way in apart.ways:
                rest = way[4] - way[other : other + 2] @ path[apart.step]
                fine |= way[own] * x[:, None] + way[own + 1] * y[None] >= rest - EDGE
            stage[apart.step][~fine] = np.inf
