"""What stands on and beside others at one height leaves no way between."""

import pytest
from support.flying import flown, mission

from stlc.solve.driver import solve_mission
from stlc.verify import verify

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
