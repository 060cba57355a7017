"""Pairs of alternatives that no run takes together, from interval tubes.

An alternative asks for a box of states at one or several steps. Its tube is the interval reach set
of all runs within the ranges that pass through its boxes, forward and backward over all steps.
Alternatives i and j conflict where the tube of i misses a box of j; an alternative whose own tube
is empty is dead.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stlc.analysis.ranges import Ranges
from stlc.analysis.stages import LevelOf, box_of
from stlc.arrays import Bools, Floats, Ints
from stlc.ir.nodes import And, Linear, Node, Role
from stlc.mission import Agent, Mission

_SLACK = 1e-6
MOST = 1500
"""Alternatives beyond which no pairs are looked at (their number grows with the square)."""


@dataclass(frozen=True, slots=True, eq=False)
class Demand:
    """What one alternative asks of one agent: lower, upper (k, n) at steps (k,)."""

    column: int
    agent: str
    steps: tuple[int, ...]
    lower: Floats
    upper: Floats


def demands_of(
    column: int, node: Node, level: LevelOf, mission: Mission, ranges: Mapping[str, Ranges]
) -> list[Demand]:
    """Boxes that the predicates of an alternative's conjunctions ask for, one agent each."""
    atoms: dict[str, dict[int, list[Linear]]] = {}
    todo = [node]
    while todo:
        part = todo.pop()
        if isinstance(part, And):
            todo.extend(part.args)
        elif isinstance(part, Linear):
            places = {(s.owner, s.shift) for s, _ in part.terms if s.role is Role.STATE}
            if len(places) == 1 and all(s.role is Role.STATE for s, _ in part.terms):
                owner, step = places.pop()
                atoms.setdefault(owner, {}).setdefault(step, []).append(part)
    found = []
    for owner, by_step in atoms.items():
        r, steps = ranges[owner], tuple(sorted(by_step))
        boxes = [box_of(by_step[t], level, r.state_lower[t], r.state_upper[t]) for t in steps]
        lower, upper = (np.array([b[k] for b in boxes]) for k in range(2))
        found.append(Demand(column, owner, steps, lower, upper))
    return found


def tubes(agent: Agent, ranges: Ranges, demands: Sequence[Demand]) -> tuple[Floats, Floats]:
    """Lower and upper (K, T+1, n) of every demand's runs."""
    count = len(demands)
    low = np.repeat(ranges.state_lower[None], count, axis=0)
    high = np.repeat(ranges.state_upper[None], count, axis=0)
    for k, demand in enumerate(demands):
        low[k, list(demand.steps)] = np.maximum(low[k, list(demand.steps)], demand.lower)
        high[k, list(demand.steps)] = np.minimum(high[k, list(demand.steps)], demand.upper)
    A, B, drift = agent.dynamics.over(len(ranges.input_lower))
    plus, minus = np.maximum(A, 0), np.minimum(A, 0)
    a, b = B * ranges.input_lower[:, None, :], B * ranges.input_upper[:, None, :]
    least = np.minimum(a, b).sum(axis=2) + drift
    most = np.maximum(a, b).sum(axis=2) + drift
    for _ in range(2):
        for t in range(len(least)):
            forward_low = low[:, t] @ plus[t].T + high[:, t] @ minus[t].T + least[t]
            forward_high = high[:, t] @ plus[t].T + low[:, t] @ minus[t].T + most[t]
            np.maximum(low[:, t + 1], forward_low, out=low[:, t + 1])
            np.minimum(high[:, t + 1], forward_high, out=high[:, t + 1])
        for t in reversed(range(len(least))):
            _back(A[t], low, high, t, least[t], most[t])
    return low, high


def _back(A: Floats, low: Floats, high: Floats, t: int, least: Floats, most: Floats) -> None:
    for row, j in zip(*np.nonzero(A), strict=True):
        plus, minus = np.maximum(A[row], 0), np.minimum(A[row], 0)
        plus[j] = minus[j] = 0.0
        rest_low = low[:, t] @ plus + high[:, t] @ minus
        rest_high = high[:, t] @ plus + low[:, t] @ minus
        a = (low[:, t + 1, row] - most[row] - rest_high) / A[row, j]
        b = (high[:, t + 1, row] - least[row] - rest_low) / A[row, j]
        low[:, t, j] = np.maximum(low[:, t, j], np.minimum(a, b))
        high[:, t, j] = np.minimum(high[:, t, j], np.maximum(a, b))


def find_conflicts(
    mission: Mission, ranges: Mapping[str, Ranges], demands: Sequence[Demand]
) -> tuple[Ints, dict[int, Ints]]:
    """Columns of dead alternatives, and for each column those that conflict with it."""
    dead: set[int] = set()
    pairs: dict[int, set[int]] = {}
    for name, agent in mission.agents.items():
        own = [d for d in demands if d.agent == name]
        if not own or len(own) > MOST:
            continue
        low, high = tubes(agent, ranges[name], own)
        empty = (low > high + _SLACK).any(axis=(1, 2))
        dead.update(own[k].column for k in np.flatnonzero(empty))
        clash = _clashes(own, low, high)
        for i, j in zip(*np.nonzero(clash | clash.T), strict=True):
            if own[i].column != own[j].column:
                pairs.setdefault(own[i].column, set()).add(own[j].column)
    found = {i: np.array(sorted(others), np.int64) for i, others in pairs.items()}
    return np.array(sorted(dead), np.int64), found


def _clashes(demands: Sequence[Demand], low: Floats, high: Floats) -> Bools:
    """(K, K): the tube of i misses a box of j."""
    count = len(demands)
    clash = np.zeros((count, count), bool)
    for j, demand in enumerate(demands):
        steps = list(demand.steps)
        below = low[:, steps] > demand.upper[None] + _SLACK
        above = high[:, steps] < demand.lower[None] - _SLACK
        clash[:, j] = (below | above).any(axis=(1, 2))
    return clash
