"""Tubes of disturbed agents, as the verifier works them out: step by step, vertex by vertex.

How far an agent is off is the sum of one part for each push so far, and each part goes on by
A + B K. The half width of a state is the sum of what the parts can be at most.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stlc.ir.nodes import Role
from stlc.mission import Agent, Mission
from stlc.verify.trace import Array

Spread = Mapping[tuple[str, Role], Array]


def half_widths(agent: Agent, horizon: int) -> tuple[Array, Array] | None:
    """Of states (T+1, n) and of what is commanded (T, m); None for one that nothing pushes."""
    if agent.tube is None:
        return None
    A, B, K = agent.dynamics.A, agent.dynamics.B, agent.tube.gain
    closed, pushes = A + B @ K, B * agent.tube.bound  # a column for each push, as large as it gets
    parts: list[Array] = []  # of every push so far: what it has become (n, m)
    states, inputs = [], []
    for step in range(horizon + 1):
        states.append(sum((np.abs(p).sum(axis=1) for p in parts), np.zeros(len(A))))
        if step < horizon:
            inputs.append(sum((np.abs(K @ p).sum(axis=1) for p in parts), np.zeros(B.shape[1])))
        parts = [closed @ p for p in parts] + [pushes]
    return np.array(states), np.array(inputs).reshape(horizon, B.shape[1])


def spread_of(mission: Mission, past: int = 0) -> Spread:
    """How far each signal of disturbed agents may be off; an input with the push itself.

    Up to step `past` everything is as it was measured.
    """
    found: dict[tuple[str, Role], Array] = {}
    for name, agent in mission.agents.items():
        widths = half_widths(agent, mission.horizon - past)
        if widths is not None and agent.tube is not None:
            inputs = widths[1] + agent.tube.bound
            for role, ahead in ((Role.STATE, widths[0]), (Role.INPUT, inputs)):
                found[name, role] = np.vstack([np.zeros((past, ahead.shape[1])), ahead])
    return found
