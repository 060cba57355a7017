"""Boards of grids: moves known at once, ways around obstacles, runs found by few states."""

from __future__ import annotations

import numpy as np
import pytest

from stlc.api import loads
from stlc.backends import get
from stlc.backends.base import Solution, SolveOptions, Status
from stlc.milp.compile import compile_mission
from stlc.solve.heuristics.dive_search import never
from stlc.solve.routes.finder import Routes
from stlc.solve.routes.grid_beam import GridBeam
from stlc.solve.routes.motion_bounds import Bounds
from stlc.solve.routes.play import Play, play_of
from stlc.solve.routes.traced import traced
from stlc.solve.strategy import Work

MISSION = """step 1 s
horizon 12
workspace box [0, 8] x [0, 6]
agent r : single_integrator {{ start (0.9, 1); control |u| <= 2 }}
obstacle wall = box [3, 4] x [0, 4]
region door = box [3, 4] x [3.5, 6]
region key = box {key}
region goal = box [6, 7] x [1, 2]
require clear: always r outside wall swept
require unlock: (r outside door swept) until r in key
require arrive: eventually r in goal
minimize effort
"""
OPEN, SHUT = MISSION.format(key="[1, 2] x [4, 5]"), MISSION.format(key="[6, 7] x [4, 5]")


def play(text: str) -> Play:
    one = compile_mission(loads(text))
    grids = Routes.of(one, never)
    return play_of(one, "r", grids.progress, grids.levels, 1, np.inf, never)


def test_what_is_known_of_all_moves_is_what_is_judged_of_each() -> None:
    board = play(OPEN).board
    alike = [steps for steps in board.alike if len(steps) > 2]
    assert alike
    origins = np.arange(0, len(board.points), 3)
    pairs = np.repeat(origins, len(board.moves)), np.tile(board.moves, (len(origins), 1))
    for t in {t for steps in alike for t in (steps[0], steps[1], steps[-1])}:
        fine, labels, label = board.around(t, origins)
        each, told, which = board.classes(t, *pairs)
        assert (fine.ravel() == each).all()
        assert each.any()
        for k in np.flatnonzero(each).tolist():
            assert labels[label.ravel()[k]] == told[which[k]]


def test_ways_go_around_obstacles() -> None:
    grid = play(OPEN)
    goal = (np.abs(grid.board.points - (6.0, 1.0)) < 1e-9).all(axis=1)
    around, straight = grid.places._ways(goal), grid.places._straight(goal)
    start = int(np.abs(grid.board.points - (0.9, 1.0)).sum(axis=1).argmin())
    assert (around >= straight - 1e-9).all()
    assert straight[start] == pytest.approx(5.1)
    assert around[start] >= 9.0


def test_few_states_find_a_run_that_costs_no_less_than_the_bound() -> None:
    whole = play(OPEN)
    best = whole.bound()
    beam = GridBeam(whole.board, np.inf, never, whole.places, width=40)
    found = beam.bound()
    assert best is not None
    assert found is not None
    assert best <= found < np.inf
    assert (
        max(len(layer.where) for layer in beam.layers)
        <= 40
        < max(len(layer.where) for layer in whole.layers)
    )
    assert traced(beam) is not None


TWO = """step 1 s
horizon 10
workspace box [0, 8] x [0, 6]
agent a : single_integrator { start (0.9, 1); control |u| <= 2 }
agent b : single_integrator { start (7, 1); control |u| <= 2 }
obstacle wall = box [3, 4] x [0, 4]
region right = box [6, 7] x [1, 2]
region left = box [1, 2] x [1, 2]
require clear: always (a outside wall swept and b outside wall swept)
require swap: (eventually a in right) and (eventually b in left)
require apart: always separation(a, b) >= 0.5 m swept
minimize effort
"""


def test_runs_from_crossing_to_crossing_are_a_plan_of_a_team() -> None:
    one = compile_mission(loads(TWO))
    bounds = Bounds.of(one, never)
    assert bounds is not None
    work = Work.of(one, get("highs"), SolveOptions(time_limit=60.0))
    found = bounds.guided(work, never)
    assert found.x is not None
    least = (5.1 + 3.0 + 2.0) + (5.0 + 3.0 + 2.0)  # along, above the wall, and down to the goals
    assert least - 1e-6 <= found.value <= 1.1 * least


def test_a_grid_without_a_run_says_that_there_is_no_plan() -> None:
    one = compile_mission(loads(SHUT))
    bounds = Bounds.of(one, never)
    assert bounds is not None
    found = bounds.better(Work.of(one, get("highs"), SolveOptions(time_limit=60.0)), 1.0)
    assert isinstance(found, Solution)
    assert found.status is Status.INFEASIBLE
