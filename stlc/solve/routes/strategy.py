"""The strategy `routes`: a first plan by beams over states and progress, bettered in tubes."""

from __future__ import annotations

import numpy as np

from stlc.backends.base import Capability, Solution, Status
from stlc.ir.networks import Count, Network
from stlc.ir.nodes import walk
from stlc.mission import TermKind
from stlc.solve import tuning
from stlc.solve.routes.bounds import Bounds
from stlc.solve.routes.finder import Effort, Routes
from stlc.solve.routes.loose import fits
from stlc.solve.routes.nearby import FINDER, bettered, polished, solved
from stlc.solve.routes.tube import tube
from stlc.solve.strategy import Strategy, Work

_NEEDED = Capability.TIME_LIMIT | Capability.GAP


def applies(work: Work) -> bool:
    """No plan yet, or one agent alone; no robustness to maximise, agents that are somewhere and
    have bounded inputs and no turning rate, formulas of and, or and predicates, a model that is
    not solved in a moment."""
    mission = work.compiled.mission
    late = work.x is not None and len(mission.agents) > 1
    if late or work.compiled.robustness or not work.can(_NEEDED):
        return False
    pairs = any(
        all(end in mission.agents for end in pair)
        for term in mission.objective if term.kind is TermKind.LINK_COST for pair in term.pairs
    )  # fmt: skip
    formulas = (one.formula for one in work.compiled.layout.encoded)
    if any(isinstance(n, Count | Network) for formula in formulas for n in walk(formula)):
        return False
    return not pairs and all(
        agent.dynamics.position is not None
        and agent.turn_rate is None
        and len(agent.input_lower) > 0
        and np.isfinite(work.compiled.ranges[name].state_lower).all()
        and np.isfinite(work.compiled.ranges[name].state_upper).all()
        and np.isfinite(agent.input_lower).all()
        and np.isfinite(agent.input_upper).all()
        for name, agent in mission.agents.items()
    )


def _run(work: Work) -> Work | Solution:
    """A first plan by ways from visit to visit or else by beams, better ones near it, bounds; where
    a plan is known, a bound alone."""
    known, begun = work.x is not None, _glanced(work)
    if begun is None or isinstance(begun, Solution):
        return work if begun is None else begun  # infeasible: settled by the whole model
    work = begun
    moment = work.deadline.share(tuning.ROUTES.share, tuning.ROUTES.seconds)
    bounds = Bounds.of(work.compiled, moment.over)
    if bounds is not None and bounds.hopeless():
        return work.without_plan("ways from visit to visit")
    if known:
        return work if bounds is None else bounds.better(work, tuning.ROUTES.known_share)
    found = work
    if bounds is not None and work.x is None:
        found = _visiting(work, bounds)
    found = _first_plan(found, bounds) if found.x is None else found
    if found.x is None:
        return found
    better = bettered(found, tuning.ROUTES.better_share)
    if bounds is None or isinstance(better, Solution):
        return better
    return bounds.better(better, tuning.ROUTES.bound_share)


def _glanced(work: Work) -> Work | Solution | None:
    """The work after a moment of a plain solve: a longer one where a plan is known, none where one
    was tried in vain before (`brief`); None where that says infeasible or fails."""
    if work.x is None and np.isfinite(work.bound):
        return work
    seconds = tuning.ROUTES.glance if work.x is None else tuning.ROUTES.known_glance
    moment = work.deadline.share(tuning.ROUTES.share, seconds)
    glance = solved(work, work.compiled.model, moment.left, work.options.gap)
    if glance is not None and glance.status is Status.OPTIMAL:
        return work.concluded(glance)
    if glance is None or glance.status is Status.INFEASIBLE:
        return None
    if glance.bound is not None:
        work = work.with_bound(glance.bound)
    return work.with_point(glance.x, "")


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


def _first_plan(work: Work, bounds: Bounds | None) -> Work:
    """Beams of growing effort, after a few of them grids where agents are such."""
    deadline = work.deadline.share(tuning.ROUTES.share, tuning.ROUTES.seconds)
    routes = Routes.of(work.compiled, deadline.over)
    for number, effort in enumerate(tuning.ROUTES.efforts):
        if number == tuning.ROUTES.first_efforts and bounds is not None and bounds.gridded:
            work = bounds.better(work, tuning.ROUTES.grid_share)
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


def _are_on_grids(work: Work) -> bool:
    """A small team without a plan whose agents all go where their inputs say, for effort."""
    names = work.compiled.mission.agents
    team = 1 < len(names) <= tuning.ROUTES.grid_agents and work.x is None
    return team and applies(work) and all(fits(work.compiled, name) for name in names)


GRIDS = Strategy("grids", _are_on_grids, _run)
ROUTES = Strategy("routes", applies, _run)
