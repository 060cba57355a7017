"""How far a disturbed agent may be off its plan: a box at each step.

    e(t+1) = (A + B K) e(t) + B w(t),  e(0) = 0,  |w| <= W
    |e(t)| <= sum_{k < t} |(A + B K)^k B| W,     |K e(t)| <= sum_{k < t} |K (A + B K)^k B| W

exactly, coordinate by coordinate. What an input is off by includes w itself.

A robot is anywhere in a disc around the plan of its look-ahead point, at all times
(`stlc/robots.py`); its plan's inputs are as they are.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import sqrt

import numpy as np

from stlc.arrays import Floats
from stlc.ir.nodes import Role, Signal
from stlc.mission import Agent


def spreads(agent: Agent, horizon: int) -> tuple[Floats, Floats] | None:
    """Half widths of states (T+1, n) and of commanded inputs (T, m); None for one undisturbed."""
    if agent.robot is not None:
        return np.full((horizon + 1, 2), agent.robot.radius), np.zeros((horizon, 2))
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


@dataclass(frozen=True, slots=True, eq=False)
class Tubes:
    """What sums of signals may be off by: `widths` of each signal by itself, and `radii` of robots,
    whose coordinates at one step are off together, by a disc."""

    widths: Mapping[tuple[str, Role], Floats]
    radii: Mapping[str, float]

    @classmethod
    def of(cls, agents: Mapping[str, Agent], horizon: int) -> Tubes:
        """Those of agents over steps 0..horizon; an input is off by its disturbance too."""
        widths: dict[tuple[str, Role], Floats] = {}
        for name, agent in agents.items():
            found = spreads(agent, horizon)
            if found is not None and agent.tube is not None:
                widths[name, Role.STATE] = found[0]
                widths[name, Role.INPUT] = found[1] + agent.tube.bound
        radii = {n: a.robot.radius for n, a in agents.items() if a.robot is not None}
        return cls(widths, radii)

    def __bool__(self) -> bool:
        return bool(self.widths or self.radii)

    def off(self, terms: Iterable[tuple[Signal, float]], step: int = 0) -> float:
        """The most that a sum of signals may be off by, its shifts counted from `step`."""
        total, squares = 0.0, dict[tuple[str, int], float]()
        for s, factor in terms:
            width = self.widths.get((s.owner, s.role))
            if width is not None:
                total += abs(factor) * float(width[step + s.shift, s.index])
            elif s.owner in self.radii and s.role is Role.STATE:
                key = s.owner, s.shift
                squares[key] = squares.get(key, 0.0) + factor * factor
        return total + sum(self.radii[o] * sqrt(square) for (o, _), square in squares.items())
