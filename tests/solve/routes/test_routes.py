"""Plans by beams over states and progress."""

from __future__ import annotations

import numpy as np
import pytest
from support.route_missions import collecting, optimum
from support.worlds import value

from stlc.api import loads, solve
from stlc.backends import get
from stlc.backends.base import Solution, SolveOptions
from stlc.milp.compile import Compiled, compile_mission
from stlc.milp.violations import violations
from stlc.record import changed
from stlc.solve import tuning
from stlc.solve.outcome import SolveSettings
from stlc.solve.routes.finder import Effort, Routes
from stlc.solve.routes.tube import covers, tube
from stlc.solve.strategies import ROUTES, run_strategy
from stlc.solve.strategy import Work

DOOR = """step 1 s
horizon 16
workspace box [0, 10] x [0, 10]
agent r : {kind} {{ start (1, 1); control |u| <= {push}; {more} }}
obstacle wall = box [4, 5] x [0, 7]
region key = box [1, 3] x [8, 10]
region door = box [4, 5] x [6.5, 10]
region goal = box [8, 10] x [0, 2]
require clear: always r outside wall swept
require unlock: (r outside door swept) until r in key
require arrive: eventually[{early}, 16] r in goal
minimize effort
"""
PATROL = """step 1 s
horizon 13
workspace box [0, 6] x [0, 6]
agent r : single_integrator { start (3, 3); control |u| <= 2 }
region A = box [0, 1] x [0, 1]
region B = box [5, 6] x [0, 1]
require patrol: forall g in regions: always[0, 6] eventually[0, 6] r in g
minimize effort
"""
DATA = collecting(
    14, "(10, 0)", "eventually[0, 12] always[0, 2] rssi(r, a) >= -60 dBm",
    "eventually[12, 14] rssi(r, b) >= -60 dBm",
)  # fmt: skip
SINGLE = DOOR.format(kind="single_integrator", push=2, more="", early=0)
DOUBLE = DOOR.format(kind="double_integrator", push=1, more="speed <= 2", early=4)


def compiled(text: str) -> Compiled:
    return compile_mission(loads(text))


@pytest.mark.parametrize("text", [SINGLE, DOUBLE, PATROL, DATA])
def test_run_is_a_plan(text: str) -> None:
    """It moves by the dynamics, and the model has a point with its states and inputs."""
    one = compiled(text)
    runs = Routes.of(one, lambda: False).team(Effort(1500, 2, 0.0, 1.0))
    assert runs is not None
    dynamics = one.mission.agents["r"].dynamics
    x, u = runs.states["r"], runs.inputs["r"]
    np.testing.assert_allclose(x[1:], x[:-1] @ dynamics.A.T + u @ dynamics.B.T + dynamics.drift)
    point = get("highs").solve(tube(one, runs.states, 1e-4), SolveOptions()).x
    assert point is not None
    assert violations(one.model, point).within(1e-6)


def test_stops_when_asked_and_finds_none_where_there_is_none() -> None:
    one = compiled(SINGLE)
    assert Routes.of(one, lambda: True).team(Effort(500, 2, 0.0, 1.0)) is None
    locked = compiled(SINGLE.replace("region key = box [1, 3] x [8, 10]",
                                     "region key = box [6, 7] x [8, 10]"))  # fmt: skip
    assert Routes.of(locked, lambda: False).team(Effort(500, 2, 0.0, 1.0)) is None


def answer(text: str, monkeypatch: pytest.MonkeyPatch) -> tuple[Compiled, Solution]:
    """By routes alone: no glance at the whole model."""
    monkeypatch.setattr(tuning, "ROUTES", changed(tuning.ROUTES, glance=0.0))
    one = compiled(text)
    return one, run_strategy("routes", one, get("highs"), SolveOptions(time_limit=60.0))


@pytest.mark.parametrize("text", [SINGLE, PATROL])
def test_proves_what_the_whole_model_proves(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    one, found = answer(text, monkeypatch)
    best = optimum(one)
    assert found.objective is not None
    assert found.bound is not None
    assert found.objective == pytest.approx(best, rel=2e-4)
    assert found.bound <= best + 1e-6


def test_plan_comes_from_routes_and_keeps_the_mission(monkeypatch: pytest.MonkeyPatch) -> None:
    quick = changed(tuning.ROUTES, glance=0.0, better_seconds=1.0, climb_rounds=2)
    monkeypatch.setattr(tuning, "ROUTES", quick)
    work = Work.of(compiled(DOUBLE), get("highs"), SolveOptions(time_limit=60.0))
    assert ROUTES.applies(work)
    done = ROUTES.run(work)
    assert isinstance(done, Work)
    assert done.finder == "routes"
    x = done.x
    assert x is not None
    run = work.compiled.decode(x)
    assert min(value(r.formula, run) for r in work.compiled.mission.requirements) >= -1e-6
    assert ROUTES.applies(work.with_point(x, ""))  # one agent alone: a bound is to be had


def test_team_takes_turns() -> None:
    """Two that have to swap places in a corridor with one bay: the one that waits goes second."""
    team = loads("""step 1 s
horizon 12
workspace box [0, 8] x [0, 4]
agent a : single_integrator { start (1, 1); control |u| <= 1 }
agent b : single_integrator { start (7, 1); control |u| <= 1 }
obstacle wall = box [0, 8] x [2, 4]
region right = box [6, 8] x [0, 2]
region left = box [0, 2] x [0, 2]
require clear: always forall r in agents: r outside wall swept
require apart: always separation(a, b) >= 0.9 m
require swap: eventually[12] (a in right and b in left)
minimize effort
""")
    one = compile_mission(team)
    runs = Routes.of(one, lambda: False).team(Effort(1500, 2, 0.0, 1.0))
    assert runs is not None
    far = np.abs(runs.states["a"] - runs.states["b"]).max(axis=1)
    assert far.min() >= 0.9 - 1e-6
    assert solve(team, SolveSettings(time_limit=60.0)).report.ok


def test_turns_hear_those_before_them() -> None:
    """The second of two that have to hear each other knows where the first one is."""
    one = compiled("""step 1 s
horizon 6
workspace box [0, 12] x [0, 12]
agent a : single_integrator { start (1, 1); control |u| <= 2 }
agent b : single_integrator { start (2, 10); control |u| <= 2 }
channel radio { path_loss L0 = -40 dBm, n = 3; partition 6 x 6 }
region far = box [9, 11] x [1, 3]
region high = box [9, 11] x [9, 11]
require reach: eventually[4, 6] (a in far and b in high)
require hear: eventually[2, 3] rssi(a, b, radio) >= -62 dBm
minimize effort
""")
    runs = Routes.of(one, lambda: False).team(Effort(1500, 2, 0.0, 1.0))
    assert runs is not None
    point = get("highs").solve(tube(one, runs.states, 1e-4), SolveOptions()).x
    assert point is not None
    assert violations(one.model, point).within(1e-6)


def test_tube_that_covers_is_the_model() -> None:
    one = compiled(PATROL)
    run = {"r": np.full((14, 2), 3.0)}
    assert covers(one.model, tube(one, run, 10.0))
    tight = tube(one, run, 1.0)
    assert not covers(one.model, tight)
    columns = one.states["r"][6]
    assert tight.col_upper[columns] == pytest.approx([4.0, 4.0])
