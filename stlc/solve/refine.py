"""Finer grids where cells, not points, rule out every plan."""

from __future__ import annotations

from dataclasses import replace

from stlc import backends
from stlc.backends.base import SolveOptions, Status
from stlc.errors import InfeasibleError, MissionError, NoPlanError, SolverError
from stlc.grids import finer
from stlc.ir.nodes import Link, walk
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.mission import Mission
from stlc.solve.bounded import by_deadline
from stlc.solve.deadline import Deadline
from stlc.solve.outcome import SolveSettings

_SHARE, _SECONDS = 0.3, 30.0  # of the time that is left, and at most, to look whether cells matter


def refined_if_cells(
    mission: Mission, settings: SolveSettings, deadline: Deadline
) -> Mission | None:
    """The infeasible mission on finer grids, where it may have a plan on some.

    None where no channel that predicates look at may refine its grid, where the mission is too
    large on a finer one, or where even what holds somewhere in each cell leaves no plan.
    """
    refined = finer(mission)
    if refined is None or not _looks_at(mission) or deadline.over():
        return None
    if not _may_hold(mission, settings, deadline.share(_SHARE, _SECONDS)):
        return None
    try:
        _compiled(refined, settings.compile or CompileOptions(), deadline, settings.grace)
    except (MissionError, NoPlanError):
        return None  # too large, or too late: the coarse grid's answer stands, with its remedy
    except InfeasibleError:
        return refined  # a still finer grid may do
    return refined


def _compiled(
    mission: Mission, options: CompileOptions, deadline: Deadline, grace: float | None
) -> Compiled:
    """The model, by a deadline; raises as `compile_mission` and `by_deadline`."""
    return by_deadline(
        lambda stop: compile_mission(mission, replace(options, should_stop=stop)), deadline, grace
    )


def _looks_at(mission: Mission) -> bool:
    """Whether a requirement asks for a link of a channel that chooses its grid."""
    links = (n for r in mission.requirements for n in walk(r.formula) if isinstance(n, Link))
    return any(mission.channels[link.channel].auto for link in links)


def _may_hold(mission: Mission, settings: SolveSettings, deadline: Deadline) -> bool:
    """Whether a plan is possible where links hold wherever they do at some point of a cell."""
    options = replace(settings.compile or CompileOptions(), hopeful=True)
    try:
        bare = replace(mission, objective=())
        compiled = _compiled(bare, options, deadline, settings.grace)
        asked = deadline.bind(SolveOptions(gap=1.0, threads=settings.threads))
        found = backends.get(settings.backend).solve(compiled.model, asked)
    except (InfeasibleError, NoPlanError, SolverError):
        return False
    return found.status in (Status.OPTIMAL, Status.FEASIBLE)
