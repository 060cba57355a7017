"""Columns of every trajectory, and rows of the dynamics, norm polygons; the workspace."""

from __future__ import annotations

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.milp.context import Context
from stlc.milp.model import Origin
from stlc.milp.polygons import norm_faces
from stlc.milp.turnrate import add_turn_rate
from stlc.milp.workspace import add_workspace
from stlc.mission import Agent, NormBound


def add_agents(ctx: Context) -> None:
    """Add states, inputs and x(t+1) = A x(t) + B u(t) + drift of every agent."""
    for name, agent in ctx.mission.agents.items():
        ctx.builder.origin = Origin(f"agent {name}", agent.span)
        _add_columns(ctx, agent)
        _add_dynamics(ctx, agent)
        for bound in agent.state_norms:
            _add_polygon(ctx, agent, bound, ctx.states[name][1:], ctx.ranges[name].state_upper[1:])
        for bound in agent.input_norms:
            _add_polygon(ctx, agent, bound, ctx.inputs[name], ctx.ranges[name].input_upper)
        add_workspace(ctx, agent)
        add_turn_rate(ctx, agent)


def _add_columns(ctx: Context, agent: Agent) -> None:
    ranges, name = ctx.ranges[agent.name], agent.name
    shape = ranges.state_lower.shape
    ctx.states[name] = ctx.builder.add_columns(
        f"x_{name}", shape, ranges.state_lower, ranges.state_upper
    )
    ctx.inputs[name] = ctx.builder.add_columns(
        f"u_{name}", ranges.input_lower.shape, ranges.input_lower, ranges.input_upper,
        integer=agent.integer_inputs,
    )  # fmt: skip


def _add_dynamics(ctx: Context, agent: Agent) -> None:
    """x(t+1) - A x(t) - B u(t) = drift, only over the nonzero entries; step-major."""
    x, u = ctx.states[agent.name], ctx.inputs[agent.name]
    steps, n = len(u), x.shape[1]
    if steps == 0:
        ctx.layout.dynamics[agent.name] = np.empty((0, n), np.int64)
        return
    parts = [(np.eye(n), x[1:]), (-agent.dynamics.A, x[:-1]), (-agent.dynamics.B, u)]
    offsets = np.arange(steps)[:, None] * n
    rows, cols, values = [], [], []
    for matrix, block in parts:
        i, j = np.nonzero(matrix)
        rows.append((offsets + i).ravel())
        cols.append(block[:, j].ravel())
        values.append(np.tile(matrix[i, j], steps))
    drift = np.tile(agent.dynamics.drift, steps)
    made = ctx.builder.add_rows(
        f"dynamics_{agent.name}",
        np.concatenate(rows), np.concatenate(cols), np.concatenate(values),
        drift, drift, count=steps * n,
    )  # fmt: skip
    ctx.layout.dynamics[agent.name] = made.reshape(steps, n)


def _add_polygon(ctx: Context, agent: Agent, bound: NormBound, block: Ints, upper: Floats) -> None:
    """The paper's eq. (17): v_x sin(2 pi h / H) + v_y cos(2 pi h / H) <= offset, h = 1..H."""
    if len(block) == 0:
        return
    normals, offset = norm_faces(bound)
    cols = np.repeat(block[:, list(bound.indices)], len(normals), axis=0)
    values = np.tile(normals, (len(block), 1))
    ctx.builder.add_dense_rows(f"norm_{agent.name}", cols, values, -np.inf, offset)
