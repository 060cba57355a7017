"""Regions and obstacles between two heights: planned, verified and judged in continuous time."""

import numpy as np
import pytest

from stlc.api import loads
from stlc.errors import InfeasibleError, MissionError
from stlc.plan import make_plan
from stlc.solve.driver import solve_mission
from stlc.verify import verify

HEAD = """
step 1 s
horizon 4
workspace box [0, 10] x [0, 10]
dynamics drone = single_integrator {{ dimensions 3; pz in [0, 10]; control |u| <= 4 }}
agent a : drone {{ start (1, 5, 2) }}
agent g : single_integrator {{ start (1, 1); control |u| <= 4 }}
{}
"""
WALL = "obstacle wall = box [4, 6] x [0, 10] x [0, 5]\n"


def mission(text):
    return loads(HEAD.format(text))


def flown(found, *places):
    """The plan whose drone is at these places, step by step, and whose cart rests."""
    places = np.array([*places, *[places[-1]] * (found.horizon + 1 - len(places))], dtype=float)
    rest = np.tile(found.agents["g"].start, (found.horizon + 1, 1))
    runs = {"a": places, "g": rest}
    return make_plan(found, runs, {n: np.diff(r, axis=0) for n, r in runs.items()})


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


STACK = """obstacle p = box [4, 6] x [0, 10] x [0, 3]
obstacle q = box [3, 5] x [0, 10] x [3, 5]
require clear: always forall o in [p, q]: a outside o {}
"""


@pytest.mark.parametrize("how", ["", "swept"])
def test_what_stands_on_another_leaves_no_way_between_them(how):
    """At the height at which one ends and the other begins each leaves a way, and both none."""
    found = mission(STACK.format(how) + "require there: always[2, 2] (a.x >= 4.2 and a.x <= 4.8)")
    plan = solve_mission(found).plan
    assert plan.runs["a"].states[2, 2] >= 5 - 1e-6  # over both
    through = flown(found, (1, 5, 3), (2.9, 5, 3), (4.5, 5, 3), (6.1, 5, 3))
    report = verify(found, through)
    assert any("p and q, one of which stands on the other" in v.message for v in report.violations)
    over = flown(found, (1, 5, 2), (2.9, 5, 5), (4.5, 5, 5), (6.1, 5, 5))
    assert not any("stands on" in v.message for v in verify(found, over).violations)


def test_what_stands_on_another_takes_nothing_but_the_seam():
    """Under what hangs over, and on what it stands on beside it, is free."""
    below = "require low: always[2, 3] (a.x >= 3.2 and a.x <= 3.8 and a.z <= 2.9)"
    assert solve_mission(mission(STACK.format("swept") + below)).report.ok
    beside = "require on: always[3, 4] (a.x >= 5.2 and a.x <= 5.8 and a.z <= 3.1)"
    assert solve_mission(mission(STACK.format("swept") + beside)).report.ok


PODIUM = """obstacle base = box [4, 6] x [0, 10] x [0, 3]
obstacle west = box [4, 5] x [0, 10] x [3, 6]
obstacle east = box [5, 6] x [0, 10] x [3, {top}]
"""
BESIDE = """obstacle base = box [4, 5] x [0, 10] x [0, 3]
obstacle upper = box [4, 5] x [0, 10] x [3, 6]
obstacle tower = box [5, 6] x [0, 10] x [0, 6]
"""
BRIDGE = """obstacle left = box [4, 5] x [0, 10] x [0, 3]
obstacle right = box [5, 6] x [0, 10] x [0, 3]
obstacle bridge = box [4, 6] x [0, 10] x [3, 6]
"""
FLOORS = """obstacle p = box [4, 5] x [0, 10] x [0, 3]
obstacle q = box [4, 5] x [0, 10] x [3, 6]
obstacle r = box [5, 6] x [0, 10] x [0, 3]
obstacle s = box [5, 6] x [0, 10] x [3, 6]
"""
STAIR = """obstacle low = box [4, 5] x [0, 10] x [0, 3]
obstacle high = box [5, 6] x [0, 10] x [3, 6]
"""
KEEP = "require clear: always forall o in obstacles: a outside o {}\n"


@pytest.mark.parametrize("how", ["", "swept"])
@pytest.mark.parametrize(
    "blocks",
    [PODIUM.format(top=6), BESIDE, BRIDGE, FLOORS],
    ids=["podium", "beside", "bridge", "floors"],
)
def test_what_stands_on_and_beside_others_leaves_no_way_along_their_seams(blocks, how):
    """Over the border of two things at the height at which a third ends, all leave a way alone."""
    found = mission(blocks + KEEP.format(how) + "require there: always[2, 2] (a.x >= 4.9999 and "
                    "a.x <= 5.0001)\n")  # fmt: skip
    plan = solve_mission(found).plan
    assert plan.runs["a"].states[2, 2] >= 6 - 1e-6  # over all of it
    along = flown(found, (1, 5, 3), (5, -0.5, 3), (5, 4, 3), (5, 8, 3))
    report = verify(found, along)
    assert any("one of which stands on the other" in v.message for v in report.violations)
    assert not any("stands on" in v.message for v in verify(found, plan).violations)


def test_an_edge_at_which_two_things_meet_is_closed_and_nothing_beside_it():
    """One stands where the other ends, so that they share a line, in space."""
    found = mission(
        STAIR + KEEP.format("swept") + "require go: eventually (a.x >= 7 and a.z <= 2)\n"
    )
    through = flown(found, (3, 5, 4), (5, 5, 3), (7, 5, 2))
    report = verify(found, through)
    assert any("one of which stands on the other" in v.message for v in report.violations)
    outcome = solve_mission(found)
    assert outcome.report.ok
    assert outcome.plan.runs["a"].states[:, 2].max() >= 6 - 1e-6
    near = mission(STAIR + KEEP.format("swept") + "require n: always[2, 2] (a.x >= 4.99 and "
                   "a.x <= 5 - 0.002 and a.z <= 3.003)\n")  # fmt: skip
    assert solve_mission(near).report.ok


def test_triangles_on_one_another_are_closed_where_both_are():
    blocks = """obstacle p = polygon (4, 4) (7, 4) (4, 7) x [0, 3]
obstacle q = polygon (4, 4) (7, 4) (4, 7) x [3, 5]
"""
    there = "require there: always[2, 2] max(|a.x - {x}|, |a.y - {x}|) <= 0.1\n"
    over = solve_mission(mission(blocks + KEEP.format("") + there.format(x=4.6))).plan
    assert over.runs["a"].states[2, 2] >= 5 - 1e-6
    # the other half of the square is free, at the height of the seam too
    beside = there.format(x=6.1) + "require low: always[2, 2] a.z <= 3.0001\n"
    assert solve_mission(
        mission(blocks + KEEP.format("") + beside + "require s: always[2, 2] a.z >= 2.9999\n")
    ).report.ok


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
