"""Random problems of the relaxation, and runs that keep all they ask, by simulation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.solve.relaxation.problem import Axis, Body, Problem
from stlc.solve.states.layers import Layer, Maker, rate_borders
from stlc.solve.states.tubes import tubes

SIDE, SPEED = 3.0, 1.0


@dataclass(frozen=True)
class Walk:
    """Positions and rates (T+1, 2) of one agent."""

    p: Floats
    w: Floats


def problem_of(
    rng: np.random.Generator, agents: int = 2, steps: int = 3, cells: int = 3
) -> Problem:
    """Double integrators on a square; every pair has random costs over cells, and every agent."""
    bodies = tuple(_body(rng, f"a{n}", steps) for n in range(agents))
    count = cells**2
    pairs = {
        (i, j): (None, *rng.uniform(0, 2, (steps, count, count)))
        for i in range(agents) for j in range(i + 1, agents)
    }  # fmt: skip
    alone = tuple((None, *rng.uniform(0, 1, (steps, count))) for _ in range(agents))
    edges = np.linspace(0, SIDE, cells + 1)
    return Problem(
        steps, (edges, edges), bodies, pairs, alone, 0.0, np.zeros(count, np.int64), b"random"
    )


def _body(rng: np.random.Generator, name: str, steps: int) -> Body:
    box = np.tile([0.0, SIDE, -SPEED, SPEED], (steps + 1, 1))
    axes = tuple(
        Axis(
            d, d + 2, 1.0, (float(rng.uniform(0.5, 2.5)), float(rng.uniform(-0.3, 0.3))), 0.5, 0.6,
            box, rng.uniform(0, 1, steps + 1), rng.uniform(0, 1, steps),
        )
        for d in (0, 1)
    )  # fmt: skip
    angles = np.arange(8) * np.pi / 4
    faces = np.stack([np.cos(angles), np.sin(angles), np.full(8, SPEED)], 1)
    return Body(name, (axes[0], axes[1]), faces, {})


def layers_of(problem: Problem, bins: int = 2) -> list[list[Layer]]:
    """All states of each agent at each step, rates in `bins` ranges."""
    out = []
    for body in problem.bodies:
        sets = tubes(body, problem.steps)
        borders = (rate_borders(body.axes[0], bins), rate_borders(body.axes[1], bins))
        out.append(Maker(problem, body, sets, sets.possible, borders).layers())
    return out


def walks(rng: np.random.Generator, body: Body, steps: int, count: int) -> list[Walk]:
    """Runs of a body by random changes of its rate; those that leave a box are thrown away."""
    found: list[Walk] = []
    while len(found) < count:
        p, w = np.zeros((2, steps + 1, 2))
        for d, axis in enumerate(body.axes):
            p[0, d], w[0, d] = axis.start
            for t in range(steps):
                w[t + 1, d] = w[t, d] + rng.uniform(-axis.jump, axis.jump)
                p[t + 1, d] = p[t, d] + (1 - axis.blend) * w[t, d] + axis.blend * w[t + 1, d]
        slow = (w[1:] @ body.faces[:, :2].T <= body.faces[:, 2]).all()
        if (p >= 0).all() and (p <= SIDE).all() and slow:
            found.append(Walk(p, w))
    return found


def effort(body: Body, walk: Walk) -> float:
    """What the run costs without cells, from the definitions of `rate_cost` and `change_cost`."""
    return float(sum(
        axis.rate_cost[1:] @ np.abs(walk.w[1:, d])
        + axis.change_cost @ np.abs(np.diff(walk.w[:, d]))
        for d, axis in enumerate(body.axes)
    ))  # fmt: skip


def cells(problem: Problem, walk: Walk) -> Ints:
    """(T+1,) cells of a run; random ones are never on a border."""
    x, y = (np.searchsorted(problem.edges[d], walk.p[:, d], side="right") - 1 for d in (0, 1))
    return np.asarray(x * problem.shape[1] + y)


def cost(problem: Problem, runs: list[Walk]) -> float:
    """All that the problem counts of a run of each agent."""
    at = [cells(problem, run) for run in runs]
    total = sum(effort(b, r) for b, r in zip(problem.bodies, runs, strict=True))
    for t in range(1, problem.steps + 1):
        for (i, j), tables in problem.pairs.items():
            table = tables[t]
            total += 0.0 if table is None else table[at[i][t], at[j][t]]
        for n, own in enumerate(problem.alone):
            row = own[t]
            total += 0.0 if row is None else row[at[n][t]]
    return float(total)


def holding(layer: Layer, walk: Walk, t: int) -> Ints:
    """The states of a layer whose boxes hold the run at step t."""
    fine = np.ones(len(layer), bool)
    for d, (grid, index) in enumerate(((layer.x, layer.ix), (layer.y, layer.iy))):
        box = grid.box[index]
        fine &= (box[:, 0] <= walk.p[t, d] + 1e-9) & (walk.p[t, d] <= box[:, 1] + 1e-9)
        fine &= (box[:, 2] <= walk.w[t, d] + 1e-9) & (walk.w[t, d] <= box[:, 3] + 1e-9)
    return np.flatnonzero(fine)
