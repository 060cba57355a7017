"""No way without width: what touches is closed, for planner and verifier alike."""

from __future__ import annotations

import pytest

from stlc.api import loads
from stlc.errors import InfeasibleError
from stlc.mission import Mission
from stlc.solve.driver import solve_mission
from stlc.solve.outcome import Outcome, SolveSettings

HEAD = """
step 1 s
workspace box [0, 10] x [0, 10]
agent r : double_integrator {{ start {start}; control |u| <= 2; speed <= 3 }}
region goal = box {goal}
{obstacles}
require clear: always[0, {steps}] forall o in obstacles: r outside o swept
require reach: eventually[0, {steps}] r in goal
minimize effort
"""


def mission(obstacles: str, start: str, goal: str, steps: int) -> Mission:
    text = HEAD.format(obstacles=obstacles, start=start, goal=goal, steps=steps)
    return loads(text)


def solve(obstacles: str, start: str, goal: str, steps: int = 7) -> Outcome:
    settings = SolveSettings(threads=1)
    return solve_mission(mission(obstacles, start, goal, steps), settings)


ACROSS = {
    "a wall from border to border": "obstacle w = box [5, 5.5] x [0, 10]",
    "two pieces end to end": "obstacle w = box [4, 5] x [-1, 5] + box [4, 5] x [5, 11]",
    "pieces side by side": "obstacle w = box [4, 5] x [0, 6] + box [5, 6] x [4, 10]",
    "pieces that meet in a corner": "obstacle w = box [4, 5] x [0, 5] + box [5, 6] x [5, 10]",
    "one piece inside another": "obstacle w = box [4, 6] x [0, 10] + box [4, 5] x [2, 5]",
    "a T": "obstacle w = box [3, 7] x [4, 5] + box [4, 5] x [5, 10] + box [5, 6] x [0, 4]",
    "three pieces at a point": (
        "obstacle w = box [4, 6] x [0, 5] + box [4, 5] x [5, 10] + box [5, 6] x [5, 10]"
    ),
    "a corner on an edge": ("obstacle w = polygon (4, 0) (6, 0) (5, 5) + box [4, 6] x [5, 10]"),
    "a corner on the border": "obstacle w = polygon (5, 0) (6, 5) (5, 10) (4, 5)",
    "flush diagonals": (
        "obstacle w = polygon (3, 0) (5, 0) (5.1, 4.7) (3.7, 4.3)"
        " + polygon (3.7, 4.3) (5.1, 4.7) (5, 10) (3, 10)"
    ),
    "a cut polygon": "obstacle w = polygon (4, 0) (6, 0) (6, 10) (4, 10) (4, 6) (5, 5) (4, 4)",
    "inflated until they touch": (
        "obstacle w = box [4, 5] x [0.25, 4.75] + box [4, 5] x [5.25, 9.75] inflate 0.25 m"
    ),
    "a piece less than a tolerance from another": (
        "obstacle w = box [4, 5] x [-1, 5] + box [4, 5] x [5.0000002, 11]"
    ),
}


@pytest.mark.parametrize("obstacle", ACROSS.values(), ids=ACROSS.keys())
def test_no_way_through(obstacle: str) -> None:
    with pytest.raises(InfeasibleError):
        solve(obstacle, "(1, 5)", "[8, 9] x [4, 6]")


def apart(text: str) -> str:
    """The same pieces as obstacles of their own."""
    body, _, grow = text.removeprefix("obstacle w = ").partition(" inflate ")
    parts = body.split(" + ")
    end = f" inflate {grow}" if grow else ""
    return "\n".join(f"obstacle w{k} = {part}{end}" for k, part in enumerate(parts))


SEVERAL = {name: apart(text) for name, text in ACROSS.items() if " + " in text}


@pytest.mark.parametrize("obstacles", SEVERAL.values(), ids=SEVERAL.keys())
def test_no_way_between_obstacles(obstacles: str) -> None:
    with pytest.raises(InfeasibleError):
        solve(obstacles, "(1, 5)", "[8, 9] x [4, 6]")


def test_obstacles_of_several_requirements_are_closed_while_both_hold() -> None:
    text = """
step 1 s
workspace box [0, 10] x [0, 10]
agent r : double_integrator { start (1, 5); control |u| <= 2; speed <= 3 }
region goal = box [8, 9] x [4, 6]
obstacle low = box [4, 5] x [0, 5]
obstacle high = box [4, 5] x [5, 10]
require a: always[0, 7] r outside low swept
require b: always[%d, 7] r outside high swept
require c: eventually[0, 7] r in goal
minimize effort
"""
    with pytest.raises(InfeasibleError):
        solve_mission(loads(text % 1), SolveSettings(threads=1))
    assert solve_mission(loads(text % 6), SolveSettings(threads=1)).report.ok


@pytest.mark.parametrize(
    "obstacle",
    [
        "obstacle w = box [4, 5] x [0, 4.9] + box [4, 5] x [5.1, 10]",
        "obstacle w = box [4, 5] x [0, 5] + box [5.2, 6] x [4, 10]",
        "obstacle w = box [4, 5] x [0, 9.9]",
        "obstacle w = polygon (5, 0.2) (6, 5) (5, 10) (4, 5)",
    ],
)
def test_a_gap_is_a_way(obstacle: str) -> None:
    assert solve(obstacle, "(1, 5)", "[8, 9] x [4, 6]", 9).report.ok
