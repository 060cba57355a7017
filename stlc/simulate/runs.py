"""Runs that differ from the plan by noise at the start and in the inputs.

An agent with a `disturbance` is pushed by it, evenly within its bounds or with all of it, and
applies the feedback that its plan reckons with. Any other plan is carried out as it stands (open
loop): with e(0) ~ N(0, diag(start_noise^2)) and w(t) ~ N(0, diag(input_noise^2)), all independent,
x(t) is the plan's plus e(t), e(t+1) = A e(t) + B w(t), and u(t) the plan's plus w(t).

A robot drives as its controller makes it (`stlc/verify/robots.py`), the same way in all draws.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.ir.nodes import Role
from stlc.mission import Agent, Mission
from stlc.plan import Plan, Run
from stlc.verify.robots import drives

Array = NDArray[np.float64]

_HARD = 0.5  # share of pushes with all that a disturbance has, in either direction


@dataclass(frozen=True, slots=True, eq=False)
class Runs:
    """Signals (steps, width, D) of all agents, and positions (T+1, 3, D) [m] of agents and
    stations that are somewhere; D is the number of draws, or 1 for who is exactly where planned."""

    signals: Mapping[tuple[str, Role], Array]
    positions: Mapping[str, Array]


def is_noisy(agent: Agent) -> bool:
    """Whether the mission declares any noise or disturbance of this agent."""
    return agent.tube is not None or has_noise(agent)


def has_noise(agent: Agent) -> bool:
    """Whether its start or its inputs are drawn with standard deviations."""
    noises = (agent.start_noise, agent.input_noise)
    return any(s is not None and s.any() for s in noises)


def draw_runs(mission: Mission, plan: Plan, draws: int, rng: np.random.Generator) -> Runs:
    """The agents' runs, drawn one agent after the other."""
    signals, positions = {}, {}
    driven = drives(mission, plan.runs, plan.executed)
    for name, agent in mission.agents.items():
        states, inputs = _run(agent, plan.runs[name], draws, rng)
        if name in driven:
            states = driven[name].at_steps()[:, :, None]
        signals[name, Role.STATE], signals[name, Role.INPUT] = states, inputs
        space = agent.dynamics.space
        if space is not None:
            positions[name] = np.einsum("pn,tnd->tpd", space, states)
    for station in mission.stations.values():
        place = station.place[None, :, None]
        positions[station.name] = np.repeat(place, mission.horizon + 1, axis=0)
    return Runs(signals, positions)


def _run(agent: Agent, run: Run, draws: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """States (T+1, n, D) and inputs (T, m, D)."""
    states, inputs = run.states[:, :, None], run.inputs[:, :, None]
    if not is_noisy(agent):
        return states, inputs
    (n, m), model = agent.dynamics.B.shape, agent.dynamics
    start = np.zeros(n) if agent.start_noise is None else agent.start_noise
    shake = np.zeros(m) if agent.input_noise is None else agent.input_noise
    off = np.empty((len(states), n, draws))
    off[0] = start[:, None] * rng.standard_normal((n, draws))
    noise = shake[:, None] * rng.standard_normal((len(inputs), m, draws))
    if agent.tube is None:
        for t, push in enumerate(noise):
            law = model.law(t)
            off[t + 1] = law.A @ off[t] + law.B @ push
        return states + off, inputs + noise
    acting = np.empty(noise.shape)
    drawn = rng.uniform(-1.0, 1.0, noise.shape)
    for t, push in enumerate(noise + agent.tube.bound[:, None] * np.where(
        rng.random(noise.shape) < _HARD, np.sign(drawn), drawn
    )):  # fmt: skip
        acting[t] = agent.tube.gain @ off[t] + push
        off[t + 1] = model.A @ off[t] + model.B @ acting[t]
    return states + off, inputs + acting
