"""Small missions built directly, their optimum by HiGHS, and by enumeration of cell sequences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.optimize import linprog

from stlc.analysis.ranges import Ranges
from stlc.backends.base import SolveOptions, Status
from stlc.backends.highs import Highs
from stlc.dynamics import Dynamics
from stlc.milp.builder import ModelBuilder
from stlc.milp.context import Context
from stlc.milp.dynamics import add_agents
from stlc.milp.model import Model
from stlc.mission import Agent, Channel, Mission, Station
from stlc.radio.partition import Partition, quadtree, uniform_grid
from stlc.source import Source

SINGLE = Dynamics(
    "single", np.eye(2), np.eye(2), np.zeros(2), ("px", "py"), ("ux", "uy"),
    ("m", "m"), ("m/s", "m/s"), np.eye(2),
)  # fmt: skip
DOUBLE = Dynamics(
    "double",
    np.array([[1.0, 0, 1, 0], [0, 1, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]]),
    np.array([[0.5, 0], [0, 0.5], [1, 0], [0, 1]]),
    np.zeros(4), ("px", "py", "vx", "vy"), ("ux", "uy"),
    ("m", "m", "m/s", "m/s"), ("m/s^2", "m/s^2"), np.eye(2, 4), (2, 3),
)  # fmt: skip


@dataclass(frozen=True)
class World:
    """Agents in a square [0, side]^2 and one channel over a partition of it."""

    starts: Mapping[str, tuple[float, float]]
    partition: Partition
    steps: int = 3
    u_max: float = 1.0
    v_max: float = 2.0
    side: float = 3.0
    dynamics: Dynamics = SINGLE

    @property
    def channel(self) -> Channel:
        """The channel; only its partition matters here."""
        return Channel("radio", self.partition)

    def agent(self, name: str) -> Agent:
        """An agent at rest at its start."""
        extra = len(self.dynamics.states) - 2
        lower = np.array([0.0, 0.0] + [-self.v_max] * extra)
        upper = np.array([self.side, self.side] + [self.v_max] * extra)
        start = np.array([*self.starts[name], *[0.0] * extra])
        limit = np.full(2, self.u_max)
        zeros = np.zeros(len(start))
        return Agent(name, self.dynamics, start, lower, upper, -limit, limit, zeros, np.ones(2))

    def context(self) -> Context:
        """Columns and dynamics of all agents, ranges by forward interval reach."""
        agents = {name: self.agent(name) for name in self.starts}
        stations = {"base": Station("base", np.array([0.5, 0.5]))}
        mission = Mission(
            Source("world.stl", ""), 1.0, self.steps, None, agents, stations, {}, {},
            {"radio": self.channel}, (), (),
        )  # fmt: skip
        ranges = {name: forward(agent, self.steps) for name, agent in agents.items()}
        ctx = Context(mission, ModelBuilder(), ranges)
        add_agents(ctx)
        return ctx

    def table(self, seed: int, ends: int = 2) -> np.ndarray:
        """Random costs in [0, 5], to one digit so that ties occur."""
        shape = (len(self.partition),) * ends
        return np.random.default_rng(seed).uniform(0, 5, shape).round(1)


def square(cells: int, side: float = 3.0) -> Partition:
    """cells x cells over [0, side]^2."""
    return uniform_grid((0, side), (0, side), cells, cells)


def forward(agent: Agent, steps: int) -> Ranges:
    """Intervals from the start, step by step, cut to the agent's bounds."""
    low, high = [agent.start], [agent.start]
    a_pos, a_neg = np.maximum(agent.dynamics.A, 0), np.minimum(agent.dynamics.A, 0)
    push = np.abs(agent.dynamics.B) @ agent.input_upper
    for _ in range(steps):
        nearest = a_pos @ low[-1] + a_neg @ high[-1] - push
        farthest = a_pos @ high[-1] + a_neg @ low[-1] + push
        low.append(np.maximum(nearest, agent.state_lower))
        high.append(np.minimum(farthest, agent.state_upper))
    states = np.array(low), np.array(high)
    inputs = np.tile(agent.input_lower, (steps, 1)), np.tile(agent.input_upper, (steps, 1))
    return Ranges(*states, *inputs, states[0][:, :2], states[1][:, :2])


def optimum(model: Model, pinned: Mapping[int, float] | None = None) -> float | None:
    """Optimal objective with some columns fixed; None when infeasible."""
    lower, upper = model.col_lower.copy(), model.col_upper.copy()
    for col, value in (pinned or {}).items():
        lower[col] = upper[col] = value
    fixed = replace(model, col_lower=lower, col_upper=upper)
    answer = Highs().solve(fixed, SolveOptions(gap=1e-9))
    assert answer.status in (Status.OPTIMAL, Status.INFEASIBLE), answer
    return answer.objective if answer.status is Status.OPTIMAL else None


def touching(partition: Partition, point: Sequence[float]) -> np.ndarray:
    """Cells that hold a point, straight from the definition."""
    boxes, (x, y) = partition.boxes, point
    inside = (boxes[:, 0] <= x) & (x <= boxes[:, 1]) & (boxes[:, 2] <= y) & (y <= boxes[:, 3])
    return np.flatnonzero(inside)


def cell_sequences(world: World, name: str) -> list[tuple[int, ...]]:
    """Every cell sequence for steps 1..T that some run follows, by depth-first search with LPs."""
    agent, found, stack = world.agent(name), [], [()]
    while stack:
        prefix = stack.pop()
        if len(prefix) == world.steps:
            found.append(prefix)
            continue
        stack.extend(
            (*prefix, c)
            for c in range(len(world.partition))
            if _followable(agent, world.partition, (*prefix, c))
        )
    return found


def _followable(agent: Agent, partition: Partition, cells: tuple[int, ...]) -> bool:
    A, B = agent.dynamics.A, agent.dynamics.B
    steps, n, m = len(cells), *B.shape
    states = steps * n
    matrix, right = np.zeros((states, states + steps * m)), np.zeros(states)
    for t in range(steps):
        rows = slice(t * n, (t + 1) * n)
        matrix[rows, rows] = np.eye(n)
        matrix[rows, states + t * m : states + (t + 1) * m] = -B
        if t:
            matrix[rows, (t - 1) * n : t * n] = -A
    right[:n] = A @ agent.start
    bounds = []
    for cell in cells:
        low, high = agent.state_lower.copy(), agent.state_upper.copy()
        low[:2] = np.maximum(low[:2], partition.boxes[cell, 0::2])
        high[:2] = np.minimum(high[:2], partition.boxes[cell, 1::2])
        bounds += list(zip(low, high, strict=True))
    bounds += list(zip(agent.input_lower, agent.input_upper, strict=True)) * steps
    cost = np.zeros(matrix.shape[1])
    return bool(linprog(cost, A_eq=matrix, b_eq=right, bounds=bounds).status == 0)


def enumerated(world: World, table: np.ndarray) -> float:
    """Least link cost over all pairs of cell sequences."""
    first, second = (np.array(cell_sequences(world, name)) for name in sorted(world.starts))
    total = sum(table[np.ix_(first[:, t], second[:, t])] for t in range(world.steps))
    return float(np.min(total))


def all_pairs(names: Sequence[str]) -> list[tuple[str, str]]:
    """Unordered pairs."""
    return [(a, b) for a, b in product(names, names) if a < b]


def tree() -> Partition:
    """Seven cells: the lower right quarter of the square split once more."""
    start = uniform_grid((0, 3), (0, 3), 2, 2)

    def score(p: Partition) -> np.ndarray:
        corner = (p.boxes[:, 0] >= 1.5) & (p.boxes[:, 3] <= 1.5)
        return (corner & (len(p) == 4)).astype(float)

    return quadtree(start, score, 0.5, 7)
