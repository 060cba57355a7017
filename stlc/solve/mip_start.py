"""A plan as MIP start: the rest of a point for given trajectories."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stlc.backends import get
from stlc.backends.base import Floats, SolveOptions
from stlc.milp.compile import Compiled
from stlc.milp.model import Model
from stlc.plan import Plan

_SECONDS = 60.0
_SLACK = 1e-7  # a plan read from a file satisfies its rows up to the tolerance it was certified at


def complete_start(compiled: Compiled, plan: Plan) -> Floats | None:
    """A point x (n,) of the model with the plan's states and inputs, or None if there is none.

    Fixing the trajectories leaves cells, literals and costs, which HiGHS settles in presolve.
    None too when the plan has other agents, another horizon, or breaks the mission.
    """
    runs = {name: (np.asarray(r.states), np.asarray(r.inputs)) for name, r in plan.runs.items()}
    needed = compiled.states.keys() - compiled.layout.stand_ins
    if not runs.keys() >= needed:
        return None
    fixed = hold(compiled, {name: runs[name] for name in needed})
    if fixed is None:
        return None
    return get("highs").solve(fixed, SolveOptions(time_limit=_SECONDS, gap=0.0)).x


def hold(
    compiled: Compiled, runs: Mapping[str, tuple[Floats, Floats]], slack: float = _SLACK
) -> Model | None:
    """The model with some agents held to states (T+1, n) and inputs (T, m), to within `slack`.

    None when they are of another shape, or beyond the bounds of the model.
    """
    model = compiled.model
    lower, upper = model.col_lower.copy(), model.col_upper.copy()
    for agent, run in runs.items():
        for cols, values in zip((compiled.states[agent], compiled.inputs[agent]), run, strict=True):
            if values.shape != cols.shape:
                return None
            kept = np.clip(values, lower[cols], upper[cols])
            if np.max(np.abs(kept - values), initial=0.0) > 1e-4:
                return None
            lower[cols] = np.maximum(lower[cols], kept - slack)
            upper[cols] = np.minimum(upper[cols], kept + slack)
    return replace(model, col_lower=lower, col_upper=upper)
