"""Directions of a car's plan: the rows let through what its steering can follow, all of that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.driving import along, driven

from stlc import api
from stlc.backends import get
from stlc.backends.base import SolveOptions
from stlc.milp.compile import Compiled, compile_mission
from stlc.robots import Steering, turned

TEXT = """step 1 s
horizon 6
dynamics van = car {{ speed <= 2; wheelbase 0.3; steering <= 40 deg }}
agent r : van {{ start (0, 0); heading {heading} deg }}
require on: always[6] r.x <= 1000
"""


def _compiled(heading: float) -> Compiled:
    return compile_mission(api.loads(TEXT.format(heading=heading)))


def _best(compiled: Compiled, cost: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """States and inputs of the least sum of costs (T, 2) times inputs."""
    model = compiled.model
    c = np.zeros(len(model.c))
    c[compiled.layout.inputs["r"]] = cost
    solution = get("highs").solve(replace(model, c=c), SolveOptions(time_limit=60.0))
    if solution.x is None:
        return None
    return solution.x[compiled.layout.states["r"]], solution.x[compiled.layout.inputs["r"]]


@pytest.mark.parametrize("heading", [0, 100, -173])
def test_every_plan_of_the_model_can_be_steered(heading: float) -> None:
    compiled = _compiled(heading)
    robot = compiled.mission.agents["r"].robot
    rng = np.random.default_rng(heading % 360)
    sharpest = 0.0
    for _ in range(3):
        states, _ = _best(compiled, rng.standard_normal((6, 2)))
        found = driven(robot, states, 1.0)
        off = np.linalg.norm(found.centres - along(states, found.times), axis=1)
        assert off.max() <= robot.radius + 1e-6
        moving = np.abs(found.speeds) > 1e-4
        sharpest = max(sharpest, float(np.abs(found.turns[moving]).max()))
        assert found.speeds.min() >= -1e-6
    assert np.radians(15) < sharpest <= np.radians(40) + 1e-4


def test_the_rows_are_those_of_the_directions_and_nothing_more() -> None:
    compiled = _compiled(30.0)
    robot = compiled.mission.agents["r"].robot
    steering = Steering.of(robot)
    model, u = compiled.model, compiled.layout.inputs["r"]
    rng = np.random.default_rng(5)
    kept = 0
    for _ in range(10):
        moves = _moves(steering, rng, robot.planned_speed * 0.98)
        lower, upper = model.col_lower.copy(), model.col_upper.copy()
        lower[u] = upper[u] = moves
        solution = get("highs").solve(
            replace(model, col_lower=lower, col_upper=upper), SolveOptions(time_limit=60.0)
        )
        allowed = _allowed(steering, robot.heading, moves)
        assert (solution.x is not None) is allowed
        kept += allowed
    assert 3 <= kept <= 7


def _moves(steering: Steering, rng: np.random.Generator, most: float) -> np.ndarray:
    """Ways that turn a little, some too early."""
    at, moves = round(np.radians(30) / steering.spacing), []
    for _ in range(6):
        at += int(rng.choice([-1, 0, 0, 1]))
        length = most if rng.random() < 0.7 else 0.5 * steering.run_up
        angle = (at + rng.uniform(-0.45, 0.45)) * steering.spacing
        moves.append(length * np.array([np.cos(angle), np.sin(angle)]))
    return np.array(moves)


def _allowed(steering: Steering, heading: float, moves: np.ndarray) -> bool:
    """By trying all directions: which of them each step may have ended in."""
    angles = steering.directions()
    now = {k for k, held in enumerate(steering.held(heading)) if held}
    for move in moves:
        way, length = np.arctan2(move[1], move[0]), float(np.hypot(*move))
        after = set()
        for k, angle in enumerate(angles):
            off = turned(way, angle)
            if length > 0 and abs(off) > steering.spacing / 2.0:
                continue
            beside = {(k - 1) % len(angles), (k + 1) % len(angles)}
            turns = bool(now & beside) and length * np.cos(off) >= steering.run_up
            if k in now or turns:
                after.add(k)
        now = after
    return bool(now)
