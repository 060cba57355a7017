"""First plans of the strategy `routes`: where ways have their visits, or near runs of beams."""

from __future__ import annotations

from stlc.backends.base import Solution
from stlc.solve import tuning
from stlc.solve.routes.finder import Effort, Routes
from stlc.solve.routes.motion_bounds import Bounds
from stlc.solve.routes.nearby import FINDER, bettered, polished, solved
from stlc.solve.routes.tube import tube
from stlc.solve.strategy import Work


def planned(work: Work, bounds: Bounds | None) -> Work | Solution:
    """The work with a first plan, better ones, and bounds; those of grids come before, since they
    find better plans too."""
    found = work if bounds is None else _visiting(work, bounds)
    first = _first_plan(found, bounds) if found.x is None else found
    if isinstance(first, Solution) or first.x is None:
        return first
    if bounds is not None and bounds.gridded:
        return bounded(first, bounds)
    better = bettered(first, tuning.ROUTES.better_share)
    if bounds is None or isinstance(better, Solution):
        return better
    if not bounds.promises(better.value, tuning.ROUTES.worth):
        return better
    return bounds.better(better, tuning.ROUTES.bound_share)


def bounded(work: Work, bounds: Bounds) -> Work | Solution:
    """The work, which has a plan, with bounds first and then better plans."""
    found = bounds.better(work, tuning.ROUTES.known_share)
    if isinstance(found, Solution) or found.proven():
        return found
    return bettered(found, tuning.ROUTES.better_share)


def _visiting(work: Work, bounds: Bounds) -> Work:
    """A first plan with visits where, or near where, the bound has them."""
    moment = work.deadline.share(tuning.ROUTES.share, tuning.ROUTES.seconds)
    for room in tuning.ROUTES.rooms:
        model = bounds.visiting(work.compiled, room, moment.over)
        if model is None:
            break
        found = solved(work, model, tuning.ROUTES.repair_seconds, tuning.ROUTES.rough)
        if found is not None and found.x is not None:
            return work.with_point(found.x, FINDER)
        if moment.over():
            break
    return work


def _first_plan(work: Work, bounds: Bounds | None) -> Work | Solution:
    """Runs of grids where agents are such, of one ahead of all and of a team after a few beams;
    beams of growing effort."""
    deadline = work.deadline.share(tuning.ROUTES.share, tuning.ROUTES.seconds)
    routes = Routes.of(work.compiled, deadline.over)
    gridded = bounds if bounds is not None and bounds.gridded else None
    few = tuning.ROUTES.first_efforts
    first = 0 if len(work.compiled.states) == 1 else few
    for number, effort in enumerate(tuning.ROUTES.efforts):
        if gridded is not None and number == first:
            work = gridded.guided(work, deadline.over)
        known = work.x is not None or deadline.over()
        if gridded is not None and number == few and not known:
            found = gridded.better(work, tuning.ROUTES.grid_share)
            if isinstance(found, Solution):
                return found
            work = found
        if work.x is not None or deadline.over():
            break
        work = _beamed(work, routes, Effort(*effort))
    return work


def _beamed(work: Work, routes: Routes, effort: Effort) -> Work:
    """A run by beams, repaired by the model in tubes of growing radius."""
    runs = routes.team(effort)
    if runs is None:
        return work
    spacing = max(routes.spacing(name, effort.parts) for name in runs.states)
    for cells in tuning.ROUTES.repair:
        near = tube(work.compiled, runs.states, cells * spacing)
        found = solved(work, near, tuning.ROUTES.repair_seconds, tuning.ROUTES.rough)
        if found is not None and found.x is not None:
            return work.with_point(polished(work, found.x), FINDER)
    return work
