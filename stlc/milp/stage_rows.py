"""Cuts and hulls between the literals of consecutive stages (`stlc.analysis.stages`).

With z the literals and S(t, i) the reach set of alternative i at step t:

    z(t, i) <= sum {z(t+1, j) : j may follow i},     z(t+1, j) <= sum {z(t, i) : j may follow i},
    x(t) >= sum_i lower(S(t, i)) z(t, i),            likewise above.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stlc.analysis.ranges import Ranges
from stlc.analysis.stages import Stage, Stages
from stlc.arrays import Bools, Ints
from stlc.ir.nodes import Node
from stlc.milp.builder import ModelBuilder

_GAIN = 1e-3  # of a hull over the ranges, below which it is not worth a coefficient


def add_cuts(builder: ModelBuilder, stages: Stages, literals: Mapping[Node, Ints]) -> None:
    """Cuts between the literals (k,) of consecutive stages; a stage without literals has none."""
    for t, follows in enumerate(stages.follows):
        first, second = (_literals(stages.stages[k], literals) for k in (t, t + 1))
        if first is None or second is None:
            continue
        name = f"follow_{stages.agent.name}_{t}"
        _add_follow(builder, name, first, second, follows)
        _add_follow(builder, name, second, first, follows.T)


def _literals(stage: Stage, literals: Mapping[Node, Ints]) -> Ints | None:
    return None if stage.node is None else literals.get(stage.node)


def _add_follow(
    builder: ModelBuilder, name: str, first: Ints, second: Ints, follows: Bools
) -> None:
    """sum {second_j : j may follow i} - first_i >= 0, where some j may not."""
    tight = np.flatnonzero(~follows.all(axis=1))
    if not len(tight):
        return
    rows, cols = np.nonzero(follows[tight])
    own = np.arange(len(tight))
    builder.add_rows(
        name,
        np.concatenate([rows, own]),
        np.concatenate([second[cols], first[tight]]),
        np.concatenate([np.ones(len(rows)), -np.ones(len(own))]),
        0.0, np.inf, count=len(tight),
    )  # fmt: skip


def add_hulls(
    builder: ModelBuilder,
    states: Ints,
    ranges: Ranges,
    stages: Stages,
    literals: Mapping[Node, Ints],
) -> None:
    """x(t) >= sum_i lower_i z_i and x(t) <= sum_i upper_i z_i where that says more than ranges."""
    for t, stage in enumerate(stages.stages):
        z = _literals(stage, literals)
        if z is None:
            continue
        for sign, ends, limit in (
            (1.0, stage.lower, ranges.state_lower[t]),
            (-1.0, -stage.upper, -ranges.state_upper[t]),
        ):
            gain = np.where(np.isfinite(ends), ends, limit) - limit
            gain[gain < _GAIN] = 0.0
            used = np.flatnonzero(gain.any(axis=0))
            if not len(used):
                continue
            cols = np.column_stack([states[t, used], np.tile(z, (len(used), 1))])
            values = np.column_stack([np.full(len(used), sign), -gain[:, used].T])
            builder.add_dense_rows(
                f"hull_{stages.agent.name}_{t}", cols, values, limit[used], np.inf
            )
