"""Solves on the way: restricted models for a moment, and better plans near a plan."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stlc.arrays import Floats
from stlc.backends.base import Capability, Solution, Status
from stlc.errors import SolverError
from stlc.milp.model import Model
from stlc.solve import tuning
from stlc.solve.certify import continuous_part
from stlc.solve.routes.tube import covers, tube
from stlc.solve.strategy import Work

FINDER = "routes"


def solved(work: Work, model: Model, seconds: float, gap: float) -> Solution | None:
    """A solve on the way, for so many seconds; None where the solver failed."""
    start = work.x if work.can(Capability.START) else None
    asked = work.deadline.within(seconds).bind(work.options)
    try:
        return work.backend.solve(
            model, replace(asked, gap=max(gap, work.options.gap), start=start, on_progress=None)
        )
    except SolverError:
        return None  # the whole model is still to be solved


def polished(work: Work, x: Floats) -> Floats:
    """The best continuous part for the integers of a point (n,)."""
    found = solved(work, continuous_part(work.compiled.model, x), 5.0, 0.0)
    return x if found is None or found.x is None else found.x


def bettered(work: Work, share: float) -> Work | Solution:
    """Better plans near the plan: wider while it is easy, narrower where it is not."""
    deadline = work.deadline.share(share, tuning.ROUTES.better_seconds)
    size = max(float(np.ptp(r.position_upper[:, :2])) for r in work.compiled.ranges.values())
    radius = tuning.ROUTES.first_radius * size
    while not deadline.over() and not work.proven():
        assert work.x is not None
        near = tube(work.compiled, work.compiled.decode(work.x).states, radius)
        most = min(deadline.left, tuning.ROUTES.repair_seconds)
        found = solved(work, near, most, work.options.gap)
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
