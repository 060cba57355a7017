"""Columns of every trajectory, and rows of the dynamics, norm polygons; the workspace."""

from __future__ import annotations

import numpy as np

from stlc.analysis.tubes import spreads
from stlc.arrays import Floats, Ints
from stlc.errors import InfeasibleError
from stlc.milp.context import Context
from stlc.milp.model import Origin
from stlc.milp.polygons import norm_faces
from stlc.milp.steering import add_steering
from stlc.milp.turnrate import add_turn_rate
from stlc.milp.workspace import add_workspace
from stlc.mission import Agent, NormBound


def add_agents(ctx: Context) -> None:
    """Add states, inputs and x(t+1) = A x(t) + B u(t) + drift of every agent."""
    for name, agent in ctx.mission.agents.items():
        ctx.builder.origin = Origin(f"agent {name}", agent.span)
        _add_columns(ctx, agent)
        _add_dynamics(ctx, agent)
        x_off, u_off = _room(ctx, agent)
        for bound in agent.state_norms:
            room = x_off if isinstance(x_off, float) else x_off[1:]
            _add_polygon(ctx, agent, bound, ctx.states[name][1:], room)
        for bound in agent.input_norms:
            _add_polygon(ctx, agent, bound, ctx.inputs[name], u_off)
        add_workspace(ctx, agent)
        add_turn_rate(ctx, agent)
        add_steering(ctx, agent)


def _add_columns(ctx: Context, agent: Agent) -> None:
    """States and inputs at each step, within their ranges and what a tube leaves of the bounds."""
    ranges, name = ctx.ranges[agent.name], agent.name
    shape = ranges.state_lower.shape
    x_off, u_off = _room(ctx, agent)
    ctx.states[name] = ctx.builder.add_columns(
        f"x_{name}", shape, *_within(ranges.state_lower, ranges.state_upper, agent.state_lower,
                                     agent.state_upper, x_off),
    )  # fmt: skip
    ctx.inputs[name] = ctx.builder.add_columns(
        f"u_{name}", ranges.input_lower.shape,
        *_within(ranges.input_lower, ranges.input_upper, agent.input_lower, agent.input_upper,
                 u_off),
        integer=agent.integer_inputs,
    )  # fmt: skip


def _room(ctx: Context, agent: Agent) -> tuple[Floats | float, Floats | float]:
    """What a tube takes off the bounds of states (T+1, n) and inputs (T, m); nothing without."""
    found = spreads(agent, ctx.mission.horizon)
    return (0.0, 0.0) if found is None else found


def _within(
    low: Floats, high: Floats, least: Floats, most: Floats, room: Floats | float
) -> tuple[Floats, Floats]:
    """Ranges within bounds that are `room` narrower on both sides.

    Raises InfeasibleError where nothing is left between them.
    """
    if isinstance(room, float):
        return low, high
    narrow = np.maximum(low, least + room), np.minimum(high, most - room)
    if (narrow[0] > narrow[1]).any():
        raise InfeasibleError("the bounds of an agent are narrower than its tube")
    return narrow


def _add_dynamics(ctx: Context, agent: Agent) -> None:
    """x(t+1) - A_t x(t) - B_t u(t) = drift_t, only over the nonzero entries; step-major."""
    x, u = ctx.states[agent.name], ctx.inputs[agent.name]
    steps, n = len(u), x.shape[1]
    if steps == 0:
        ctx.layout.dynamics[agent.name] = np.empty((0, n), np.int64)
        return
    A, B, drifts = agent.dynamics.over(steps)
    parts = [(np.broadcast_to(np.eye(n), A.shape), x[1:]), (-A, x[:-1]), (-B, u)]
    rows, cols, values = [], [], []
    for matrices, block in parts:
        t, i, j = np.nonzero(matrices)
        rows.append(t * n + i)
        cols.append(block[t, j])
        values.append(matrices[t, i, j])
    drift = drifts.ravel()
    made = ctx.builder.add_rows(
        f"dynamics_{agent.name}",
        np.concatenate(rows), np.concatenate(cols), np.concatenate(values),
        drift, drift, count=steps * n,
    )  # fmt: skip
    ctx.layout.dynamics[agent.name] = made.reshape(steps, n)


def _add_polygon(
    ctx: Context, agent: Agent, bound: NormBound, block: Ints, room: Floats | float
) -> None:
    """The paper's eq. (17): v_x sin(2 pi h / H) + v_y cos(2 pi h / H) <= offset, h = 1..H."""
    if len(block) == 0:
        return
    normals, offset = norm_faces(bound)
    cols = np.repeat(block[:, list(bound.indices)], len(normals), axis=0)
    values = np.tile(normals, (len(block), 1))
    limit: Floats | float = offset
    if not isinstance(room, float):
        limit = (offset - room[:, list(bound.indices)] @ np.abs(normals).T).ravel()
    ctx.builder.add_dense_rows(f"norm_{agent.name}", cols, values, -np.inf, limit)
