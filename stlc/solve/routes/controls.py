"""What an agent can do in a step: controls to try, how far it gets, what counts as one state."""

from __future__ import annotations

import numpy as np

from stlc.analysis.ranges import Ranges
from stlc.arrays import Bools, Floats
from stlc.milp.polygons import norm_faces
from stlc.mission import Agent, NormBound

TOUCH = 1e-9
_FINE = (96, 24)  # cells of the positions, and of any other state, over its range


def reach_of(agent: Agent, ranges: Ranges) -> Floats:
    """(T+1, T+1): metres that an agent can go from one step to another at most."""
    dynamics = agent.dynamics
    position = dynamics.position
    assert position is not None
    change = position @ (dynamics.A - np.eye(len(dynamics.A)))
    fastest = np.zeros(len(ranges.input_lower))
    for row, gain in zip(change, position @ dynamics.B, strict=True):
        ends = np.maximum(np.abs(ranges.state_lower[:-1]), np.abs(ranges.state_upper[:-1]))
        pushes = np.maximum(np.abs(ranges.input_lower), np.abs(ranges.input_upper))
        used, pushed = row != 0, gain != 0
        speed = ends[:, used] @ np.abs(row[used]) + pushes[:, pushed] @ np.abs(gain[pushed])
        fastest += speed**2
    total = np.append(0.0, np.cumsum(np.sqrt(fastest)))
    return np.asarray(total[None] - total[:, None])


def control_set(agent: Agent, parts: int) -> Floats:
    """Inputs (c, m) to try: a grid over the bounds, 0 in it, within the norms."""
    axes = []
    for low, high in zip(agent.input_lower, agent.input_upper, strict=True):
        below = np.linspace(low, 0.0, parts + 1) if low < 0 else np.array([max(low, 0.0)])
        above = np.linspace(0.0, high, parts + 1) if high > 0 else np.array([min(high, 0.0)])
        grid = np.unique(np.round(np.append(below, above), 12))
        axes.append(np.unique(np.round(grid)) if agent.integer_inputs else grid)
    u = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(axes))
    for norm in agent.input_norms:
        u = u[within_norm(u, norm)]
    return u


def within_norm(values: Floats, norm: NormBound) -> Bools:
    """Whether (N, n) are within a norm's polygon."""
    normals, limit = norm_faces(norm)
    faces = values[:, list(norm.indices)] @ normals.T
    return np.asarray((faces <= limit + TOUCH).all(axis=1))


def cell_sizes(agent: Agent, ranges: Ranges, parts: int) -> Floats:
    """Size (n,) of the cells in which one state stands for all: what the least control moves,
    not finer than a share of the range."""
    dynamics = agent.dynamics
    gain = np.abs(dynamics.B) * (np.abs(agent.input_upper) / parts)
    power, moved = np.eye(len(dynamics.A)), np.full(len(dynamics.A), np.inf)
    for _ in range(len(dynamics.A)):
        step = np.abs(power) @ gain
        moved = np.minimum(moved, np.where(step > 1e-9, step, np.inf).min(axis=1))
        power = dynamics.A @ power
    spread = (ranges.state_upper - ranges.state_lower).max(axis=0)
    placed = dynamics.position is not None and np.abs(dynamics.position).sum(axis=0) > 0
    finest = spread / np.where(placed, *_FINE)
    size = np.maximum(np.where(np.isfinite(moved), moved, 0.0), finest)
    return np.where(size > 0, size, 1.0)
