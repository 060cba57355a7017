"""Runs of lattices and the search that follows them."""

from __future__ import annotations

import numpy as np
import pytest
from generators.stlpy import door_puzzle
from support.worlds import value

from stlc.api import loads
from stlc.milp.compile import Compiled, compile_mission
from stlc.solve.heuristics.dive import find_start
from stlc.solve.heuristics.references import reference_points

HEAD = """step 1 s
horizon {steps}
workspace box [0, 10] x [0, 10]
dynamics cart = double_integrator
agent r : cart {{
  start (1, 1)
  control |u| <= 1
  state |v| <= 2
}}
region wall = box [4, 5] x [0, 7]
region key = box [1, 3] x [8, 10]
region door = box [6, 7] x [0, 10]
region goal = box [8, 10] x [0, 2]
require clear: always r outside wall
require unlock: (r outside door) until r in key
require arrive: eventually r in goal
maximize robustness
"""


def compiled(steps: int) -> Compiled:
    return compile_mission(loads(HEAD.format(steps=steps)))


def test_exact_guide_takes_what_holds_and_nothing_else() -> None:
    one = compiled(16)
    aim = 0.9 * one.robustness[None][2]
    preference = next(reference_points(one, lambda level: lambda unit: aim))
    assert ((preference >= 0) & (preference <= 1)).all()
    taken = [sum(preference[column] == 1.0 for _, column in pairs)
             for encoded in one.layout.encoded for _, pairs in encoded.choices]  # fmt: skip
    assert set(taken) == {0, 1}  # none where the door is passed after it was opened


@pytest.mark.parametrize("steps", [14, 20])
def test_start_reaches_the_bound_around_a_wall_and_through_a_door(steps: int) -> None:
    one = compiled(steps)
    start = find_start(one)
    assert start is not None
    assert start.is_optimal(1e-4)
    assert find_start(one, over=lambda: True) is None
    run = one.decode(start.x)
    worst = min(value(r.formula, run) for r in one.mission.requirements)
    assert worst == pytest.approx(-start.objective, abs=1e-6)


def test_no_guide_where_there_is_no_run() -> None:
    one = compiled(16)
    assert not list(reference_points(one, lambda level: lambda unit: 1.5))
    assert np.isfinite(one.robustness[None][2])


def test_a_run_through_three_doors_is_found_by_its_guide() -> None:
    start = find_start(compile_mission(loads(door_puzzle(30, 3))))
    assert start is not None
    assert start.is_optimal(1e-4)
    assert start.lps < 100
