"""Reach sets through the alternatives of one agent at consecutive steps.

A *stage* is a disjunction that is asserted at one step over one agent (free space, stepping
stones): its run takes one alternative of each stage. Interval reach sets are kept for each
alternative apart,

    S(t, i)  =  box of alternative i at step t, within the ranges,
    S(t+1, j) := S(t+1, j) with the hull over i of (A S(t, i) + B U + drift),    and backward,

and what is empty is known before solving: alternatives that no run takes, and pairs (i, j) that
do not follow one another. The encoder turns them into cuts and hulls (`milp/stage_rows.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.analysis.goals import Goal
from stlc.analysis.ranges import Ranges
from stlc.arrays import Bools, Floats
from stlc.ir.nodes import And, Linear, Node, Or, Role
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import conjuncts
from stlc.mission import Agent, Mission

LevelOf = Callable[[str], float]
"""What predicates of a unit have to reach."""

_SLACK = 1e-6
_SWEEPS = 2
_MOST = 64  # alternatives of one stage


@dataclass(slots=True, eq=False)
class Stage:
    """Alternatives of one agent at one step: lower, upper (k, n); `node` None: no choice."""

    node: Or | None
    lower: Floats
    upper: Floats

    @property
    def alive(self) -> Bools:
        """Alternatives (k,) whose reach set is not empty."""
        return np.asarray((self.lower <= self.upper + _SLACK).all(axis=1))

    def finite(self) -> tuple[Floats, Floats]:
        """Lower and upper with zeros where an alternative is empty."""
        alive = self.alive[:, None]
        return np.where(alive, self.lower, 0.0), np.where(alive, self.upper, 0.0)


@dataclass(slots=True, eq=False)
class Stages:
    """Stages (T+1) of one agent, and follows[t] (k_t, k_{t+1}): j may come after i."""

    agent: Agent
    stages: list[Stage]
    follows: list[Bools] = field(default_factory=list)


def single_place(node: Node) -> tuple[str, int] | None:
    """The agent and step that all predicates of a formula speak of, states only."""
    places: set[tuple[str, int]] = set()
    todo = [node]
    while todo:
        part = todo.pop()
        match part:
            case Linear(terms=terms):
                if any(signal.role is not Role.STATE for signal, _ in terms):
                    return None
                places.update((signal.owner, signal.shift) for signal, _ in terms)
            case And() | Or():
                todo.extend(part.children)
            case _:
                return None
        if len(places) > 1:
            return None
    return places.pop() if places else None


def box_of(
    predicates: Sequence[Linear], level: LevelOf, lower: Floats, upper: Floats
) -> tuple[Floats, Floats]:
    """Interval hull (n,) of {x in [lower, upper] : every predicate >= level(its unit)}."""
    low, high = lower.copy(), upper.copy()
    for predicate in predicates:
        most = [v * (high if v > 0 else low)[s.index] for s, v in predicate.terms]
        for k, (signal, value) in enumerate(predicate.terms):
            others = sum(most[:k] + most[k + 1 :])  # may be infinite, and so may its own
            edge = (level(predicate.unit) - predicate.constant - others) / value
            if value > 0:
                low[signal.index] = max(low[signal.index], edge)
            else:
                high[signal.index] = min(high[signal.index], edge)
    return low, high


def conjoined_predicates(node: Node) -> list[Linear] | None:
    """Predicates of a conjunction (or of one predicate); None for anything else."""
    parts = conjuncts(node)
    return [p for p in parts if isinstance(p, Linear)] if _all_linear(parts) else None


def _all_linear(parts: Sequence[Node]) -> bool:
    return all(isinstance(p, Linear) for p in parts)


def find_stages(
    mission: Mission,
    requirements: Sequence[Requirement],
    ranges: Mapping[str, Ranges],
    target: tuple[Goal, float] | None = None,
    sweeps: int = _SWEEPS,
) -> dict[str, Stages]:
    """Stages of every agent that has any: the widest disjunction at each step.

    `target` asks for more than the margins: that a robustness column reaches a value. No sweeps
    propagates forward only. An agent with an unbounded state or input has none: intervals without
    an end say nothing, and 0 * inf is no number.
    """
    chosen: dict[tuple[str, int], tuple[Or, LevelOf]] = {}
    for requirement in requirements:
        for node in conjuncts(requirement.formula):
            place = single_place(node) if _is_stage(node) else None
            if place is None:
                continue
            assert isinstance(node, Or)
            if place not in chosen or len(node.args) > len(chosen[place][0].args):
                chosen[place] = (node, level_at(requirement, target))
    return {
        name: analyse(agent, ranges[name], _stages(agent, ranges[name], chosen), sweeps)
        for name, agent in mission.agents.items()
        if any(owner == name for owner, _ in chosen) and _bounded(ranges[name])
    }


def _bounded(ranges: Ranges) -> bool:
    states, inputs = (
        (ranges.state_lower, ranges.state_upper),
        (ranges.input_lower, ranges.input_upper),
    )
    return all(np.isfinite(side).all() for side in (*states, *inputs))


def level_at(requirement: Requirement, target: tuple[Goal, float] | None) -> LevelOf:
    """What a requirement's predicates have to reach when a robustness column is at a value."""
    if target is None or not target[0].covers(requirement.name):
        return lambda unit: requirement.margin
    goal, value = target
    return lambda unit: max(requirement.margin, value * goal.scale(unit))


def _is_stage(node: Node) -> bool:
    if not isinstance(node, Or) or len(node.args) > _MOST:
        return False
    return all(conjoined_predicates(a) is not None for a in node.args)


def _stages(
    agent: Agent, ranges: Ranges, chosen: Mapping[tuple[str, int], tuple[Or, LevelOf]]
) -> list[Stage]:
    """An agent's boxes at each step: its range, or one for each alternative chosen there."""
    found: list[Stage] = []
    for t, (low, high) in enumerate(zip(ranges.state_lower, ranges.state_upper, strict=True)):
        if (agent.name, t) not in chosen:
            found.append(Stage(None, low[None].copy(), high[None].copy()))
            continue
        node, level = chosen[agent.name, t]
        boxes = [box_of(conjoined_predicates(a) or [], level, low, high) for a in node.args]
        found.append(Stage(node, np.array([b[0] for b in boxes]), np.array([b[1] for b in boxes])))
    return found


def analyse(agent: Agent, ranges: Ranges, stages: list[Stage], sweeps: int) -> Stages:
    """Propagate forward and backward; fills `follows`."""
    result = Stages(agent, stages)
    for _ in range(max(sweeps, 1)):
        result.follows = [_step(agent, ranges, stages, t) for t in range(len(stages) - 1)]
        for t in reversed(range(len(stages) - 1)) if sweeps else ():
            result.follows[t] &= _step_back(agent, ranges, stages, t)
    return result


def _input_interval(agent: Agent, ranges: Ranges, t: int) -> tuple[Floats, Floats]:
    law = agent.dynamics.law(t)
    gain, drift = law.B, law.drift
    a, b = gain * ranges.input_lower[t], gain * ranges.input_upper[t]
    return np.minimum(a, b).sum(axis=1) + drift, np.maximum(a, b).sum(axis=1) + drift


def _step(agent: Agent, ranges: Ranges, stages: Sequence[Stage], t: int) -> Bools:
    """Which pairs of boxes (k, l) of steps t and t + 1 a run can take; narrows those of t + 1."""
    here, there = stages[t], stages[t + 1]
    A = agent.dynamics.law(t).A
    plus, minus = np.maximum(A, 0), np.minimum(A, 0)
    least, most = _input_interval(agent, ranges, t)
    below, above = here.finite()
    low = below @ plus.T + above @ minus.T + least
    high = above @ plus.T + below @ minus.T + most
    pair_low = np.maximum(low[:, None, :], there.lower[None])
    pair_high = np.minimum(high[:, None, :], there.upper[None])
    may = (pair_low <= pair_high + _SLACK).all(axis=2) & here.alive[:, None] & there.alive[None]
    there.lower, there.upper = _hull(may, pair_low, pair_high, there, axis=0)
    return np.asarray(may)


def _step_back(agent: Agent, ranges: Ranges, stages: Sequence[Stage], t: int) -> Bools:
    """x_t from A x_t = x_{t+1} - B u - drift, one row and one variable at a time."""
    here, there = stages[t], stages[t + 1]
    A = agent.dynamics.law(t).A
    least, most = _input_interval(agent, ranges, t)
    (below, above), (next_low, next_high) = here.finite(), there.finite()
    pair_low = np.repeat(here.lower[:, None, :], len(there.lower), axis=1)
    pair_high = np.repeat(here.upper[:, None, :], len(there.lower), axis=1)
    for row, j in zip(*np.nonzero(A), strict=True):
        plus, minus = np.maximum(A[row], 0).copy(), np.minimum(A[row], 0).copy()
        plus[j] = minus[j] = 0.0
        rest_low = below @ plus + above @ minus
        rest_high = above @ plus + below @ minus
        a = (next_low[None, :, row] - most[row] - rest_high[:, None]) / A[row, j]
        b = (next_high[None, :, row] - least[row] - rest_low[:, None]) / A[row, j]
        pair_low[:, :, j] = np.maximum(pair_low[:, :, j], np.minimum(a, b))
        pair_high[:, :, j] = np.minimum(pair_high[:, :, j], np.maximum(a, b))
    may = (pair_low <= pair_high + _SLACK).all(axis=2) & here.alive[:, None] & there.alive[None]
    here.lower, here.upper = _hull(may, pair_low, pair_high, here, axis=1)
    return np.asarray(may)


def _hull(may: Bools, low: Floats, high: Floats, stage: Stage, axis: int) -> tuple[Floats, Floats]:
    """Hull over the other end of the pairs that may be; empty where there is none."""
    mask = may[:, :, None]
    lower = np.where(mask, low, np.inf).min(axis=axis)
    upper = np.where(mask, high, -np.inf).max(axis=axis)
    return np.maximum(stage.lower, lower), np.minimum(stage.upper, upper)
