"""The strategies in their order, and how a solve runs through them.

    brief           small team models: a plain solve for a moment
    grids           small teams that their inputs move directly: as routes
    turns           teams without a plan: one agent after the other, earlier ones held
    groups          agents that have nothing to do with each other: solved apart
    routes          no plan yet: runs over states and progress, better plans near them
    lone            teams that minimise effort: what each agent does alone, as rows and runs
    neighbourhoods  teams with a plan: a few agents answer the others anew
    parts           teams that minimise effort: bounds of a few agents without the others
    links           links between moving agents: dynamic programming bounds, branch and bound
    dive            maximal robustness: a run at the static bound
    milp            the compiled model, by the backend

A package offers its own under the entry-point group `stlc.strategies`: a `Strategy` object; it
runs before `milp`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import entry_points

from stlc.backends.base import Backend, Capability, Solution, SolveOptions, Status
from stlc.errors import UsageError, hinted
from stlc.milp.compile import Compiled
from stlc.milp.model import Model
from stlc.solve import tuning
from stlc.solve.alone.parts import PARTS
from stlc.solve.alone.strategy import LONE
from stlc.solve.heuristics.dive import DIVE
from stlc.solve.link_search import LINKS
from stlc.solve.routes.strategy import GRIDS, ROUTES
from stlc.solve.strategy import Strategy, Work
from stlc.solve.teams.groups import GROUPS
from stlc.solve.teams.improvement import NEIGHBOURHOODS
from stlc.solve.teams.turns import TURNS

ENTRY_POINTS = "stlc.strategies"
"""Entry-point group under which a package offers a `Strategy`."""


def run_strategy(
    name: str, compiled: Compiled, backend: Backend, options: SolveOptions
) -> Solution:
    """Solve by the strategies of that name (`strategies_named`). SolverError as the backend."""
    return run_strategies(strategies_named(name), Work.of(compiled, backend, options))


def run_strategies(strategies: Sequence[Strategy], work: Work) -> Solution:
    """Run those that apply, in order, until one answers or the time is over."""
    for strategy in strategies:
        if work.compiled.mission.caps and not strategy.heeds_caps:
            continue
        if not strategy.applies(work):
            continue
        step = strategy.run(work)
        if isinstance(step, Solution):
            return step
        work = step
        if work.proven() or (work.x is not None and work.deadline.over()):
            break
    return work.answer()


def strategies_named(name: str) -> tuple[Strategy, ...]:
    """`auto`: all of them; `milp`: one plain solve; any other: that one, then `milp`.

    UsageError for a name that is not known.
    """
    every = (*STRATEGIES[:-1], *_offered(), STRATEGIES[-1])
    if name == "auto":
        return every
    chosen = tuple(s for s in every if s.name == name)
    if not chosen:
        known = ["auto", *(s.name for s in every)]
        raise UsageError(f"no strategy is called '{name}'; {hinted(name, known)}")
    return chosen if chosen[0] is MILP else (*chosen, MILP)


def _offered() -> tuple[Strategy, ...]:
    return tuple(point.load() for point in entry_points(group=ENTRY_POINTS))


def _is_small(work: Work) -> bool:
    """A model so small that a plain solve mostly ends, or has a plan, before any search has."""
    compiled, most = work.compiled, tuning.BRIEF
    columns = most.columns if len(compiled.states) > 1 else most.lone_columns
    small = not compiled.robustness and compiled.model.columns <= columns
    return small and work.can(Capability.TIME_LIMIT)


def _try_briefly(work: Work) -> Work | Solution:
    moment = work.deadline.share(tuning.BRIEF.share, tuning.BRIEF.seconds)
    found = solve_twice_if_infeasible(work.compiled.model, work.backend, moment.bind(work.asked()))
    if found.status in (Status.OPTIMAL, Status.INFEASIBLE):
        return found
    if found.status is Status.FEASIBLE:
        work = work.with_point(found.x, "")
    return work if found.bound is None else work.with_bound(found.bound)


def _solve_whole(work: Work) -> Solution:
    """The compiled model by the backend; what was known before it stands if it is better."""
    found = solve_twice_if_infeasible(work.compiled.model, work.backend, work.asked())
    return work.concluded(found)


def solve_twice_if_infeasible(model: Model, backend: Backend, options: SolveOptions) -> Solution:
    """Solve; where HiGHS says infeasible, hear it again without its presolve.

    Presolve of HiGHS 1.15.1 has called feasible models infeasible. A second answer that is not
    infeasible replaces the first, unless it only ran out of time.
    """
    first = backend.solve(model, options)
    left = None if options.time_limit is None else options.time_limit - first.seconds
    late = left is not None and left <= 0
    if first.status is not Status.INFEASIBLE or backend.name != "highs" or late:
        return first
    plain = replace(options, time_limit=left, extra={**options.extra, "presolve": "off"})
    again = backend.solve(model, plain)
    return first if again.status in (Status.INFEASIBLE, Status.NO_SOLUTION) else again


BRIEF = Strategy("brief", _is_small, _try_briefly, heeds_caps=True)
MILP = Strategy("milp", lambda work: True, _solve_whole, heeds_caps=True)
STRATEGIES: tuple[Strategy, ...] = (
    BRIEF, GRIDS, TURNS, GROUPS, ROUTES, LONE, NEIGHBOURHOODS, PARTS, LINKS, DIVE, MILP,
)  # fmt: skip
"""Every strategy, in the order in which they run."""
