"""What a requirement's margin costs: the LP that is left with every integer fixed at the plan's.

The optimum f(e) of that LP, with the margin of one requirement raised by e, is convex and piecewise
linear in e; its slope to the right at 0 is the greatest y' d b / d e over the optimal duals y (they
needn't be unique, and a dual that a solver happens to hand over may tell too little). So the slope
is taken from two optima, which holds for every encoding. What a requirement costs beyond the plan's
integers (another order of visits, another side of an obstacle, another cell) is not in it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from stlc.arrays import Floats
from stlc.backends import get
from stlc.backends.base import SolveOptions, Status
from stlc.channels import TableMemo
from stlc.errors import InfeasibleError, MissionError, UsageError
from stlc.milp.compile import CompileOptions, compile_mission
from stlc.milp.model import Model
from stlc.mission import Mission
from stlc.plan import Plan
from stlc.solve.certify import EXACT
from stlc.solve.mip_start import complete_start

_EPSILON = 1e-4  # of a margin: short beside what plans turn on, and doubles keep ten digits of it
_PRUNING = frozenset({"decide", "stages", "decide-again"})
"""Passes that leave out what a margin rules out: with them a model's shape depends on margins."""


@dataclass(frozen=True, slots=True, eq=False)
class _Base:
    """A mission's model, a point of it with the plan's integers, and the optimum at those."""

    mission: Mission
    options: CompileOptions
    model: Model
    x: Floats
    value: float


def prices(mission: Mission, plan: Plan, names: Iterable[str]) -> dict[str, float]:
    """How the objective (in the mission's own sense) changes per unit of each one's margin.

    Requirements are left out where that isn't known: without an objective, for a plan that is no
    point of the model, where a margin changes the model's columns, and where no more is possible
    at the plan's integers.
    """
    base = _base(mission, plan) if mission.objective else None
    if base is None:
        return {}
    own = {name: mission.sense.own(_price(base, name)) for name in names}
    return {name: price for name, price in own.items() if price is not None}


def _base(mission: Mission, plan: Plan) -> _Base | None:
    """The model and the optimum at the plan's integers; None for a plan that is no point of it."""
    tables: TableMemo = {}
    options = CompileOptions(disabled_passes=_PRUNING, tables=tables)
    try:
        compiled = compile_mission(mission, options)
    except (InfeasibleError, MissionError, UsageError):
        return None
    x = complete_start(compiled, plan)
    value = None if x is None else _optimum(compiled.model, x)
    if x is None or value is None:
        return None
    return _Base(mission, options, compiled.model, x, value)


def _optimum(model: Model, x: Floats) -> float | None:
    """The least value of a model at the integers of x; None where there is no point."""
    fixed = model.integrality == 1
    lower, upper = model.col_lower.copy(), model.col_upper.copy()
    lower[fixed] = upper[fixed] = np.round(x[fixed])
    whole = np.zeros_like(model.integrality)
    lp = replace(model, col_lower=lower, col_upper=upper, integrality=whole)
    found = get("highs").solve(lp, SolveOptions(extra=dict(EXACT)))
    return found.objective if found.status is Status.OPTIMAL else None


def _price(base: _Base, name: str) -> float | None:
    """The slope of the optimum in one margin."""
    raised = tuple(
        replace(r, margin=r.margin + _EPSILON) if r.name == name else r
        for r in base.mission.requirements
    )
    try:
        other = compile_mission(replace(base.mission, requirements=raised), base.options).model
    except (InfeasibleError, MissionError):
        return None
    if _columns(other) != _columns(base.model):
        return None
    value = _optimum(other, base.x)
    return None if value is None else (value - base.value) / _EPSILON


def _columns(model: Model) -> tuple[object, ...]:
    """What must be alike for integers to carry over; rows that ranges imply come and go."""
    return tuple((b.name, b.size) for b in model.col_blocks)
