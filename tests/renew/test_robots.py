"""Robots on the way: planned anew with the heading that they have by then."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.driving import driven

from stlc import api
from stlc.errors import UsageError
from stlc.plan import Plan, make_plan, read_plan
from stlc.renew.measured import read_past
from stlc.renew.past import along
from stlc.renew.remaining import remaining
from stlc.verify import verify

TEXT = """step 1 s
workspace box [0, 12] x [0, 12]
agent r : {robot}
region dock = box [1, 4] x [6, 10]
require go: eventually[0, 9] r in dock
"""
CAR = "car { start (5, 2); heading 60 deg; speed <= 2; wheelbase 0.3; steering <= 40 deg }"
UNICYCLE = "unicycle { start (5, 2); heading 10 deg; speed <= 2; turn_rate <= 3; lookahead 0.4 }"


@pytest.mark.parametrize("robot", [CAR, UNICYCLE])
def test_a_robot_goes_on_with_the_heading_that_it_has(robot: str) -> None:
    mission = api.loads(TEXT.format(robot=robot))
    plan = api.solve(mission).plan
    states = plan.runs["r"].states
    left = remaining(mission, along(mission, plan, 4, {})).mission.agents["r"].robot
    truth = driven(mission.agents["r"].robot, states[:5], 1.0).headings[-1]
    assert np.cos(left.heading - truth) == pytest.approx(1.0, abs=1e-9)
    assert np.cos(left.heading - mission.agents["r"].robot.heading) < 0.999
    far = api.replan(mission, plan, 4, {"r": states[4] + np.array([5.0, 1.0])})
    assert not any(v.kind == "tracking" for v in far.report.violations)
    again = api.replan(mission, plan, 4, {"r": states[4] + np.array([0.02, -0.03])})
    assert verify(mission, again.plan).ok


def _at(plan: Plan, step: int, pose: dict[str, float], folder: Path) -> Path:
    file = folder / "now.json"
    file.write_text(json.dumps({"step": step, "states": {"r": pose}}))
    return file


@pytest.mark.parametrize("robot", [CAR, UNICYCLE])
def test_a_robot_goes_on_with_the_heading_that_was_measured(robot: str, tmp_path: Path) -> None:
    """It was turned on the way: the new plan is one that it can follow from there, the file keeps
    the heading, and what it drives in truth stays within its tube."""
    mission = api.loads(TEXT.format(robot=robot))
    agent, plan = mission.agents["r"], api.solve(mission).plan
    states = plan.runs["r"].states
    made = driven(agent.robot, states[:4], 1.0)
    x, y = made.centres[-1]
    heading = float(made.headings[-1]) + 0.3
    pose = {"x": float(x), "y": float(y), "heading": heading}
    past = read_past(_at(plan, 3, pose, tmp_path), mission, plan, 3)
    p = np.array([x, y]) + agent.robot.lookahead * np.array([np.cos(heading), np.sin(heading)])
    np.testing.assert_allclose(past.states["r"][-1], p, atol=1e-12)
    assert remaining(mission, past).mission.agents["r"].robot.heading == pytest.approx(heading)
    again = api.replan(mission, plan, 3, {"r": p}, headings={"r": heading})
    assert again.report.ok
    again.plan.write(tmp_path / "again.json")
    kept = read_plan(tmp_path / "again.json")
    assert kept.runs["r"].headings == {3: heading}
    assert verify(mission, kept).ok
    rest = kept.runs["r"].states[3:]
    start = replace(agent.robot, heading=heading)
    truth = driven(start, rest, 1.0)
    aims = np.column_stack(
        [np.interp(truth.times, np.arange(len(rest)), rest[:, k]) for k in (0, 1)]
    )
    assert np.linalg.norm(truth.centres - aims, axis=1).max() <= agent.robot.radius + 1e-6
    twice = api.replan(mission, kept, 5, {"r": kept.runs["r"].states[5]})
    assert twice.plan.runs["r"].headings == {3: heading}
    assert verify(mission, twice.plan).ok


def test_a_car_that_was_turned_round_cannot_follow_its_old_plan() -> None:
    """The measured heading is what is driven from, by the verifier's own model."""
    mission = api.loads(TEXT.format(robot=CAR))
    plan = api.solve(mission).plan
    run = replace(plan.runs["r"], headings={2: -np.pi / 3})
    report = verify(mission, replace(plan, runs={"r": run}, executed=2))
    assert any(v.kind == "tracking" for v in report.violations)


@pytest.mark.parametrize(
    ("pose", "told"),
    [
        ({"x": 1.0, "y": 2.0}, "without a `heading`"),
        ({"x": 1.0, "heading": 2.0}, "`x`, `y` and `heading`"),
        ({"px": 1.0, "x": 1.0, "y": 1.0, "heading": 2.0}, "`x`, `y` and `heading`"),
        ({"px": 1.0, "heading": "north"}, "numbers are needed"),
        ({"pz": 1.0, "heading": 1.0}, "no state 'pz'"),
    ],
)
def test_poses_that_say_too_little_are_told(
    pose: dict[str, float], told: str, tmp_path: Path
) -> None:
    mission = api.loads(TEXT.format(robot=UNICYCLE))
    agents = {"r": (np.zeros((9 + 1, 2)), np.zeros((9, 2)))}
    plan = make_plan(mission, {n: s for n, (s, _) in agents.items()},
                     {n: u for n, (_, u) in agents.items()})  # fmt: skip
    with pytest.raises(UsageError, match=told):
        read_past(_at(plan, 2, pose, tmp_path), mission, plan, 2)


def test_who_is_no_robot_has_no_heading() -> None:
    mission = api.loads(TEXT.format(robot="single_integrator { start (5, 2); control |u| <= 1 }"))
    plan = make_plan(mission, {"r": np.zeros((10, 2))}, {"r": np.zeros((9, 2))})
    with pytest.raises(UsageError, match="no robot 'r'"):
        along(mission, plan, 2, {}, headings={"r": 1.0})
