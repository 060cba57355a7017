"""Bounds by grids: never above the optimum of the whole model, and near it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.route_missions import boxes, optimum

from stlc.api import loads
from stlc.backends import get
from stlc.backends.base import SolveOptions, Status
from stlc.errors import InfeasibleError
from stlc.milp.compile import Compiled, compile_mission
from stlc.record import changed
from stlc.solve import tuning
from stlc.solve.routes.finder import Routes
from stlc.solve.routes.loose import fits
from stlc.solve.routes.play import play_of
from stlc.solve.routes.traced import traced
from stlc.solve.routes.tube import within
from stlc.solve.strategies import GRIDS, ROUTES, run_strategy
from stlc.solve.strategy import Work

DOOR = """step {step} s
horizon {steps}
workspace box [0, 10] x [0, 10]
agent r : single_integrator {{ start (1, 1); control |u| <= 2; effort_input ({price}, 1) }}
obstacle wall = box [4, 5] x [0, 7]
region key = box [1.3, 3] x [8, 9.1]
region door = box [4, 5] x [6.5, 10]
region goal = box [8, 9.7] x [0, 2.2]
require clear: always r outside wall swept
require unlock: (r outside door swept) until r in key
require arrive: eventually r in goal
minimize {weight} * effort
"""
TILTED = """step 1 s
horizon 8
workspace box [0, 9] x [0, 9]
agent r : single_integrator { start (4.3, 4.1); control |u| <= 2 }
obstacle rock = polygon (3, 5) (5, 5) (4, 7)
region top = polygon (3.5, 8) (4.5, 8) (4, 9)
region low = box [3, 3.8] x [0, 1.3]
require clear: always r outside rock swept
require speed: always norm1(r.ux, r.uy) <= 2.5 m/s
require see: eventually[0, 4] always[0, 1] r in top
require back: eventually[6, 8] r in low
require near: always[0, 6] (r.y >= 5 m or eventually[0, 2] r.x <= 4 m)
minimize effort
"""
TEAM = """step 1 s
horizon 6
workspace box [0, 8] x [0, 8]
agent a : single_integrator { start (1, 1); control |u| <= 2 }
agent b : single_integrator { start (7, 1); control |u| <= 2 }
region right = box [6, 8] x [0, 2]
region left = box [0, 2] x [0, 2]
require apart: always separation(a, b) >= 1 m
require swap: eventually (a in right and b in left)
minimize effort
"""
APART = TEAM.replace(
    "eventually (a in right and b in left)", "(eventually a.y >= 4 m) and (eventually b.y >= 4 m)"
)
MISSIONS = {
    "door": DOOR.format(step=1, steps=14, price=1, weight=1),
    "prices": DOOR.format(step=0.5, steps=20, price=2.5, weight=0.3),
    "tilted": TILTED,
}


def bound(one: Compiled, name: str, cut: int, most: float = np.inf) -> float:
    grids = Routes.of(one, lambda: False)
    found = play_of(one, name, grids.progress, grids.levels, cut, most, lambda: False).bound()
    assert found is not None
    return found


@pytest.mark.parametrize("name", MISSIONS)
def test_bounds_stay_below_the_optimum_and_come_near(name: str) -> None:
    one = compile_mission(loads(MISSIONS[name]))
    assert fits(one, "r")
    best = optimum(one)
    found = [bound(one, "r", cut, 1.2 * best) for cut in (1, 2, 3, 6)]
    assert max(found) <= best + 1e-6
    assert found[-1] >= 0.9 * best
    assert bound(one, "r", 3, 0.5 * best) == pytest.approx(min(0.5 * best, found[2]))


@pytest.mark.parametrize("name", MISSIONS)
def test_run_of_a_bound_leads_to_a_cheap_plan(name: str) -> None:
    """It begins at the start, ends where the mission does, and a plan near it is hardly dearer."""
    one = compile_mission(loads(MISSIONS[name]))
    grids, best = Routes.of(one, lambda: False), optimum(one)
    grid = play_of(one, "r", grids.progress, grids.levels, 3, 1.2 * best, lambda: False)
    assert traced(grid) is None  # not yet bounded
    assert grid.bound() is not None
    run = traced(grid)
    assert run is not None
    low, high = run
    assert (low[0] <= (one.mission.agents["r"].start)).all()
    assert ((high - low)[1:] <= 2 * grid.widest + 1e-2).all()
    near = within(one, {"r": run}, 2 * grid.widest, 2)
    found = get("highs").solve(near, SolveOptions(gap=1e-6))
    assert found.objective is not None
    assert best - 1e-6 <= found.objective <= 1.1 * best
    grid.most = 0.5 * best
    grid.bound()
    assert traced(grid) is None


SIZES = st.floats(0.4, 1.9)


@settings(max_examples=15)
@given(
    st.tuples(*[st.floats(0.2, 6.8)] * 6), st.tuples(*[SIZES] * 6), st.integers(1, 3),
    st.sampled_from(["eventually[2, 4] always[0, 1]", "always[0, 2] eventually[0, 3]"]),
)  # fmt: skip
def test_no_random_optimum_is_below_its_bound(
    corners: tuple[float, ...], sizes: tuple[float, ...], cut: int, often: str
) -> None:
    a, b, rock = boxes(corners, sizes)
    text = f"""step 1 s
horizon 5
workspace box [0, 9] x [0, 9]
agent r : single_integrator {{ start (4.5, 4.5); control |u| <= 3; effort_input (1, 2) }}
region a = {a}
region b = {b}
region rock = {rock}
require see: {often} r in a
require visit: (r outside a) until r in b
require clear: always r outside rock swept
minimize effort
"""
    try:
        one = compile_mission(loads(text))
    except InfeasibleError:
        return
    found = get("highs").solve(one.model, SolveOptions(gap=1e-7, time_limit=20.0))
    if found.status is Status.OPTIMAL:
        assert found.objective is not None
        assert bound(one, "r", cut) <= found.objective + 1e-5


def test_team_is_bounded_by_its_members() -> None:
    one = compile_mission(loads(TEAM))
    both = sum(bound(one, name, 4) for name in ("a", "b"))
    assert 0.5 * optimum(one) <= both <= optimum(one) + 1e-6


@pytest.mark.parametrize(("old", "new"), [
    ("single_integrator", "double_integrator"),
    ("minimize effort", "minimize effort[0, 5]"),
    ("minimize effort", "maximize robustness"),
])  # fmt: skip
def test_speaks_of_nothing_else(old: str, new: str) -> None:
    assert fits(compile_mission(loads(TEAM)), "a")
    assert not fits(compile_mission(loads(TEAM.replace(old, new))), "a")


def test_bound_is_that_of_the_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    """The rows and the bound leave the optimum where it is."""
    quick = changed(tuning.ROUTES, glance=0.0, better_seconds=0.0, cuts=(1, 2))
    monkeypatch.setattr(tuning, "ROUTES", quick)
    one = compile_mission(loads(TILTED))
    found = run_strategy("routes", one, get("highs"), SolveOptions(time_limit=100.0, gap=1e-6))
    assert found.status is Status.OPTIMAL
    assert found.objective == pytest.approx(optimum(one), abs=1e-5)


def test_team_on_grids_is_planned_and_proven_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """`grids` ahead of `turns`; it leaves other agents, and teams that have a plan, alone."""
    monkeypatch.setattr(tuning, "ROUTES", changed(tuning.ROUTES, glance=0.0))
    one = compile_mission(loads(APART))
    work = Work.of(one, get("highs"), SolveOptions(time_limit=60.0))
    assert GRIDS.applies(work)
    found = run_strategy("grids", one, get("highs"), work.options)
    assert found.status is Status.OPTIMAL
    assert found.x is not None
    assert found.objective == pytest.approx(optimum(one), abs=1e-3)
    assert not GRIDS.applies(work.with_point(found.x, ""))
    heavy = compile_mission(loads(APART.replace("single_integrator", "double_integrator")))
    assert not GRIDS.applies(Work.of(heavy, get("highs"), SolveOptions()))


def test_plan_comes_from_grids_where_beams_find_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are not even tried here."""
    grids: dict[str, Any] = {"efforts": ((1, 1, 0.0, 1.0),), "first_efforts": 0}
    quick = changed(tuning.ROUTES, glance=0.0, better_seconds=0.0, **grids)
    monkeypatch.setattr(tuning, "ROUTES", quick)
    one = compile_mission(loads(MISSIONS["door"]))
    done = ROUTES.run(Work.of(one, get("highs"), SolveOptions(time_limit=60.0, gap=1e-6)))
    assert isinstance(done, Work)
    assert done.finder == "routes"
    assert done.value <= 1.05 * optimum(one)


def test_gives_up_when_asked() -> None:
    one = compile_mission(loads(TILTED))
    grids = Routes.of(one, lambda: False)
    grid = play_of(one, "r", grids.progress, grids.levels, 3, np.inf, lambda: True)
    assert grid.bound() is None
