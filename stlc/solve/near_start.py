"""A plan that is none any more as a start: the best of what lies near it."""

from __future__ import annotations

import numpy as np

from stlc.arrays import Floats
from stlc.backends import get
from stlc.backends.base import SolveOptions, Status
from stlc.milp.compile import Compiled
from stlc.plan import Plan
from stlc.solve import tuning
from stlc.solve.deadline import Deadline
from stlc.solve.routes.tube import tube
from stlc.solve.teams.corridors import extent


def near_start(compiled: Compiled, plan: Plan, seconds: float) -> Floats | None:
    """A point x (n,) of the model whose states are near those of a plan that is none itself.

    For a plan that was made before agents were measured elsewhere. Tubes around it get wider as
    long as they hold no plan, within `seconds` for all.
    """
    needed = compiled.states.keys() - compiled.layout.stand_ins
    if not plan.runs.keys() >= needed:
        return None
    states = {name: np.asarray(plan.runs[name].states) for name in needed}
    if any(run.shape != compiled.states[name].shape for name, run in states.items()):
        return None
    size, deadline = extent(compiled), Deadline.after(seconds)
    for part in tuning.NEAR.beside:
        options = deadline.bind(SolveOptions(gap=tuning.NEAR.gap))
        found = get("highs").solve(tube(compiled, states, part * size), options)
        if found.status is not Status.INFEASIBLE or deadline.over():
            return found.x
    return None
