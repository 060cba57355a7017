"""The strategies in their order, and how a solve runs through them.

    brief           small team models: a plain solve for a moment
    grids           small teams that their inputs move directly: as routes
    descents        teams that pay for their links: each agent on a lattice, the others held
    turns           teams without a plan: one agent after the other, earlier ones held
    groups          agents that have nothing to do with each other: solved apart
    boxes           one agent that pays for where it is: runs over boxes and progress
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
from functools import cache
from importlib.metadata import entry_points

from stlc.backends.base import Backend, Solution, SolveOptions, Status
from stlc.errors import UsageError, hinted
from stlc.milp.compile import Compiled
from stlc.milp.model import Model
from stlc.mission import Mission, TermKind
from stlc.solve import applies, tuning
from stlc.solve.crew.crew import crew_of
from stlc.solve.strategy import Strategy, Work

ENTRY_POINTS = "stlc.strategies"
"""Entry-point group under which a package offers a `Strategy`."""


def run_strategy(
    name: str,
    compiled: Compiled,
    backend: Backend,
    options: SolveOptions,
    cluster: str | None = None,
) -> Solution:
    """Solve by the strategies of that name (`strategies_named`); small solves of searches are made
    by as many processes as there are to be threads, or on the cluster of that address. SolverError
    as the backend, or when the cluster can't be reached."""
    with crew_of(options.workers, cluster) as crew:
        return run_strategies(strategies_named(name), Work.of(compiled, backend, options, crew))


def run_strategies(strategies: Sequence[Strategy], work: Work) -> Solution:
    """Run those that apply, in order, until one answers or the time is over."""
    for strategy in strategies:
        if strategy is not MILP and _varies(work.compiled.mission):
            continue
        if not strategy.heeds_caps and _asks_for_plain(work.compiled.mission):
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


def _varies(mission: Mission) -> bool:
    """Whether some agent's matrices change from step to step, which no search reckons with."""
    return any(agent.dynamics.varies for agent in mission.agents.values())


def _asks_for_plain(mission: Mission) -> bool:
    """Whether it has costs that searches don't know of: several agents' together, or totals."""
    return bool(mission.caps) or any(t.kind is TermKind.TOTAL for t in mission.objective)


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


@cache
def _offered() -> tuple[Strategy, ...]:
    """What installed packages offer; to look through them takes 5 ms."""
    return tuple(point.load() for point in entry_points(group=ENTRY_POINTS))


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


def _descents(work: Work) -> Work:
    from stlc.solve.link_search import plan_links

    return plan_links(work)


def _turns(work: Work) -> Work:
    from stlc.solve.teams.turns import plan_in_turns

    return plan_in_turns(work)


def _groups(work: Work) -> Work | Solution:
    from stlc.solve.teams.groups import solve_apart

    return solve_apart(work)


def _routes(work: Work) -> Work | Solution:
    from stlc.solve.routes.plan_routes import plan_routes

    return plan_routes(work)


def _boxes(work: Work) -> Work | Solution:
    from stlc.solve.routes.boxed import look_through_boxes

    return look_through_boxes(work)


def _lone(work: Work) -> Work:
    from stlc.solve.alone.effort_rows import look_at_each

    return look_at_each(work)


def _neighbourhoods(work: Work) -> Work:
    from stlc.solve.teams.improvement import improve

    return improve(work)


def _parts(work: Work) -> Work:
    from stlc.solve.alone.parts import bound_parts

    return bound_parts(work)


def _links(work: Work) -> Work | Solution:
    from stlc.solve.link_search import search_links

    return search_links(work)


def _dive(work: Work) -> Work:
    from stlc.solve.heuristics.dive import look_for_start

    return look_for_start(work)


BRIEF = Strategy("brief", applies.is_small, _try_briefly, heeds_caps=True)
DESCENTS = Strategy("descents", applies.may_descend, _descents, heeds_caps=True)
TURNS = Strategy("turns", applies.may_plan, _turns, heeds_caps=True)
GROUPS = Strategy("groups", applies.falls_apart, _groups)
GRIDS = Strategy("grids", applies.may_grid, _routes, heeds_caps=True)
ROUTES = Strategy("routes", applies.may_route, _routes, heeds_caps=True)
BOXES = Strategy("boxes", applies.may_box, _boxes, heeds_caps=True)
LONE = Strategy("lone", applies.has_lone_runs, _lone, heeds_caps=True)
NEIGHBOURHOODS = Strategy("neighbourhoods", applies.may_improve, _neighbourhoods, heeds_caps=True)
PARTS = Strategy("parts", applies.has_parts, _parts, heeds_caps=True)
LINKS = Strategy("links", applies.may_search_links, _links, heeds_caps=True)
DIVE = Strategy("dive", applies.may_dive, _dive)
MILP = Strategy("milp", lambda work: True, _solve_whole, heeds_caps=True)
STRATEGIES: tuple[Strategy, ...] = (
    BRIEF, GRIDS, DESCENTS, TURNS, GROUPS, BOXES, ROUTES, LONE, NEIGHBOURHOODS, PARTS, LINKS, DIVE,
    MILP,
)  # fmt: skip
"""Every strategy, in the order in which they run; each imports its search when it does."""
