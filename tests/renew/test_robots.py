"""Robots on the way: planned anew with the heading that they have by then."""

from __future__ import annotations

import numpy as np
import pytest
from support.driving import driven

from stlc import api
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
