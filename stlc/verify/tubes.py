"""Tubes of disturbed agents, as the verifier works them out: step by step, vertex by vertex.

How far an agent is off is the sum of one part for each push so far, and each part goes on by
A + B K. The half width of a state is the sum of what the parts can be at most.

A robot's tube is a disc around its plan, at all times (`stlc/robots.py`, `robots.py`).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stlc.ir.nodes import Role
from stlc.mission import Agent, Mission
from stlc.robots import Robot, RobotKind
from stlc.verify.trace import Array

Spread = Mapping[tuple[str, Role], Array]


def half_widths(agent: Agent, horizon: int) -> tuple[Array, Array] | None:
    """Of states (T+1, n) and of what is commanded (T, m); None for one that is as planned."""
    if agent.robot is not None:
        return np.full((horizon + 1, 2), radius(agent.robot)), np.zeros((horizon, 2))
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
    """How far each signal may be off: of disturbed agents, an input with the push itself, and of
    robots.

    Up to step `past` everything disturbed is as it was measured.
    """
    found: dict[tuple[str, Role], Array] = {}
    for name, agent in mission.agents.items():
        if agent.robot is not None:
            found[name, Role.STATE] = np.full((mission.horizon + 1, 2), radius(agent.robot))
            continue
        widths = half_widths(agent, mission.horizon - past)
        if widths is not None and agent.tube is not None:
            inputs = widths[1] + agent.tube.bound
            for role, ahead in ((Role.STATE, widths[0]), (Role.INPUT, inputs)):
                found[name, role] = np.vstack([np.zeros((past, ahead.shape[1])), ahead])
    return found


def radius(robot: Robot) -> float:
    """How far the centre of a robot's axle may be off the plan of its look-ahead point [m].

    Within a period d that point, no faster than S, is carried around at S / b at most: its
    acceleration is S^2 / b, and d^2 / 8 of that is what a chord may miss.
    """
    b, fastest = robot.lookahead, robot.speed
    if robot.kind is RobotKind.UNICYCLE:
        fastest = min(fastest, b * robot.turning)
    return b + fastest**2 / b * robot.period**2 / 8.0


def radii(mission: Mission) -> dict[str, float]:
    """That of every robot [m]."""
    return {n: radius(a.robot) for n, a in mission.agents.items() if a.robot is not None}
