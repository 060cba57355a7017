"""The compiled model near given runs: states within a radius of them, all else free.

Near a run most alternatives of disjunctions are out of reach and most obstacles have one side
left, so presolve leaves little. What a run of a search misses by little is repaired so, and a plan
is bettered within wider and wider tubes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stlc.arrays import Floats
from stlc.milp.compile import Compiled
from stlc.milp.model import Model


def tube(compiled: Compiled, states: Mapping[str, Floats], radius: float) -> Model:
    """The model with the placed states of each agent (T+1, n) within `radius` [m]."""
    model = compiled.model
    lower, upper = model.col_lower.copy(), model.col_upper.copy()
    for name, run in states.items():
        position = compiled.mission.agents[name].dynamics.position
        if position is None:
            continue
        placed = np.abs(position).sum(axis=0) > 0
        columns, around = compiled.states[name][:, placed], run[:, placed]
        low, high = lower[columns], upper[columns]
        lower[columns] = np.clip(around - radius, low, high)
        upper[columns] = np.clip(around + radius, low, high)
    return replace(model, col_lower=lower, col_upper=upper)


def covers(model: Model, tight: Model) -> bool:
    """Whether the tube holds the whole model."""
    return bool(
        np.array_equal(model.col_lower, tight.col_lower)
        and np.array_equal(model.col_upper, tight.col_upper)
    )
