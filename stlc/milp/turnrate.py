"""Turning rate ||u|| <= (u_max / v_max) ||v|| at t = 0..T-1 (the paper's; its mass cancels).

The set is not convex. With directions d_k, k = 1..K, exactly one of them taken (sum s_k = 1),

    u.e_h <= cos(pi / K) (u_max / v_max) v.d_k + M_hk (1 - s_k)    for all h = 1..K,

which is sound: v.d_k <= ||v||, and the polygon of u lies within its disc. It is conservative by
cos(pi / K)^2 at most (0.96 for 16). One more alternative, at rest, frees u where
||v|| <= rest_speed, by the inscribed polygon; `literal` leaves it out. Each M is the greatest
violation over the ranges of that step.
"""

from __future__ import annotations

import numpy as np

from stlc.analysis.ranges import Ranges
from stlc.arrays import Floats, Ints
from stlc.milp.context import Context
from stlc.milp.polygons import polygon_normals
from stlc.mission import Agent, TurnRate


def add_turn_rate(ctx: Context, agent: Agent) -> None:
    """Add direction binaries and rows for an agent that asks for its turning rate."""
    turn, velocity = agent.turn_rate, agent.dynamics.velocity
    if turn is None or velocity is None:
        return
    v = ctx.states[agent.name][:-1, list(velocity)]
    u = ctx.inputs[agent.name][:, :2]
    choices = turn.directions + (0 if turn.literal else 1)
    s = ctx.builder.binary(f"turn_{agent.name}", (len(u), choices))
    ctx.builder.add_dense_rows(f"turn_{agent.name}", s, 1.0, 1.0, 1.0)
    for step in range(len(u)):
        _add_directions(ctx, agent, turn, step, (u[step], v[step], s[step]))
        if not turn.literal:
            _add_rest(ctx, agent, turn, step, (v[step], s[step]))


def _add_directions(
    ctx: Context, agent: Agent, turn: TurnRate, step: int, cols: tuple[Ints, Ints, Ints]
) -> None:
    """u.e_h - c v.d_k + M s_k <= M, rows (k, h)."""
    u, v, s = cols
    normals = polygon_normals(turn.directions)
    scale = np.cos(np.pi / turn.directions) * turn.u_max / turn.v_max
    k, h = (i.ravel() for i in np.indices((turn.directions, turn.directions)))
    ranges = ctx.ranges[agent.name]
    most = _greatest(normals, ranges.input_lower[step, :2], ranges.input_upper[step, :2])
    least = -_greatest(-normals, *_velocity_range(agent, ranges, step))
    big = np.maximum(most[h] - scale * least[k], 0.0)
    columns = np.column_stack([np.tile(u, (len(h), 1)), np.tile(v, (len(h), 1)), s[k]])
    values = np.column_stack([normals[h], -scale * normals[k], big])
    ctx.builder.add_dense_rows(f"turn_{agent.name}_{step}", columns, values, -np.inf, big)


def _add_rest(
    ctx: Context, agent: Agent, turn: TurnRate, step: int, cols: tuple[Ints, Ints]
) -> None:
    """v.e_h + M s_rest <= rest_speed cos(pi / K) + M."""
    v, s = cols
    normals = polygon_normals(turn.directions)
    limit = turn.rest_speed * np.cos(np.pi / turn.directions)
    most = _greatest(normals, *_velocity_range(agent, ctx.ranges[agent.name], step))
    big = np.maximum(most - limit, 0.0)
    columns = np.column_stack([np.tile(v, (len(normals), 1)), np.full(len(normals), s[-1])])
    values = np.column_stack([normals, big])
    ctx.builder.add_dense_rows(f"rest_{agent.name}_{step}", columns, values, -np.inf, limit + big)


def _velocity_range(agent: Agent, ranges: Ranges, step: int) -> tuple[Floats, Floats]:
    assert agent.dynamics.velocity is not None
    velocity = list(agent.dynamics.velocity)
    return ranges.state_lower[step, velocity], ranges.state_upper[step, velocity]


def _greatest(normals: Floats, lower: Floats, upper: Floats) -> Floats:
    return np.asarray(np.maximum(normals * lower, normals * upper).sum(axis=1))
