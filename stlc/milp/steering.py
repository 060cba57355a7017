"""Directions of a car's plan: what its steering can follow (`stlc/robots.py`).

One of the directions d_k, k < K, is taken in each step t, sum_k s_tk = 1, and the input is in the
cone around it, of half angle g = pi / K:

    u_t = sum_k a_tk e(k-) + b_tk e(k+),  a, b >= 0,      cos(g) (a_tk + b_tk) <= v s_tk

with e(k-), e(k+) the edges of the cone and v the speed limit. The cones together are the plane, and
each holds u = 0: a car may wait in any direction. Directions flow from step to step, to the same or
to a neighbour (l from the right of it, turning left, r from its left):

    l_t,k+1 + r_t,k-1 + stay_tk = s_t-1,k         stay_tk = s_tk - l_tk - r_tk >= 0

and who turns goes `run_up` = w dt:   cos(g) (a_tk + b_tk) >= w (l_tk + r_tk). Before the first step
a car has any of the directions that its heading is within `hold` of. The convex hull of each step's
alternatives, by disjunctive programming, so that there is no big M; l and r are whole where s is.
"""

from __future__ import annotations

import numpy as np

from stlc.arrays import Ints
from stlc.milp.context import Context
from stlc.mission import Agent
from stlc.robots import RobotKind, Steering


def add_steering(ctx: Context, agent: Agent) -> None:
    """Add the direction binaries and rows of a car."""
    robot, u = agent.robot, ctx.inputs[agent.name]
    if robot is None or robot.kind is not RobotKind.CAR or not len(u):
        return
    steering = Steering.of(robot)
    assert steering is not None, "semantic analysis lets no such car pass"
    name, shape = f"steer_{agent.name}", (len(u), steering.count)
    s = ctx.builder.binary(name, shape)
    left, right = (ctx.builder.add_columns(f"{name}_{side}", shape, 0.0, 1.0) for side in "lr")
    ctx.builder.add_dense_rows(name, s, 1.0, 1.0, 1.0)
    _add_cones(ctx, agent, steering, u, s, (left, right))
    _add_flow(ctx, name, s, left, right, steering.held(robot.heading))


def _add_cones(
    ctx: Context, agent: Agent, steering: Steering, u: Ints, s: Ints, turns: tuple[Ints, Ints]
) -> None:
    """Inputs as sums over the edges of the cones; their lengths by direction and turn."""
    name, half = f"cone_{agent.name}", steering.spacing / 2.0
    angles = np.array(steering.directions())
    limit = min(bound.limit for bound in agent.input_norms)
    edges = ctx.builder.add_columns(name, (*s.shape, 2), 0.0, limit / np.cos(half))
    rays = np.concatenate([angles[:, None] - half, angles[:, None] + half], axis=1).ravel()
    flat = edges.reshape(len(u), -1)
    for axis, along in enumerate((np.cos(rays), np.sin(rays))):
        cols = np.column_stack([u[:, axis], flat])
        ctx.builder.add_dense_rows(name, cols, np.append(-1.0, along), 0.0, 0.0)
    width = np.cos(half)
    fastest = np.column_stack([edges.reshape(-1, 2), s.ravel()])
    ctx.builder.add_dense_rows(name, fastest, [width, width, -limit], -np.inf, 0.0)
    least = steering.run_up / ctx.mission.step
    slowest = np.column_stack([edges.reshape(-1, 2), *(turn.ravel() for turn in turns)])
    ctx.builder.add_dense_rows(name, slowest, [width, width, -least, -least], 0.0, np.inf)


def _add_flow(ctx: Context, name: str, s: Ints, left: Ints, right: Ints, held: list[bool]) -> None:
    """Directions from step to step; the first leave those that are held."""
    stay = np.stack([s, left, right], axis=-1)
    ctx.builder.add_dense_rows(name, stay.reshape(-1, 3), [1.0, -1.0, -1.0], 0.0, np.inf)
    gone = np.stack([np.roll(left, -1, axis=1), np.roll(right, 1, axis=1)], axis=-1)
    out = np.concatenate([stay, gone], axis=-1)
    values = [1.0, -1.0, -1.0, 1.0, 1.0]
    ctx.builder.add_dense_rows(name, out[0], values, -np.inf, np.array(held, dtype=np.float64))
    if len(s) > 1:
        later = np.concatenate([out[1:], s[:-1, :, None]], axis=-1).reshape(-1, 6)
        ctx.builder.add_dense_rows(name, later, [*values, -1.0], 0.0, 0.0)
