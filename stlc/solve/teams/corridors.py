"""The whole model within a tube around runs of all agents.

Near runs most alternatives of disjunctions are out of reach: of the obstacles one side is left,
and of all pairs only those that meet have anything to decide. So what lone runs miss of getting
along is made good at little cost, and a plan is bettered for all agents at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from stlc.backends.base import Capability, Solution, Status
from stlc.errors import SolverError
from stlc.milp.compile import Compiled
from stlc.milp.model import Model
from stlc.solve import tuning
from stlc.solve.alone.run import Run
from stlc.solve.deadline import Deadline
from stlc.solve.routes.tube import tube
from stlc.solve.strategy import Work
from stlc.solve.teams.sides import decided, left_out


def beside(work: Work, runs: Mapping[str, Run], deadline: Deadline) -> Work:
    """With the best plan near runs of all agents that need not get along: where most is decided as
    they do, in wider and wider tubes while that helps, or else in the narrowest that holds one."""
    states = {name: run[0] for name, run in runs.items()}
    size = extent(work.compiled)
    near = [tube(work.compiled, states, part * size) for part in tuning.NEAR.beside]
    moment, out = deadline.share(tuning.NEAR.sides), left_out(work.compiled, runs)
    for model in near:
        better = _tried(work, decided(model, out), moment)
        if better is None:
            continue
        helped, work = better is not work, better
        if not helped or moment.over():
            break
    return work if work.x is not None else _first(work, near, deadline)


def _first(work: Work, models: Iterable[Model], deadline: Deadline) -> Work:
    """The work with the best plan of the first model that isn't proven to hold none."""
    for model in models:
        better = _tried(work, model, deadline)
        if better is not None:
            return better
    return work


def _tried(work: Work, model: Model, deadline: Deadline) -> Work | None:
    """The work with the best plan of a model if it is better; None where it is proven to have
    none."""
    found = _solved(work, model, deadline)
    if found is not None and found.status is Status.INFEASIBLE:
        return None
    return work if found is None else work.with_point(found.x, "runs beside lone ones")


@dataclass(slots=True)
class Corridor:
    """Tubes around the incumbent: wider while they are solved, narrower where they bring nothing
    in their time. `radius` is a part of the workspace, `searched` the widest that is known to hold
    nothing better than the incumbent; `idle`: nothing is left to try.
    """

    radius: float = field(default_factory=lambda: tuning.NEAR.radius)
    searched: float = 0.0
    idle: bool = False

    def better(self, work: Work, deadline: Deadline) -> Work:
        """The work with the best plan of the next tube."""
        assert work.x is not None
        states = work.compiled.decode(work.x).states
        near = tube(work.compiled, states, self.radius * extent(work.compiled))
        found = _solved(work, near, deadline)
        if found is None:
            self.idle = True
            return work
        better = work.with_point(found.x, "tubes")
        if better is not work:
            self.searched = 0.0
        elif found.status is Status.OPTIMAL:
            self.searched = self.radius
        if found.status is Status.OPTIMAL:
            self.radius *= tuning.NEAR.wider
        elif better is work:
            self.radius /= tuning.NEAR.wider
        self.idle = not max(tuning.NEAR.narrowest, 1.01 * self.searched) <= self.radius <= 1.0
        return better

    def moved(self) -> Corridor:
        """The same around another incumbent."""
        return Corridor(min(max(self.radius, tuning.NEAR.narrowest), 1.0))


def extent(compiled: Compiled) -> float:
    """The longest side of what positions of any agent span [m]."""
    ranges = compiled.ranges.values()
    return max(float((r.position_upper.max(0) - r.position_lower.min(0)).max()) for r in ranges)


def _solved(work: Work, model: Model, deadline: Deadline) -> Solution | None:
    """A solve on the way, from the incumbent; None where the solver failed."""
    start = work.x if work.can(Capability.START) else None
    gap = max(tuning.NEAR.gap, work.options.gap)
    asked = replace(deadline.bind(work.options), gap=gap, start=start, on_progress=None)
    try:
        return work.backend.solve(model, asked)
    except SolverError:
        return None  # one try of several
