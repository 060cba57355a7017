"""Regions and obstacles between two heights: planned, verified and judged in continuous time."""

import numpy as np
import pytest
from support.flying import HEAD, flown, mission

from stlc.api import loads
from stlc.errors import InfeasibleError, MissionError
from stlc.solve.driver import solve_mission
from stlc.verify import verify

WALL = "obstacle wall = box [4, 6] x [0, 10] x [0, 5]\n"


def judged(found, *places):
    return verify(found, flown(found, *places)).requirements[0]


@pytest.mark.parametrize(
    ("place", "value"),
    [((5, 5, 8), 3), ((2, 5, 8), 3), ((2, 5, 1), 2), ((5, 5, 4), -1), ((5, 5, 1), -1)],
)
def test_samples_are_judged_in_space(place, value):
    found = mission(WALL + "require r: eventually[1, 1] a outside wall")
    assert judged(found, (1, 5, 2), place).robustness == pytest.approx(value)


@pytest.mark.parametrize(
    ("place", "value"), [((5, 5, 3), 1), ((5, 5, 5), -1), ((5, 5, 1), -1), ((5, 9, 3), -2)]
)
def test_a_region_is_a_prism(place, value):
    found = mission("region r = box [3, 7] x [3, 7] x [2, 4]\nrequire r: eventually[1, 1] a in r")
    assert judged(found, (1, 5, 2), place).robustness == pytest.approx(value)


def test_a_plan_flies_over_a_wall_and_is_clear_of_it_between_samples():
    found = mission(
        WALL + "region goal = box [8, 9] x [4, 6] x [0, 3]\n"
        "require clear: always a outside wall swept\nrequire go: eventually a in goal\n"
        "minimize effort(a)"
    )
    outcome = solve_mission(found)
    report = verify(found, outcome.plan)
    assert report.ok
    assert report.requirements[0].swept >= -1e-6
    # up by 3 m to the top of the wall, over it, down by 2 m to the top of the goal
    assert outcome.plan.solve.objective == pytest.approx(7 + 3 + 2, abs=1e-5)


def test_corners_cut_between_samples_are_seen():
    found = mission(WALL + "require clear: always a outside wall swept")
    inside = judged(found, (1, 5, 2), (3.5, 5, 4), (6.5, 5, 5.5))  # 4.25 m up over its edge
    assert inside.swept == pytest.approx(-0.333, abs=0.2)
    up = judged(found, (1, 5, 2), (3, 5, 6), (5, 5, 6), (5, 5, 5.5), (5, 5, 6))
    assert up.swept == pytest.approx(0.5, abs=1e-6)
    through = judged(found, (1, 5, 2), (3, 5, 6), (5, 5, 6), (5, 5, 2), (5, 5, 6))
    assert through.swept < -0.9


def test_distances_between_samples_are_those_in_space():
    found = mission("obstacle o = box [4, 6] x [4, 6] x [2, 4]\nrequire r: a outside o swept")
    over = judged(found, (1, 1, 8), (9, 9, 8))
    assert over.swept == pytest.approx(4, abs=1e-6)
    beside = judged(found, (1, 1, 7), (9, 1, 7))
    assert beside.swept == pytest.approx(np.hypot(3, 3), abs=1e-6)


def test_there_is_no_way_under_what_stands_on_the_ground():
    found = mission(
        WALL.replace("[0, 10] x [0, 5]", "[0, 10] x [0, 10]")
        + "require clear: always forall v in agents: v outside wall swept\n"
        "require go: eventually a.x >= 8 m"
    )
    with pytest.raises(InfeasibleError):
        solve_mission(found)
    sneaks = judged(found, (1, 5, 2), (3, 5, 0), (7, 5, 0))
    assert sneaks.swept < -0.5


@pytest.mark.parametrize(("heights", "way"), [("[0, 3]", False), ("[1, 3]", True)])
def test_who_drives_meets_what_stands_on_the_ground(heights, way):
    found = mission(
        f"obstacle gate = box [4, 6] x [0, 10] x {heights}\n"
        "require clear: always g outside gate swept\nrequire go: eventually g.x >= 8 m"
    )
    if way:
        outcome = solve_mission(found)
        assert verify(found, outcome.plan).ok
        return
    with pytest.raises(InfeasibleError):
        solve_mission(found)


def test_what_touches_is_closed_between_its_common_heights():
    pair = (
        "obstacle p = box [4, 6] x [0, 5] x [0, {}]\nobstacle q = box [4, 6] x [5, 10] x [0, 5]\n"
        "require clear: always (a outside p swept and a outside q swept)\n"
        "require low: always a.z <= 4 m\nrequire go: eventually a.x >= 8 m\n"
    )
    with pytest.raises(InfeasibleError):
        solve_mission(mission(pair.format(10)))
    report = verify(mission(pair.format(10)), flown(mission(pair.format(10)), (1, 5, 2), (9, 5, 2)))
    assert any("p and q" in v.message for v in report.violations)
    found = mission(pair.format(3))
    outcome = solve_mission(found)  # over the lower one
    assert verify(found, outcome.plan).ok


def test_a_workspace_has_a_floor_and_a_ceiling():
    """They bound who flies, beside its own bounds, and nobody on the ground."""
    head = HEAD.replace("x [0, 10]\ndyn", "x [0, 10] x [1, 4]\ndyn").replace("pz in [0, 10]; ", "")
    found = loads(head.format("require: eventually a.x >= 2 m\nmaximize total(a.z)"))
    assert (found.agents["a"].state_lower[2], found.agents["a"].state_upper[2]) == (1.0, 4.0)
    plan = solve_mission(found).plan
    assert plan.runs["a"].states[:, 2].max() == pytest.approx(4.0)
    report = verify(found, flown(found, (1, 5, 2), (2, 5, 5)))
    assert any("pz" in v.message for v in report.violations)
    narrow = loads(HEAD.replace("x [0, 10]\ndyn", "x [0, 10] x [1, 4]\ndyn").format(""))
    assert narrow.agents["a"].state_lower[2] == 1.0


HEAVY = """step 2 s
horizon 4
workspace box [0, 10] x [0, 10] x [1, 5] {times}
dynamics heavy = double_integrator {{ dimensions 3; control |u| <= 1 }}
agent h : heavy {{ start (1, 1, 3){more} }}
require up: eventually h.vz >= 1.5
require high: eventually[2, 4] h.z >= 4.5
minimize effort
"""


@pytest.mark.parametrize("more", ["", "; disturbance 0.02"])
def test_floor_and_ceiling_hold_between_the_steps_of_who_is_heavy(more):
    found = loads(HEAVY.format(times="swept", more=more))
    outcome = solve_mission(found)
    assert outcome.report.ok
    run, times = outcome.plan.runs["h"], np.linspace(0, 2, 21)[:, None]
    z = run.states[:-1, 2] + times * run.states[:-1, 5] + times**2 / 2 * run.inputs[:, 2]
    assert z.max() <= 5 + 1e-6
    assert z.min() >= 1 - 1e-6


def test_who_overshoots_the_ceiling_between_the_steps_is_seen():
    """Up at 1 m/s below the ceiling: at the end of the step it is where it was, and was higher."""
    start = HEAVY.replace("(1, 1, 3)", "(1, 1, 4.8, 0, 0, 1)").replace("horizon 4", "horizon 1")
    text = start.split("require up")[0] + "require it: always h.x >= 0\nminimize effort\n"
    plan = solve_mission(loads(text.format(times="sampled", more=""))).plan
    swept = loads(text.format(times="swept", more=""))
    with pytest.raises(InfeasibleError):
        solve_mission(swept)
    (told,) = (v for v in verify(swept, plan).violations if v.kind == "workspace")
    peak = 4.8 + 1 / (2 * 0.9)  # it brakes as little as brings it to 5 m at the step
    assert told.amount == pytest.approx(peak - 5, abs=1e-6)
    assert "5.35556) lies" in told.message


def test_agents_pass_each_other_at_different_heights():
    found = mission("require apart: always separation(a, g) >= 2 m swept")
    report = verify(found, flown(found, (1, 5, 2), (1, 1, 2)))
    assert report.ok
    closest = {c.what: c.value for c in report.clearances}
    assert closest["distance"] == pytest.approx(2)
    assert closest["separation"] == pytest.approx(2)
    low = flown(found, (1, 5, 2), (1, 1, 1))
    assert verify(found, low).requirements[0].swept == pytest.approx(-1)


@pytest.mark.parametrize(
    "text",
    [
        "obstacle s = box [0, 1] x [0, 1] x [0, 5] + box [0, 1] x [1, 2] x [0, 6]",
        "region r = box [0, 1] x [0, 1] x [0, 5]\nrequire: eventually (1, 1) in r",
        # on one another, and one of them moves
        "obstacle p = box [4, 6] x [4, 6] x [0, 5] velocity (0.1, 0)\n"
        "obstacle q = box [4, 6] x [4, 6] x [5, 8]\nrequire: always (a outside p and a outside q)",
    ],
)
def test_what_cannot_be_said_in_space_is_refused(text):
    with pytest.raises(MissionError) as caught:
        loads(HEAD.format(text))
    assert "E0418" in [d.code for d in caught.value.diagnostics]
