"""Drops alternatives of stages that no run can take, and narrows the ranges to what is left.

    A or B  =  B     where interval reach sets through the stages (`analysis/stages.py`) show that
                     no run within the ranges takes alternative A at its step

The same sets at a higher level than the margin cap the robustness columns: where no run can take
the stages at robustness r, r is an upper bound, and bisection finds the least such r.

Needs: decide. Guarantees: the runs with robustness >= margin are the same, and on them so is the
best alternative that can be taken (robustness below the margin may change).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stlc.analysis.conflicts import demands_of
from stlc.analysis.goals import Goal
from stlc.analysis.ranges import Ranges
from stlc.analysis.reach import position_ranges, tidy
from stlc.analysis.stages import LevelOf, Stages, find_stages, level_at, single_place
from stlc.analysis.unreachable import refuse
from stlc.ir.nodes import And, Const, Node, Or
from stlc.ir.rewrite import conjuncts
from stlc.ir.verify import Stage
from stlc.passes.base import Pass, Program
from stlc.passes.fold import fold

_PRECISION = 2e-6  # of the capped robustness


def run(program: Program) -> Program:
    """Prune every requirement."""
    found = find_stages(program.mission, program.requirements, program.ranges)
    if not found:
        return program
    pruned: dict[Node, Node] = {}
    for stages in found.values():
        pruned.update(_pruned(stages))
    formulas = []
    for requirement in program.requirements:
        formula = _replaced(requirement.formula, pruned)
        if formula == Const(False):
            refuse(requirement)
        formulas.append(formula)
    ranges = dict(program.ranges)
    for name, stages in found.items():
        ranges[name] = _narrowed(stages, ranges[name])
    result = replace(program.with_formulas(formulas), ranges=ranges)
    return replace(result, goals=tuple(_capped(result, g) for g in result.known_goals()))


def _capped(program: Program, goal: Goal) -> Goal:
    """The goal with the least value that bisection proves out of reach of the stages."""
    low, high = goal.low, goal.high
    if not np.isfinite(high) or _attainable(program, goal, high):
        return goal
    while high - low > _PRECISION * max(1.0, abs(high)):
        middle = (low + high) / 2
        if _attainable(program, goal, middle):
            low = middle
        else:
            high = middle
    return replace(goal, high=high)


def _attainable(program: Program, goal: Goal, value: float) -> bool:
    """Whether reach through the stages leaves room for every choice at this robustness."""
    target = (goal, value)
    found = find_stages(program.mission, program.requirements, program.ranges, target, sweeps=0)
    if not all(stage.alive.any() for stages in found.values() for stage in stages.stages):
        return False
    return all(
        any(_meets(program, found, level_at(r, target), a) for a in node.children)
        for r in program.requirements
        for node in conjuncts(r.formula)
        if isinstance(node, Or) and single_place(node) is None
    )


def _meets(program: Program, found: Mapping[str, Stages], level: LevelOf, node: Node) -> bool:
    """Whether an alternative's boxes meet the reach sets at their steps."""
    for demand in demands_of(0, node, level, program.mission, program.ranges):
        if demand.agent not in found:
            continue
        for k, step in enumerate(demand.steps):
            stage = found[demand.agent].stages[step]
            lower = np.maximum(stage.lower, demand.lower[k])
            upper = np.minimum(stage.upper, demand.upper[k])
            if not (lower <= upper + 1e-6).all(axis=1).any():
                return False
    return True


def _pruned(stages: Stages) -> dict[Node, Node]:
    found: dict[Node, Node] = {}
    for stage in stages.stages:
        if stage.node is None or stage.alive.all():
            continue
        kept = tuple(a for a, alive in zip(stage.node.args, stage.alive, strict=True) if alive)
        found[stage.node] = fold(Or(kept, span=stage.node.span))
    return found


def _replaced(formula: Node, pruned: dict[Node, Node]) -> Node:
    if not isinstance(formula, And):
        return pruned.get(formula, formula)
    return fold(And(tuple(pruned.get(a, a) for a in formula.args), span=formula.span))


def _narrowed(stages: Stages, ranges: Ranges) -> Ranges:
    low = np.array([_least(s.lower, s.alive) for s in stages.stages]) - 1e-9
    high = np.array([-_least(-s.upper, s.alive) for s in stages.stages]) + 1e-9
    low, high = np.maximum(ranges.state_lower, low), np.minimum(ranges.state_upper, high)
    crossed = low > high
    low = tidy(np.where(crossed, ranges.state_lower, low))
    high = tidy(np.where(crossed, ranges.state_upper, high))
    position = position_ranges(stages.agent.dynamics.space, low, high)
    return Ranges(low, high, ranges.input_lower, ranges.input_upper, *position)


def _least(values: np.ndarray, alive: np.ndarray) -> np.ndarray:
    return np.asarray(np.where(alive[:, None], values, np.inf).min(axis=0))


PASS = Pass("stages", run, after=("decide",), stage=Stage.STEPS, preserves="optima")
