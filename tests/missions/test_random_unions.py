"""Random unions with a gap: plans are followed densely here and enter none of them."""

from __future__ import annotations

import random

import numpy as np
import pytest
import shapely

from stlc.api import loads, solve
from stlc.errors import InfeasibleError
from stlc.solve.driver import SolveSettings

TEXT = """
step 1 s
workspace box [0, 10] x [0, 10]
agent r : double_integrator {{ start (1, 5); control |u| <= 3; speed <= 4 }}
region goal = box [8, 9] x [4, 6]
{obstacles}
require clear: always[0, 7] forall o in obstacles: r outside o swept
require reach: eventually[0, 7] r in goal
minimize effort
"""

Box = tuple[float, float, float, float]


def wall(rng: random.Random, gap: bool) -> list[Box]:
    """Boxes end to end from border to border, of random widths, one left out for a gap."""
    cuts = sorted(rng.sample(range(1, 10), 2))
    found = []
    for low, high in zip([0, *cuts], [*cuts, 10], strict=True):
        left = rng.choice([4.0, 4.5, 5.0])
        found.append((left, left + rng.choice([0.5, 1.0, 1.5]), float(low), float(high)))
    widest = min(range(3), key=lambda k: abs((found[k][2] + found[k][3]) / 2.0 - 5.0))
    return [b for k, b in enumerate(found) if not gap or k != widest]


def declared(boxes: list[Box], together: bool) -> str:
    shapes = [f"box [{x0}, {x1}] x [{y0}, {y1}]" for x0, x1, y0, y1 in boxes]
    if together:
        return f"obstacle w = {' + '.join(shapes)}"
    return "\n".join(f"obstacle w{k} = {shape}" for k, shape in enumerate(shapes))


def parted(boxes: list[Box]) -> bool:
    """Whether the boxes part start from goal: free space has them in different components."""
    blocked = shapely.union_all([shapely.box(x0, y0, x1, y1) for x0, x1, y0, y1 in boxes])
    free = shapely.box(0, 0, 10, 10).difference(blocked.buffer(1e-6, join_style="mitre"))
    ends = shapely.Point(1, 5), shapely.Point(8.5, 5)
    return not any(all(p.intersects(end) for end in ends) for p in shapely.get_parts(free))


@pytest.mark.parametrize("seed", range(6))
def test_no_plan_enters_a_union(seed: int) -> None:
    rng = random.Random(seed)
    boxes = wall(rng, seed % 3 != 0)
    mission = loads(TEXT.format(obstacles=declared(boxes, seed % 2 == 0)))
    if parted(boxes):
        with pytest.raises(InfeasibleError):
            solve(mission, SolveSettings(threads=1))
        return
    run = solve(mission, SolveSettings(threads=1)).plan.runs["r"]
    s = np.linspace(0.0, 1.0, 2001)[:, None]
    union = shapely.union_all([shapely.box(x0, y0, x1, y1) for x0, x1, y0, y1 in boxes])
    core = union.buffer(-1e-6, join_style="mitre")
    for state, force in zip(run.states, run.inputs, strict=False):
        places = state[:2] + s * state[2:4] + s * s * force / 2.0
        assert not shapely.contains_xy(core, places).any()
