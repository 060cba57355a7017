"""Members of a conflict: what holds once one of them goes, of the conflict and of the mission."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stlc.api import loads, solve
from stlc.errors import InfeasibleError
from stlc.explain.conflict import Conflict, explain
from stlc.explain.givens import Given, Kind, givens_of, without
from stlc.explain.oracle import Oracle, Verdict
from stlc.mission import Mission
from stlc.solve.deadline import Deadline

WORLD = """horizon 6
workspace box [0, 12] x [0, 10]
agent a : single_integrator { start (1, 1); control |u| <= 1 }
agent b : single_integrator { start (1, 8); control |u| <= 1 }
region goal = box [9, 12] x [0, 3]
require work: eventually[0, 6] b.x >= 4 m
require near: always distance(a, b) <= 20 m
"""
ONLY = (
    "require go: eventually[0, 6] a in goal\n",
    "require go: always[5, 6] a.y >= 5 m\nrequire low: always[0, 4] a.y <= 3 m\n",
    "require both: eventually[0, 6] (a.x >= 3 m and a.y >= 3 m and a.x + a.y <= 5 m)\n",
)


def conflict(mission: Mission) -> Conflict:
    found = explain(mission)
    assert isinstance(found, Conflict)
    assert found.minimal
    return found


def has_plan(mission: Mission) -> bool:
    try:
        return solve(replace(mission, objective=())).report.ok
    except InfeasibleError:
        return False


@pytest.mark.parametrize("planted", ONLY)
def test_without_any_member_of_its_only_conflict_a_mission_has_a_plan(planted: str) -> None:
    mission = loads(WORLD + planted)
    found = conflict(mission)
    for piece in found.clauses:
        others = tuple(r for r in mission.requirements if r.name != piece.name)
        kept = tuple(c for c in found.clauses if c is not piece)
        names = tuple(replace(c, name=f"kept_{k}") for k, c in enumerate(kept))
        assert has_plan(replace(mission, requirements=(*others, *names)))
    oracle = Oracle(mission, "highs", Deadline.after(60.0))
    for given in found.givens:
        assert oracle(mission.requirements, {given}) is Verdict.FEASIBLE


def test_where_either_of_two_bounds_is_too_tight_the_other_is_left() -> None:
    """Each is a conflict with the goal; one is named, and without it the other is."""
    text = WORLD.replace("single_integrator { start (1, 1)", "double_integrator { start (1, 1)")
    text = text.replace("control |u| <= 1 }", "control |u| <= 0.2; speed <= 1 }", 1)
    mission = loads(text + "require go: eventually[0, 6] a in goal\n")
    first = conflict(mission)
    (bound,) = (g for g in first.givens if g.kind in (Kind.CONTROL, Kind.SPEED))
    rest = conflict(without(mission, [bound]))
    (other,) = (g for g in rest.givens if g.kind in (Kind.CONTROL, Kind.SPEED))
    assert {bound.kind, other.kind} == {Kind.CONTROL, Kind.SPEED}
    assert has_plan(without(mission, [bound, other]))


def test_the_rest_of_a_conflict_can_hold_where_nothing_else_is_given() -> None:
    mission = loads(
        WORLD + "require go: eventually[0, 6] a in goal\nrequire far: always b.y >= 9\n"
    )
    found = conflict(mission)
    every = givens_of(mission, found.agents, [])
    spare: set[Given] = set(every) - set(found.givens)
    oracle = Oracle(mission, "highs", Deadline.after(60.0))
    assert oracle(found.clauses, spare) is Verdict.INFEASIBLE
    for piece in found.clauses:
        rest = [c for c in found.clauses if c is not piece]
        assert oracle(rest, spare) is Verdict.FEASIBLE
    for given in found.givens:
        assert oracle(found.clauses, {given, *spare}) is Verdict.FEASIBLE


@pytest.mark.slow
def test_tubes_and_steering_are_members() -> None:
    head = "horizon 5\nworkspace box [0, 10] x [0, 10]\nagent r : "
    tail = "region dock = box [6, 6.9] x [4, 6]\nrequire go: eventually[0, 5] r in dock\n"
    thin = "unicycle { start (1, 5); speed <= 2; turn_rate <= 4; lookahead 0.5 }\n"
    found = conflict(loads(head + thin + tail))
    assert [str(given) for given in found.givens] == ["`lookahead 0.5` of r"]
    steered = (
        "car { start (5, 5); heading 180 deg; speed <= 2; wheelbase 0.3; steering <= 30 deg }\n"
        "require back: eventually[0, 2] r.x >= 6\n"
    )
    found = conflict(loads(head + steered))
    assert "`steering <= 30 deg` of r" in {str(given) for given in found.givens}
