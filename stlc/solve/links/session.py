"""What one solve holds: clock, incumbent, and restricted MILPs given to the solver."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stlc.backends.base import Backend, Progress, SolveOptions, Status
from stlc.solve.links.lattice import cells_at
from stlc.solve.links.problem import Bools, Floats, Problem
from stlc.solve.links.restrict import Frame

_LONG = 1e9  # s: no limit


class Session:
    """The incumbent `x` of the full model with its `value`; `bound` proven for all plans."""

    def __init__(self, frame: Frame, backend: Backend, options: SolveOptions) -> None:
        self.frame, self.backend, self.options = frame, backend, options
        self.problem: Problem = frame.problem
        self.began = time.perf_counter()
        self.x: Floats | None = None
        self.value, self.bound, self.nodes = float("inf"), -float("inf"), 0

    @property
    def seconds(self) -> float:
        """Seconds since it began."""
        return time.perf_counter() - self.began

    @property
    def left(self) -> float:
        """Seconds until the time limit."""
        limit = _LONG if self.options.time_limit is None else self.options.time_limit
        return limit - self.seconds

    def stopped(self) -> bool:
        """At the time limit, or asked to stop."""
        asked = self.options.should_stop
        return self.left <= 0 or (asked is not None and asked())

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
        reduced = self.frame.reduce(lower, upper, self.cutoff)
        if reduced is None:
            return self.cutoff

        def take(progress: Progress) -> None:
            if progress.incumbent is not None:
                self.offer(reduced.lift(progress.incumbent))

        asked = replace(
            self.options, time_limit=max(0.05, min(seconds, self.left)), gap=gap, start=None,
            on_progress=take,
        )  # fmt: skip
        cutoff = self.cutoff
        found = self.backend.solve(reduced.model, asked)
        self.nodes += found.nodes or 0
        if found.x is not None and found.status in (Status.OPTIMAL, Status.FEASIBLE):
            self.offer(reduced.lift(found.x))
        if found.status is Status.INFEASIBLE:
            return cutoff
        return -np.inf if found.bound is None else min(found.bound, cutoff)

    def near(self, paths: Sequence[Floats], radius: float, seconds: float, gap: float) -> bool:
        """Solve over the cells within `radius` [m] of paths (T+1, 2); True when it improved."""
        lower, upper = self.frame.bounds()
        alive = [self._close(path, radius) for path in paths]
        boxes = self.problem.edges
        for i, own in enumerate(alive):
            for t in range(1, self.problem.steps + 1):
                ix, iy = np.divmod(np.flatnonzero(own[t]), self.problem.shape[1])
                box = np.array([
                    [e[k.min()], e[k.max() + 1], -np.inf, np.inf]
                    for e, k in zip(boxes, (ix, iy), strict=True)
                ])  # fmt: skip
                self.frame.confine(lower, upper, i, t, box)
        for i, j in self.problem.pairs:
            both = [np.logical_and.outer(a, b) for a, b in zip(alive[i], alive[j], strict=True)]
            self.frame.keep_pairs(upper, (i, j), both)
        before = self.value
        self.milp(lower, upper, seconds, gap)
        return self.value < before

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
