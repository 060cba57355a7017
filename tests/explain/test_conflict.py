"""What a conflict names: members inside clauses, what is given beside them, a sentence of cause."""

from __future__ import annotations

from itertools import combinations
from math import log10

import pytest

from stlc.api import loads
from stlc.explain.conflict import Conflict, all_conflicts, explain
from stlc.explain.givens import Kind
from stlc.explain.marco import clauses_of
from stlc.explain.oracle import Oracle, Verdict
from stlc.explain.shrink import minimal
from stlc.explain.whole import begin
from stlc.explain.words import clause, steps_of
from stlc.ir.requirement import Requirement
from stlc.mission import Mission
from stlc.solve.deadline import Deadline

WORLD = """
horizon 8
workspace box [0, 10] x [0, 10]
dynamics cart = double_integrator
agent a : cart { start (5, 5); control |u| <= 1; speed <= 2 }
agent b : cart { start (1, 1); control |u| <= 1; speed <= 2 }
region left = box [2, 3] x [4, 6]
region right = box [7, 8] x [4, 6]
region far = box [9.5, 10] x [4, 6]
obstacle bar = box [6, 6.2] x [0, 10]
require calm: always b.x <= 4 m
"""

FREE = """
horizon 8
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (1, 1); speed <= 3 }
region left = box [5, 6] x [5, 6]
"""


def conflict(requirements: str, world: str = WORLD) -> Conflict:
    found = explain(loads(world + requirements))
    assert isinstance(found, Conflict)
    assert found.minimal
    return found


def kinds(found: Conflict) -> set[tuple[Kind, str]]:
    return {(g.kind, g.owner) for g in found.givens}


def says(found: Conflict) -> list[str]:
    return [clause(c) for c in found.clauses]


def test_a_deadline_tells_the_steps_it_takes() -> None:
    found = conflict("require go: eventually[0, 3] a in far\n")
    assert says(found) == ["`a in far` by step 3"]
    assert found.cause.earliest == 4
    assert found.cause.text == (
        "a needs at least 4 steps to reach far at `speed <= 2`; the deadline is 3"
    )
    assert kinds(found) == {(Kind.SPEED, "a"), (Kind.CONTROL, "a"), (Kind.START, "a")}


def test_the_earliest_step_is_the_first_with_a_plan() -> None:
    for end, verdict in ((3, Verdict.INFEASIBLE), (4, Verdict.FEASIBLE)):
        oracle = _oracle(f"require go: eventually[0, {end}] a in far\n")
        assert oracle(oracle.mission.requirements) is verdict


def test_a_lone_requirement_comes_before_a_pair() -> None:
    found = conflict(
        "require one: eventually[0, 3] a in left\nrequire two: eventually[0, 3] a in right\n"
        "require go: eventually[0, 3] a in far\n"
    )
    assert [c.name for c in found.clauses] == ["go"]


def test_what_is_not_needed_inside_a_formula_is_left_out() -> None:
    found = conflict("require go: eventually[2, 5] (a in left and a.vx <= 1 and a in right)\n")
    assert says(found) == ["`a in left and a in right` by step 5"]
    assert not found.givens
    assert "contradict each other" in found.cause.text


def test_a_window_is_cut_down_to_the_steps_that_matter() -> None:
    found = conflict("require go: eventually[6, 7] a in far\nrequire stay: always[0, 5] a.x <= 5\n")
    pieces = {c.name: steps_of(c) for c in found.clauses}
    assert pieces == {"go": (6, 7), "stay": (5, 5)}  # 4.5 m away, in two steps
    found = conflict("require go: eventually[6, 8] a in far\nrequire stay: always[0, 8] a.x <= 6\n")
    pieces = {c.name: steps_of(c) for c in found.clauses}
    assert pieces == {"go": (6, 8), "stay": (6, 8)}  # at step 7 alone, given the speed
    assert kinds(found) == set()


def test_an_instance_of_a_quantifier_is_told_from_the_others() -> None:
    found = conflict("require in_left: always[4, 6] forall r in agents: r in left\n"
                     "require in_right: eventually[4, 5] a in right\n")  # fmt: skip
    assert {c.name for c in found.clauses} == {"in_left", "in_right"}
    assert found.agents == ("a",)


def test_a_wall_is_named_and_the_workspace_with_it() -> None:
    world = WORLD.replace("horizon 8", "horizon 20")
    told = "require go: eventually a in right\nrequire out: always a outside bar swept\n"
    found = conflict(told, world)
    assert {c.name for c in found.clauses} == {"go", "out"}
    assert (Kind.WORKSPACE, "") in kinds(found)
    assert (Kind.START, "a") in kinds(found)


def test_bounds_alone_name_the_agent_and_no_clause() -> None:
    world = WORLD.replace("start (1, 1)", "start (9, 1, 2, 0)")
    found = conflict("", world.replace("require calm: always b.x <= 4 m", ""))
    assert found.clauses == ()
    assert found.agents == ("b",)
    assert (Kind.WORKSPACE, "") in kinds(found)
    assert found.cause.text.startswith("b has no run at all")


def test_a_link_says_how_many_decibels_are_missing() -> None:
    world = """
workspace box [0, 20] x [0, 20]
agent b : single_integrator { start (2, 10); control |u| <= 1 }
station base at (10, 10)
channel radio { path_loss L0 = -40 dBm, n = 3; partition 20 x 20 }
"""
    found = conflict("require link: always[0, 5] rssi(b, base) >= -60 dBm\n", world)
    assert says(found) == ["`rssi(b, base) >= -60 dBm` at step 0"]
    assert found.cause.unit == "dB"
    assert found.cause.short == pytest.approx(30 * log10(65**0.5) - 20, abs=0.2)  # the far corner
    assert kinds(found) == {(Kind.START, "b")}


def test_as_plain_data() -> None:
    data = conflict("require go: eventually[0, 3] a in far\n").as_dict()
    assert data["earliest"] == 4
    assert data["clauses"][0]["steps"] == (0, 3)
    assert data["clauses"][0]["place"]["text"] == "eventually[0, 3] a in far"
    assert {g["kind"] for g in data["givens"]} == {"speed", "control", "start"}


def _oracle(requirements: str) -> Oracle:
    mission: Mission = loads(WORLD + requirements)
    return Oracle(mission, "highs", Deadline.after(60.0))


SEVERAL = """
require one: eventually[0, 3] a in left
require two: eventually[0, 3] a in right and always a.y >= 4
require go: eventually[0, 3] a in far
require low: always a.y <= 3.9
require far_off: eventually[0, 2] b.y >= 9
"""


def test_every_minimal_conflict_is_found_and_no_other() -> None:
    """Against all subsets of the clauses, asked one by one."""
    oracle = _oracle(SEVERAL)
    pieces = clauses_of(oracle.mission.requirements)
    assert begin(oracle) is None
    found = {frozenset(c.name for c in x.clauses) for x in all_conflicts(oracle)}
    assert found == _by_brute_force(_oracle(SEVERAL), pieces)
    assert len(found) > 3


def _by_brute_force(oracle: Oracle, pieces: tuple[Requirement, ...]) -> set[frozenset[str]]:
    minimal_ones: list[frozenset[Requirement]] = []
    for size in range(1, 4):
        for chosen in map(frozenset, combinations(pieces, size)):
            if not any(m <= chosen for m in minimal_ones) and oracle.infeasible(chosen):
                minimal_ones.append(chosen)
    return {frozenset(p.name for p in m) for m in minimal_ones}


def test_a_minimal_subset_of_a_monotone_property() -> None:
    for needed in ({3}, {0, 7}, {1, 2, 9}, set(range(10)), set()):
        kept = minimal(range(10), lambda xs, needed=needed: needed <= set(xs))
        assert set(kept) == needed


def test_both_sides_of_an_until_are_named_where_they_conflict() -> None:
    found = conflict("require d: (b.x <= 2) until[3, 5] (a in right and b.x >= 3)\n")
    (said,) = says(found)
    assert said == "`(b.x <= 2) until b.x >= 3` by step 5"
    found = conflict("require d: (a.x <= 2) until[3, 5] a in left\n", FREE)
    assert says(found) == ["`(a.x <= 2) until a in left` by step 5"]
    assert found.cause.text == (
        "`a.x <= 2` up to then and `a in left` by step 5 contradict each other, "
        "however the agents move"
    )


def test_an_until_within_a_window_says_from_where_it_is_judged() -> None:
    found = conflict("require d: always[0, 2] ((a.x <= 2) until[0, 5] a in left)\n", FREE)
    assert "`a in left` (judged at step 0) contradict" in found.cause.text


def test_the_left_side_of_an_until_alone_is_named_alone() -> None:
    found = conflict("require d: (a.x >= 4 and a.x <= 3) until[3, 5] a in left\n", FREE)
    assert "until" not in found.cause.text
    assert "in left" not in found.cause.text


def test_a_plain_contradiction_is_not_cut_down_to_steps_that_need_a_start() -> None:
    """Within fewer steps the speed would keep `a` away; in all of them nothing is needed."""
    found = conflict("require in1: eventually a in left\nrequire out: always a.x <= 4\n", FREE)
    assert kinds(found) == set()
    assert found.cause.text.endswith("contradict each other, however the agents move")


def test_a_disturbance_that_is_too_strong_is_named() -> None:
    text = FREE.replace("speed <= 3", "control |u| <= 2; disturbance |w| <= 1.5")
    found = conflict("require go: eventually[0, 8] a in left\n", text)
    assert (Kind.DISTURBANCE, "a") in kinds(found)


def test_a_chance_over_a_window_is_one_member() -> None:
    chance = "P(always[2, 5] rssi(a, base) >= -30 dBm) >= 0.9"
    radio = "channel radio { path_loss L0 = -40 dBm, n = 2; fading 9 dB^2; partition 4 x 4 }\n"
    world = FREE + "station base at (5, 0)\n" + radio
    oracle = Oracle(loads(f"{world}require p: {chance}\n"), "highs", Deadline.after(60.0))
    assert begin(oracle) is None
    (found,) = all_conflicts(oracle)
    assert says(found) == [f"`{chance}`"]


def test_a_number_of_steps_is_laid_to_a_bound_that_makes_it_so() -> None:
    """By the control alone dock is reached at step 4, and not at step 5 as with the speed."""
    text = """step 1 s
workspace box [0, 10] x [0, 6]
agent scout : double_integrator { start (1, 1); control |u| <= 1; speed <= 2 }
region dock = box [8, 9] x [1, 2]
require reach: eventually[0, 2] scout in dock
"""
    found = conflict("", text)
    assert Kind.SPEED not in {g.kind for g in found.givens}
    assert found.cause.text == "scout needs at least 5 steps to reach dock; the deadline is 2"
