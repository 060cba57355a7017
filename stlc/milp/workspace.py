"""Rows of the workspace: at the samples, and at the Bezier points of the motion between them.

    normals @ p(t) <= offsets                         t = 0..T
    normals @ (C_kj (x(t), u(t), 1)) <= offsets       t = 0..T-1, if the workspace is `swept`

and floor and ceiling alike for who flies.

C_kj, the Bezier points of part k of a step (`stlc/bezier.py`), hold the curve in their convex
hull, so the workspace holds at all times. Tubes take their room off every offset; a robot goes
straight, so that its samples say it all. Rows that the ranges imply are left out.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stlc.analysis.ranges import Ranges
from stlc.analysis.tubes import spreads
from stlc.arrays import Floats
from stlc.bezier import curve
from stlc.milp.context import Context
from stlc.mission import Agent
from stlc.places import Polytope

_FINER = 2
"""Parts that each part is cut into: rows cost little without binaries, and halving the parts of a
parabola brings its Bezier points four times nearer to it."""


def add_workspace(ctx: Context, agent: Agent) -> None:
    """Keep an agent that is somewhere within the workspace."""
    workspace, position = ctx.mission.workspace, agent.dynamics.position
    if workspace is None or position is None:
        return
    _at_samples(ctx, agent, workspace, position)
    if not ctx.mission.workspace_swept or not len(ctx.inputs[agent.name]):
        return
    for point in _between(agent, position, ctx.mission.step):
        _at_point(ctx, agent, (workspace.normals, workspace.offsets), point)
    height, levels = agent.dynamics.altitude, ctx.mission.workspace_levels
    if height is not None and levels is not None:
        faces = np.array([[1.0], [-1.0]]), _ends(agent, height, levels)
        for point in _between(agent, height[None, :], ctx.mission.step):
            _at_point(ctx, agent, faces, point)


def _ends(agent: Agent, height: Floats, levels: tuple[float, float]) -> Floats:
    """Ceiling and minus the floor, or bounds of the height that had to give way beyond them."""
    k = int(np.argmax(height))
    low, high = float(agent.state_lower[k]), float(agent.state_upper[k])
    return np.array([max(levels[1], high), -min(levels[0], low)])


def _at_samples(ctx: Context, agent: Agent, workspace: Polytope, position: Floats) -> None:
    """Rows that keep the position at each step inside every face that its range crosses."""
    ranges, x = ctx.ranges[agent.name], ctx.states[agent.name]
    found = spreads(agent, ctx.mission.horizon)
    for normal, offset in zip(workspace.normals, workspace.offsets, strict=True):
        low, high = ranges.position_lower[:, :2], ranges.position_upper[:, :2]
        most = np.maximum(low * normal, high * normal).sum(axis=1)
        row = normal @ position
        room = np.zeros(len(x)) if found is None else found[0] @ np.abs(row)
        if agent.robot is not None:
            room[:] = _disc(agent, normal)
        steps = np.flatnonzero(most > offset - room + 1e-9)
        if len(steps):
            used = np.flatnonzero(row)
            ctx.builder.add_dense_rows(
                f"workspace_{agent.name}", x[np.ix_(steps, used)], row[used], -np.inf,
                offset - room[steps],
            )  # fmt: skip


def _disc(agent: Agent, normal: Floats) -> float:
    """What a face leaves of its room for a robot that is anywhere in its disc [m]."""
    assert agent.robot is not None
    return agent.robot.radius * float(np.hypot(*normal))


def _between(agent: Agent, position: Floats, step: float) -> Iterator[Floats]:
    """Bezier points of positions (d, n + m + 1), d rows of the state, within a step, without its
    ends."""
    coarse = curve(agent.dynamics, step)
    assert coarse is not None, "a swept workspace was asked of a motion that isn't known"
    states = np.flatnonzero(position.any(axis=0)).tolist()
    if coarse.parts == coarse.degree(states) == 1:
        return  # straight: the samples say it all
    fine = curve(agent.dynamics, step, _FINER * coarse.parts)
    assert fine is not None
    degree = fine.degree(states)
    assert degree is not None, "fewer parts were met by some degree"
    points = position @ fine.points(degree)
    yield from points[:, 1:].reshape(-1, *points.shape[2:])[:-1]


def _at_point(ctx: Context, agent: Agent, faces: tuple[Floats, Floats], point: Floats) -> None:
    """Rows that keep a point (d, n + m + 1) of the motion within each step, linear in state and
    input, inside faces: normals (F, d) and offsets (F,)."""
    ranges, name = ctx.ranges[agent.name], agent.name
    columns = np.hstack([ctx.states[name][:-1], ctx.inputs[name]])
    normals, offsets = faces
    rows, rest = (normals @ point)[:, :-1], normals @ point[:, -1]
    rows = np.where(np.abs(rows) <= 1e-12, 0.0, rows)
    room = np.abs(rows) @ _off(agent, len(columns)).T
    for row, limits in zip(rows, (offsets - rest)[:, None] - room, strict=True):
        steps = np.flatnonzero(_most(row, ranges) > limits + 1e-9)
        used = np.flatnonzero(row)
        if len(steps):
            block = columns[np.ix_(steps, used)]
            ctx.builder.add_dense_rows(
                f"workspace_{name}", block, row[used], -np.inf, limits[steps]
            )


def _off(agent: Agent, steps: int) -> Floats:
    """How far states and inputs (T, n + m) of a disturbed agent may be off as steps start."""
    found = spreads(agent, steps)
    if found is None or agent.tube is None:
        return np.zeros((steps, sum(agent.dynamics.B.shape)))
    return np.hstack([found[0][:-1], found[1] + agent.tube.bound])


def _most(row: Floats, ranges: Ranges) -> Floats:
    """The greatest value (T,) of a row over the ranges of states and inputs."""
    lower = np.hstack([ranges.state_lower[:-1], ranges.input_lower])
    upper = np.hstack([ranges.state_upper[:-1], ranges.input_upper])
    used = row != 0.0
    ends = row[used] * lower[:, used], row[used] * upper[:, used]
    return np.asarray(np.maximum(*ends).sum(axis=1), dtype=np.float64)
