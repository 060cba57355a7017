"""Obstacles as rooms of free space, or apart where they are islands and only effort counts."""

from __future__ import annotations

import pytest
from support.route_missions import optimum

from stlc.api import loads
from stlc.milp.compile import CompileOptions, compile_mission

MISSION = """step 1 s
horizon 4
workspace box [0, 9] x [0, 9]
agent r : single_integrator {{ start (0.5, 4); control |u| <= 2.5 }}
obstacle a = box [2, 3] x [3, 5]
obstacle b = polygon (6.6, 3.4) (7.6, 4.4) (6.6, 5.4) (5.6, 4.4)
obstacle low = box [4, 5] x [-1, 3]
obstacle high = box [4, 5] x [5, 10]
region goal = box [8, 9] x [5, 6]
require clear: always forall o in obstacles: r outside o
require arrive: eventually r in goal
{objective}
"""
EFFORT, LEVEL = "minimize effort", "maximize robustness"


@pytest.mark.parametrize(("objective", "widest"), [(EFFORT, 4), (LEVEL, 8)])
def test_islands_stay_apart_where_only_effort_counts(objective: str, widest: int) -> None:
    compiled = compile_mission(loads(MISSION.format(objective=objective)))
    sizes = [len(pairs) for one in compiled.layout.encoded for _, pairs in one.choices]
    assert max(sizes) == widest


@pytest.mark.parametrize("objective", [EFFORT, LEVEL])
def test_the_optimum_is_that_without_the_pass(objective: str) -> None:
    mission = loads(MISSION.format(objective=objective))
    plain = compile_mission(mission, CompileOptions(disabled_passes=frozenset({"distribute"})))
    assert optimum(compile_mission(mission)) == pytest.approx(optimum(plain), abs=1e-5)
