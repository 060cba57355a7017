"""Agents that have nothing to do with each other are planned apart: an exact decomposition.

Groups are the components of the couplings. No requirement and no cost speaks of two of them, so
plans of the groups make a plan of the team, their costs and bounds add up, and where one group has
no plan the team has none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from stlc.backends.base import Solution, Status
from stlc.errors import InfeasibleError
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.mission import TermKind
from stlc.solve.alone.run import Run
from stlc.solve.strategy import Strategy, Work
from stlc.solve.teams.couplings import Couplings
from stlc.solve.teams.held import against
from stlc.solve.teams.turns import NEEDED
from stlc.solve.teams.whole import completed

_ROUNDING = 1e-7  # relative: of sums of bounds


def groups_of(compiled: Compiled) -> list[tuple[str, ...]]:
    """The team's groups, agents in their order, the group of the first agent first."""
    couplings = Couplings.of(compiled)
    found: list[tuple[str, ...]] = []
    left = dict.fromkeys(compiled.mission.agents)
    while left:
        group, todo = set[str](), [next(iter(left))]
        while todo:
            name = todo.pop()
            if name not in group:
                group.add(name)
                todo.extend(couplings.partners(name))
        found.append(tuple(name for name in left if name in group))
        left = {name: None for name in left if name not in group}
    return found


def _falls_apart(work: Work) -> bool:
    """A team of two groups or more, whose costs add up."""
    mission = work.compiled.mission
    terms = [term for term in mission.objective if term.weight != 0]
    if len(mission.agents) < 2 or any(t.kind is TermKind.ROBUSTNESS for t in terms):
        return False
    stations = mission.stations.keys()
    fixed = any(stations >= set(pair) for term in terms for pair in term.pairs)
    return not fixed and work.can(NEEDED) and len(groups_of(work.compiled)) > 1


def _solve_apart(work: Work) -> Work | Solution:
    """Each group's own model; bounds add up, and runs are completed to a point of the whole."""
    runs: dict[str, Run] = {}
    bound, groups = 0.0, groups_of(work.compiled)
    for k, group in enumerate(groups):
        part = _part(work, group, len(groups) - k)
        found = None if part is None else _solved(part)
        if part is None or found is None or found.status is Status.INFEASIBLE:
            return work.without_plan()
        if found.x is None:
            return work
        made = part.compiled.decode(found.x)
        runs |= {name: (made.states[name], made.inputs[name]) for name in group}
        bound += -math.inf if found.bound is None else found.bound
    asked = work.deadline.bind(work.options)
    x = completed(work.compiled, runs, work.backend, asked)
    return work.with_point(x, "groups").with_bound(bound - _ROUNDING * (1 + abs(bound)))


def _part(work: Work, group: Sequence[str], left: int) -> Work | None:
    """The work on a group, with its share of the time; None where it can have no plan."""
    mission = against(work.compiled.mission, group, {}, work.compiled.channels)
    try:
        compiled = compile_mission(mission, CompileOptions(link=work.compiled.link))
    except InfeasibleError:
        return None
    options = work.deadline.share(1.0 / left).bind(work.options)
    options = replace(options, start=None, on_progress=None)
    return Work.of(compiled, work.backend, options)


def _solved(part: Work) -> Solution:
    from stlc.solve.strategies import run_strategies, strategies_named

    return run_strategies([s for s in strategies_named("auto") if s is not GROUPS], part)


GROUPS = Strategy("groups", _falls_apart, _solve_apart)
