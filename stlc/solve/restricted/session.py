"""What one solve holds: clock, incumbent, and restricted MILPs given to the solver."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from stlc.arrays import Bools, Floats
from stlc.backends.base import Progress, Status
from stlc.solve.relaxation.problem import Problem
from stlc.solve.relaxation.recognise import recognise
from stlc.solve.restricted.frame import Frame
from stlc.solve.states.cells import cells_at, cheapest_pairs, met
from stlc.solve.strategy import Work

_TOUCH = 1e-6  # m: cells this close count as touched
_ROOM = 0.3  # of a cell that a plan may be off the run that it is looked for around
_LONG = 1e9  # s: no limit
_PROOF: dict[str, object] = {
    "mip_heuristic_run_root_reduced_cost": False,
    "mip_heuristic_run_rins": False,
    "mip_heuristic_run_rens": False,
}
"""HiGHS without its sub-MIPs: restricted models mostly hold nothing better than the cutoff."""


class Session:
    """The incumbent `x` of the full model with its `value`; `bound` proven for all plans."""

    def __init__(self, frame: Frame, work: Work) -> None:
        self.frame, self.backend, self.options = frame, work.backend, work.options
        self.problem: Problem = frame.problem
        self._work, self.deadline = work, work.deadline
        self.x, self.value, self.bound, self.nodes = work.x, work.value, work.bound, 0

    def work(self) -> Work:
        """The work with what was found here."""
        better = self.x is not None and self.value < self._work.value
        options = replace(self._work.options, start=self.x)
        return replace(
            self._work, options=options, bound=self.bound, nodes=self._work.nodes + self.nodes,
            finder="link search" if better else self._work.finder,
        )  # fmt: skip

    @cached_property
    def guide(self) -> Problem:
        """The problem with every table's own costs, see `recognise`."""
        return recognise(self.frame.compiled, guide=True) or self.problem

    @property
    def seconds(self) -> float:
        """Seconds since the work began."""
        return self._work.seconds

    @property
    def left(self) -> float:
        """Seconds until the time limit."""
        return min(self.deadline.left, _LONG)

    def stopped(self) -> bool:
        """At the time limit, or asked to stop."""
        return self.deadline.over()

    @property
    def cutoff(self) -> float:
        """What a plan has to fall short of to matter: better than the incumbent by the gap."""
        if self.x is None:
            return float("inf")
        return self.value - 0.9 * self.options.gap * abs(self.value) - 1e-7

    def raise_bound(self, bound: float) -> None:
        """Record a bound on all plans."""
        if np.isfinite(bound) and bound > self.bound:
            self.bound = bound
            self._report(None)

    def offer(self, x: Floats) -> bool:
        """Take a point of the full model if it is better."""
        value = self.frame.model.objective(x)
        if value >= self.value - 1e-9:
            return False
        self.x, self.value = x, value
        self._report(x)
        return True

    def _report(self, x: Floats | None) -> None:
        if self.options.on_progress is None:
            return
        value = None if self.x is None else self.value
        bound = min(self.bound, self.value) if np.isfinite(self.bound) else None
        self.options.on_progress(Progress(self.seconds, value, bound, self.nodes, x))

    def milp(self, lower: Floats, upper: Floats, seconds: float, gap: float) -> float:
        """Solve the restricted model for something better than the cutoff; a lower bound of it.

        A restriction without a better plan is worth the cutoff.
        """
        if self.stopped():
            return -np.inf
        reduced = self.frame.reduce(lower, upper, self.cutoff)
        if reduced is None:
            return self.cutoff

        def take(progress: Progress) -> None:
            """Offer an incumbent of the reduced model as a point of the whole one."""
            if progress.incumbent is not None:
                self.offer(reduced.lift(progress.incumbent))

        asked = replace(
            self.options, time_limit=max(0.05, min(seconds, self.left)), gap=gap, start=None,
            on_progress=take, extra=self._extra(),
        )  # fmt: skip
        cutoff = self.cutoff
        found = self.backend.solve(reduced.model, asked)
        self.nodes += found.nodes or 0
        if found.x is not None and found.status in (Status.OPTIMAL, Status.FEASIBLE):
            self.offer(reduced.lift(found.x))
        if found.status is Status.INFEASIBLE:
            return cutoff
        return -np.inf if found.bound is None else min(found.bound, cutoff)

    def _extra(self) -> dict[str, object]:
        own = _PROOF if self.backend.name == "highs" else {}
        return {**own, **self.options.extra}

    def near(self, paths: Sequence[Floats], radius: float, seconds: float, gap: float) -> bool:
        """Solve over the cells within `radius` [m] of paths (T+1, 2); True when it improved."""
        return self._over([self._close(path, radius) for path in paths], None, seconds, gap)

    def follow(self, paths: Sequence[Floats], seconds: float) -> bool:
        """Make a plan near paths (T+1, 2): in touched cells, of which every pair takes the cheapest
        two, and one alternative of every choice over time; True when it is an improvement."""
        touched = [[cells_at(self.problem, point) for point in path] for path in paths]
        numbers = np.arange(self.problem.cells)
        alive = [[np.isin(numbers, cells) for cells in own] for own in touched]
        taken = cheapest_pairs(self.guide, touched)
        return self._over(alive, paths, seconds, 1e-3, taken)

    def around(self, free: Sequence[int], radius: float, seconds: float, gap: float) -> bool:
        """Solve with the agents `free` within `radius` [m] of the incumbent, the others in its
        cells; True when it improved."""
        paths, cells = self.paths(), self._occupied()
        alive = [
            self._close(path, radius) if i in free else cells[i] for i, path in enumerate(paths)
        ]
        return self._over(alive, None, seconds, gap)

    def _over(
        self, alive: Sequence[Sequence[Bools]], paths: Sequence[Floats] | None, seconds: float,
        gap: float, taken: Mapping[tuple[int, int], Sequence[Bools]] | None = None,
    ) -> bool:  # fmt: skip
        """Solve over alive[agent][t] (cells,), at `paths` if given, where tables take only the
        pairs `taken` if given."""
        lower, upper = self.frame.bounds()
        for i, own in enumerate(alive):
            for t in range(1, self.problem.steps + 1):
                box = self._hull(own[t])
                if paths is not None:
                    room = _ROOM * (box[:, 1] - box[:, 0])
                    box[:, 0] = np.maximum(box[:, 0], paths[i][t] - room)
                    box[:, 1] = np.minimum(box[:, 1], paths[i][t] + room)
                self.frame.confine(lower, upper, i, t, box)
            if paths is not None:
                self.frame.choose(upper, i, met(self.problem.bodies[i], paths[i]))
        for i, j in self.problem.pairs:
            if taken is None:
                both = [np.logical_and.outer(a, b) for a, b in zip(alive[i], alive[j], strict=True)]
                self.frame.keep_pairs(upper, (i, j), both)
            else:
                self.frame.keep_pairs(upper, (i, j), taken[i, j], taken=True)
        before = self.value
        self.milp(lower, upper, seconds, gap)
        return self.value < before

    def _hull(self, cells: Bools) -> Floats:
        """(2, 4): the box around some cells, rates free."""
        axes = np.divmod(np.flatnonzero(cells), self.problem.shape[1])
        ends = [(e[k.min()], e[k.max() + 1]) for e, k in zip(self.problem.edges, axes, strict=True)]
        return np.array([[low, high, -np.inf, np.inf] for low, high in ends])

    def _occupied(self) -> list[list[Bools]]:
        """For each agent and step the cells the incumbent counts as being in, or touches."""
        assert self.x is not None
        cells = [self._close(path, _TOUCH) for path in self.paths()]
        for pair, blocks in self.frame.blocks.items():
            for block in blocks:
                share = self.x[block.columns]
                for end, i in enumerate(pair):
                    if block.beside[end]:
                        continue
                    own = block.cells[end][int(np.argmax(share.sum(1 - end)))]
                    cells[i][block.step] = self.problem.owner == own
        return cells

    def _close(self, path: Floats, radius: float) -> list[Bools]:
        """For each step the cells within a radius (per axis) of the path."""
        out = []
        ex, ey = self.problem.edges
        for point in path:
            x = (ex[:-1] <= point[0] + radius) & (ex[1:] >= point[0] - radius)
            y = (ey[:-1] <= point[1] + radius) & (ey[1:] >= point[1] - radius)
            found = np.logical_and.outer(x, y).ravel()
            if not found.any():
                found[cells_at(self.problem, point)] = True
            out.append(found)
        return out

    def paths(self) -> list[Floats]:
        """Positions (T+1, 2) of the incumbent."""
        assert self.x is not None
        out = []
        for body in self.problem.bodies:
            states = self.x[self.frame.compiled.states[body.name]]
            out.append(states[:, [axis.state for axis in body.axes]])
        return out
