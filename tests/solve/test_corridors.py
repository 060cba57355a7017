"""The whole model within tubes around runs of all agents."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stlc import backends
from stlc.api import loads
from stlc.backends.base import SolveOptions
from stlc.milp.compile import compile_mission
from stlc.solve.deadline import Deadline
from stlc.solve.judge import Judge
from stlc.solve.strategies import LONE, run_strategy
from stlc.solve.strategy import Work
from stlc.solve.teams.corridors import Corridor, beside

HIGHS = backends.get("highs")
MEET = """
horizon 4
workspace box [0, 10] x [0, 10]
dynamics cart = single_integrator
agent r1 : cart { start (1, 5); control |u| <= 2.5 }
agent r2 : cart { start (9, 5); control |u| <= 2.5 }
region east = box [8, 10] x [4, 6]
region west = box [0, 2] x [4, 6]
require reach1: eventually r1 in east
require reach2: eventually r2 in west
require apart: always separation(r1, r2) >= 0.4 m swept
minimize effort
"""


def work() -> Work:
    """Two agents that meet head-on, and what each does alone."""
    begun = Work.of(compile_mission(loads(MEET)), HIGHS, SolveOptions(gap=1e-6))
    found = LONE.run(begun)
    assert isinstance(found, Work)
    return found


def test_beside_lone_runs_that_collide_there_is_a_plan_near_the_optimum() -> None:
    lone = work()
    runs = {one.agent: one.run for one in lone.lone if one.run is not None}
    found = beside(lone, runs, Deadline())
    optimum = run_strategy("milp", lone.compiled, HIGHS, lone.options).objective
    assert optimum is not None
    assert optimum - 1e-5 <= found.value <= 1.02 * optimum
    _, report = Judge(loads(MEET), lone.compiled).judge(found.answer(), lone.options)
    assert report.ok, report.text()


def test_tubes_around_a_poor_plan_lead_to_the_optimum() -> None:
    lone = work()
    apart = replace(lone.compiled.model, c=np.zeros(lone.compiled.model.columns))
    for name, side in (("r1", 1.0), ("r2", -1.0)):
        apart.c[lone.compiled.states[name][:, 1]] = side
    poor = lone.with_point(HIGHS.solve(apart, SolveOptions()).x, "far apart")
    corridor, found = Corridor(), poor
    while not corridor.idle:
        found = corridor.better(found, Deadline())
    assert found.value < 0.9 * poor.value
    optimum = run_strategy("milp", lone.compiled, HIGHS, lone.options).objective
    assert found.value == pytest.approx(optimum, rel=0.02)
