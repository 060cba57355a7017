"""Interval reach sets from the start on: what bounds and dynamics say before any requirement does.

Exact for box inputs without state bounds (support functions of the reach set along the axes):
x_t = A^t x_0 + sum_k A^k (B u + drift), and with P(t, k) = A_t-1 .. A_k of laws that vary
x_t = P(t, 0) x_0 + sum_k P(t, k + 1) (B_k u + drift_k).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stlc.analysis.doubles import check_held, check_products, finite_size
from stlc.arrays import Floats
from stlc.ir.nodes import Role
from stlc.mission import Agent, Mission, NormBound, PolygonKind
from stlc.places import Polytope

SLACK = 1e-9  # keeps rounding from cutting off a feasible point


ROUNDING = 16 * float(np.finfo(float).eps)  # of a row's sum, for its terms; some to spare


@dataclass(slots=True, eq=False)
class Box:
    """Growing knowledge of one agent: states (T+1, n), inputs (T, m); narrowed in place."""

    agent: Agent
    x_lower: Floats
    x_upper: Floats
    u_lower: Floats
    u_upper: Floats

    def narrow(self, role: Role, step: int, index: int, lower: float, upper: float) -> None:
        """Intersect one interval."""
        state = role is Role.STATE
        low, high = (self.x_lower, self.x_upper) if state else (self.u_lower, self.u_upper)
        low[step, index] = max(low[step, index], lower)
        high[step, index] = min(high[step, index], upper)

    def interval(self, role: Role, step: int, index: int) -> tuple[float, float]:
        """One interval."""
        state = role is Role.STATE
        low, high = (self.x_lower, self.x_upper) if state else (self.u_lower, self.u_upper)
        return float(low[step, index]), float(high[step, index])


def start_box(agent: Agent, mission: Mission) -> Box:
    """Declared bounds, norm polygons and workspace, the start fixed; then forward reach."""
    steps, n, m = mission.horizon, *agent.dynamics.B.shape
    box = Box(
        agent,
        np.tile(agent.state_lower.astype(float), (steps + 1, 1)),
        np.tile(agent.state_upper.astype(float), (steps + 1, 1)),
        np.tile(agent.input_lower.astype(float), (steps, 1)).reshape(steps, m),
        np.tile(agent.input_upper.astype(float), (steps, 1)).reshape(steps, m),
    )
    for bound in agent.state_norms:
        _clip(box.x_lower[1:], box.x_upper[1:], bound)
    for bound in agent.input_norms:
        _clip(box.u_lower, box.u_upper, bound)
    _clip_workspace(box, mission.workspace)
    first, last = agent.starts or (agent.start, agent.start)
    box.x_lower[0] = np.maximum(box.x_lower[0], first)
    box.x_upper[0] = np.minimum(box.x_upper[0], last)
    check_products(agent, (box.x_lower, box.x_upper), (box.u_lower, box.u_upper))
    _forward(box)
    assert box.x_lower.shape == (steps + 1, n)
    return box


def _clip(lower: Floats, upper: Floats, bound: NormBound) -> None:
    outer = bound.kind is PolygonKind.OUTER
    reach = bound.limit / np.cos(np.pi / bound.sides) if outer else bound.limit
    columns = list(bound.indices)
    lower[:, columns] = np.maximum(lower[:, columns], -reach)
    upper[:, columns] = np.minimum(upper[:, columns], reach)


def _clip_workspace(box: Box, workspace: Polytope | None) -> None:
    """Keep coordinates within the workspace's bounding box, where one state alone makes an axis."""
    position = box.agent.dynamics.position
    if workspace is None or position is None:
        return
    low, high = workspace.vertices.min(axis=0), workspace.vertices.max(axis=0)
    for axis in range(2):
        used = np.flatnonzero(position[axis])
        if len(used) != 1:
            continue
        scale = position[axis, used[0]]
        ends = sorted((low[axis] / scale, high[axis] / scale))
        box.x_lower[:, used[0]] = np.maximum(box.x_lower[:, used[0]], ends[0])
        box.x_upper[:, used[0]] = np.minimum(box.x_upper[:, used[0]], ends[1])


_Reach = tuple[Floats, Floats, Floats]
"""P(t, 0) (n, n), and the least and the most (n,) of what inputs and drifts add up to."""


def _forward(box: Box) -> None:
    """Narrow the states by what the start, and inputs within their box, can make of them."""
    centre = box.agent.start.astype(float)
    spread = [end - centre for end in box.agent.starts or (centre, centre)]
    reached = _varying(box) if box.agent.dynamics.varies else _steady(box)
    with np.errstate(over="ignore", invalid="ignore"):
        for step, (power, low, high) in enumerate(reached):
            centre = box.agent.dynamics.law(step).A @ centre
            about = image(power, *spread)
            size = np.abs(centre) + finite_size(low) + finite_size(high)
            slack = SLACK + ROUNDING * (step + 1) * size
            ends = centre + low + about[0] - slack, centre + high + about[1] + slack
            _meet(box, step + 1, *ends)
            if (box.x_lower[step + 1] > box.x_upper[step + 1]).any():
                return  # `propagate` says so


def _steady(box: Box) -> Iterator[_Reach]:
    """Step by step, with the same matrices at all of them."""
    dynamics = box.agent.dynamics
    power = np.eye(len(dynamics.A))
    low = high = np.zeros(len(power))
    for _ in range(len(box.u_lower)):
        # Inputs are bounded alike at all steps, so step 0's box serves every power.
        ends = image(power @ dynamics.B, box.u_lower[0], box.u_upper[0])
        low = low + ends[0] + power @ dynamics.drift
        high = high + ends[1] + power @ dynamics.drift
        power = dynamics.A @ power
        yield power, low, high


def _varying(box: Box) -> Iterator[_Reach]:
    """Step by step, each with its own matrices: what every earlier input has become by then."""
    dynamics = box.agent.dynamics
    n, m = dynamics.B.shape
    power, drift, gains = np.eye(n), np.zeros(n), np.empty((0, n, m))
    for step in range(len(box.u_lower)):
        law = dynamics.law(step)
        power, drift = law.A @ power, law.A @ drift + law.drift
        gains = np.concatenate([law.A @ gains, law.B[None]])
        ends = image(gains, box.u_lower[0], box.u_upper[0])
        yield power, ends[0].sum(axis=0) + drift, ends[1].sum(axis=0) + drift


def _meet(box: Box, step: int, low: Floats, high: Floats) -> None:
    """Intersect the states at a step with what the dynamics can reach.

    Raises MissionError where nothing else bounds a state that grows beyond doubles.
    """
    inputs = np.isfinite(box.u_lower[0]).all() and np.isfinite(box.u_upper[0]).all()
    declared = np.stack([box.x_lower[step], box.x_upper[step]])
    check_held(box.agent, step, declared, np.stack([low, high]), bounded_inputs=bool(inputs))
    box.x_lower[step] = np.fmax(box.x_lower[step], low)  # NaN is no knowledge
    box.x_upper[step] = np.fmin(box.x_upper[step], high)


def image(matrix: Floats, lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
    """Interval of matrix @ v for v in [lower, upper]; 0 times infinity counts as 0."""
    with np.errstate(over="ignore", invalid="ignore"):
        a = np.where(matrix == 0, 0.0, matrix * lower)
        b = np.where(matrix == 0, 0.0, matrix * upper)
    return np.minimum(a, b).sum(axis=-1), np.maximum(a, b).sum(axis=-1)
