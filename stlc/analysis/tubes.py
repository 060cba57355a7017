"""How far a disturbed agent may be off its plan: a box at each step.

    e(t+1) = (A + B K) e(t) + B w(t),  e(0) = 0,  |w| <= W
    |e(t)| <= sum_{k < t} |(A + B K)^k B| W,     |K e(t)| <= sum_{k < t} |K (A + B K)^k B| W

exactly, coordinate by coordinate. What an input is off by includes w itself.
"""

from __future__ import annotations

import numpy as np

from stlc.arrays import Floats
from stlc.mission import Agent


def spreads(agent: Agent, horizon: int) -> tuple[Floats, Floats] | None:
    """Half widths of states (T+1, n) and of commanded inputs (T, m); None for one undisturbed."""
    if agent.tube is None:
        return None
    model, gain = agent.dynamics, agent.tube.gain
    n, m = model.B.shape
    states, inputs = np.zeros((horizon + 1, n)), np.zeros((horizon, m))
    pushed = np.asarray(model.B, dtype=np.float64)
    for t in range(horizon):
        states[t + 1] = states[t] + np.abs(pushed) @ agent.tube.bound
        if t + 1 < horizon:
            inputs[t + 1] = inputs[t] + np.abs(gain @ pushed) @ agent.tube.bound
        pushed = (model.A + model.B @ gain) @ pushed
    return states, inputs
