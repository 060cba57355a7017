"""The run of agents that do nothing: it meets most of what only forbids, at no cost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stlc.mission import Agent, Mission
from stlc.plan import make_plan
from stlc.trajectories import Trajectories
from stlc.verify import verify


def still(mission: Mission) -> Trajectories | None:
    """All inputs zero from the starts on; None where that breaks bounds or leaves the workspace."""
    with np.errstate(over="ignore", invalid="ignore"):
        states = {name: _drift(a, mission.horizon) for name, a in mission.agents.items()}
    if not all(np.isfinite(x).all() and np.abs(x).max() < 1e9 for x in states.values()):
        return None
    shapes = {name: (mission.horizon, a.dynamics.B.shape[1]) for name, a in mission.agents.items()}
    inputs = {name: np.zeros(shape) for name, shape in shapes.items()}
    bare = replace(mission, requirements=(), objective=(), obstacles={})
    if not verify(bare, make_plan(bare, states, inputs)).ok:
        return None
    return Trajectories(states, inputs)


def _drift(agent: Agent, steps: int) -> np.ndarray:
    """States (T+1, n) with no input."""
    states = [agent.start.astype(float)]
    for step in range(steps):
        law = agent.dynamics.law(step)
        states.append(law.A @ states[-1] + law.drift)
    return np.array(states)
