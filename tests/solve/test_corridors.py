"""The whole model within tubes around runs of all agents."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

from stlc import backends
from stlc.api import loads
from stlc.backends.base import SolveOptions, Status
from stlc.milp.compile import compile_mission
from stlc.record import changed
from stlc.solve import deadline as deadlines
from stlc.solve import tuning
from stlc.solve.alone.run import Run
from stlc.solve.deadline import Deadline
from stlc.solve.judge import Judge
from stlc.solve.strategies import LONE, run_strategy
from stlc.solve.strategy import Work
from stlc.solve.teams import corridors
from stlc.solve.teams.corridors import Corridor, beside
from stlc.solve.teams.improvement import improve
from stlc.solve.teams.neighbourhoods import Neighbourhoods

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
    found = beside(lone, _alone(lone), Deadline())
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


def test_a_tube_that_holds_nothing_better_is_not_searched_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A wider one that takes too long is not followed by narrower ones that are known."""
    lone = work()
    plan = lone.with_point(HIGHS.solve(lone.compiled.model, lone.options).x, "optimal")
    known = replace(plan.answer(), status=Status.OPTIMAL)
    late = replace(known, status=Status.NO_SOLUTION, x=None)
    monkeypatch.setattr(corridors, "_solved", Mock(side_effect=[known, late]))
    corridor = Corridor()
    corridor.better(plan, Deadline())
    assert not corridor.idle
    corridor.better(plan, Deadline())
    assert corridor.idle
    assert not corridor.moved().idle


def test_neighbourhoods_of_a_pair_never_free_both(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both are the mission itself, which is solved after this."""
    sizes = []
    sweep = Neighbourhoods.sweep
    monkeypatch.setattr(
        Neighbourhoods, "sweep", lambda one, size: sizes.append(size) or sweep(one, size)
    )
    lone = work()
    improve(lone.with_point(beside(lone, _alone(lone), Deadline()).x, "poor"))
    assert set(sizes) == {1}


def _alone(lone: Work) -> dict[str, Run]:
    return {one.agent: one.run for one in lone.lone if one.run is not None}


def test_two_agents_are_searched_as_long_as_their_best_plan_took(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without a time limit too: tubes that never end and better nothing leave the rest to the
    whole model, which is hardly larger."""
    tried: list[float] = []

    def fruitless(self: Corridor, work: Work, deadline: Deadline) -> Work:
        tried.append(deadline.left)
        return work

    clock = SimpleNamespace(monotonic=lambda: 0.02 * len(tried))  # nothing else takes time
    monkeypatch.setattr(deadlines, "time", clock)
    monkeypatch.setattr(Corridor, "better", fruitless)
    monkeypatch.setattr(Neighbourhoods, "sweep", lambda self, size: False)
    monkeypatch.setattr(tuning, "NEAR", changed(tuning.NEAR, moment=0.2, gap=0.0))
    found = improve(replace(work(), bound=0.0))
    assert found.x is not None
    assert 10 <= len(tried) <= 2 * 20
    assert max(tried) <= 2 * 20 * 0.02
