"""The strategy `routes`: a first plan by beams over states and progress, bettered in tubes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stlc.arrays import Floats
from stlc.backends.base import Capability, Solution, Status
from stlc.errors import SolverError
from stlc.ir.networks import Count, Network
from stlc.ir.nodes import walk
from stlc.milp.model import Model
from stlc.mission import TermKind
from stlc.solve import tuning
from stlc.solve.certify import continuous_part
from stlc.solve.routes.bounds import Bounds
from stlc.solve.routes.finder import Effort, Routes
from stlc.solve.routes.tube import covers, tube
from stlc.solve.strategy import Strategy, Work

FINDER = "routes"
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
    found = _first_plan(found) if found.x is None else found
    if found.x is None:
        return found
    better = _bettered(found, tuning.ROUTES.better_share)
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
    glance = _solved(work, work.compiled.model, moment.left, work.options.gap)
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
        found = _solved(work, model, tuning.ROUTES.repair_seconds, tuning.ROUTES.rough)
        if found is not None and found.x is not None:
            return work.with_point(found.x, FINDER)
        if moment.over():
            break
    return work


def _first_plan(work: Work) -> Work:
    """Beams of growing effort; a run is repaired by the model in tubes of growing radius."""
    deadline = work.deadline.share(tuning.ROUTES.share, tuning.ROUTES.seconds)
    routes = Routes.of(work.compiled, deadline.over)
    for width, parts, miss, greed in tuning.ROUTES.efforts:
        runs = routes.team(Effort(width, parts, miss, greed))
        if runs is not None:
            spacing = max(routes.spacing(name, parts) for name in runs.states)
            for cells in tuning.ROUTES.repair:
                near = tube(work.compiled, runs.states, cells * spacing)
                found = _solved(work, near, tuning.ROUTES.repair_seconds, tuning.ROUTES.rough)
                if found is not None and found.x is not None:
                    return work.with_point(_polished(work, found.x), FINDER)
        if deadline.over():
            break
    return work


def _bettered(work: Work, share: float) -> Work | Solution:
    """Better plans near the plan: wider while it is easy, narrower where it is not."""
    deadline = work.deadline.share(share, tuning.ROUTES.better_seconds)
    size = max(float(np.ptp(r.position_upper[:, :2])) for r in work.compiled.ranges.values())
    radius = tuning.ROUTES.first_radius * size
    while not deadline.over() and not work.proven():
        assert work.x is not None
        near = tube(work.compiled, work.compiled.decode(work.x).states, radius)
        most = min(deadline.left, tuning.ROUTES.tube_seconds)
        found = _solved(work, near, most, work.options.gap)
        if found is None:
            return work
        if found.status is Status.OPTIMAL and covers(work.compiled.model, near):
            return work.concluded(found)
        before = work.value
        work = work.with_point(found.x, FINDER)
        if found.status is Status.OPTIMAL:
            radius *= tuning.ROUTES.wider
        elif work.value >= before:
            radius /= tuning.ROUTES.wider
        if radius < tuning.ROUTES.least_radius * size:
            break
    return work


def _polished(work: Work, x: Floats) -> Floats:
    """The best continuous part for the integers of a point (n,)."""
    found = _solved(work, continuous_part(work.compiled.model, x), 5.0, 0.0)
    return x if found is None or found.x is None else found.x


def _solved(work: Work, model: Model, seconds: float, gap: float) -> Solution | None:
    """A solve on the way, for so many seconds; None where the solver failed."""
    start = work.x if work.can(Capability.START) else None
    asked = work.deadline.within(seconds).bind(work.options)
    try:
        return work.backend.solve(
            model, replace(asked, gap=max(gap, work.options.gap), start=start, on_progress=None)
        )
    except SolverError:
        return None  # the whole model is still to be solved


ROUTES = Strategy("routes", applies, _run)
