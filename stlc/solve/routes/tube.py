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


def within(compiled: Compiled, boxes: Mapping[str, Floats], room: float, steps: int) -> Model:
    """The model with agents whose position is two of their states in boxes (2, T+1, 2: low and
    high), `room` [m] wider to each side, up to so many steps sooner or later."""
    model = compiled.model
    lower, upper = model.col_lower.copy(), model.col_upper.copy()
    for name, run in boxes.items():
        low, high = _sooner_or_later(run, steps)
        position = compiled.mission.agents[name].dynamics.position
        assert position is not None
        columns = compiled.states[name][:, position.argmax(axis=1)]
        ends = lower[columns], upper[columns]
        lower[columns] = np.clip(low - room, *ends)
        upper[columns] = np.clip(high + room, *ends)
    return replace(model, col_lower=lower, col_upper=upper)


def _sooner_or_later(run: Floats, steps: int) -> tuple[Floats, Floats]:
    """Hulls (T+1, n), low and high, of the boxes (2, T+1, n) of so many steps before and after."""
    (low, high), last = run, run.shape[1] - 1
    shifts = [np.clip(np.arange(last + 1) + k, 0, last) for k in range(-steps, steps + 1)]
    return (
        np.minimum.reduce([low[shift] for shift in shifts]),
        np.maximum.reduce([high[shift] for shift in shifts]),
    )


def covers(model: Model, tight: Model) -> bool:
    """Whether the tube holds the whole model."""
    return bool(
        np.array_equal(model.col_lower, tight.col_lower)
        and np.array_equal(model.col_upper, tight.col_upper)
    )
