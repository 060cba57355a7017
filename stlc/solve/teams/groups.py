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
from stlc.milp.compile import CompileOptions, compile_mission
from stlc.solve.alone.run import Run
from stlc.solve.strategy import Work
from stlc.solve.teams.couplings import groups_of
from stlc.solve.teams.held import against
from stlc.solve.teams.whole import completed

_ROUNDING = 1e-7  # relative: of sums of bounds


def solve_apart(work: Work) -> Work | Solution:
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
    return Work.of(compiled, work.backend, options, work.crew)


def _solved(part: Work) -> Solution:
    from stlc.solve.strategies import GROUPS, run_strategies, strategies_named

    return run_strategies([s for s in strategies_named("auto") if s is not GROUPS], part)
