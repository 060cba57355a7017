"""The verifier's own shapes: made from the file's corners, closed where they touch."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from stlc.api import loads
from stlc.ir.claims import Membership
from stlc.ir.nodes import Always, And, Const, Eventually, Motion, Swept, walk
from stlc.mission import Mission
from stlc.plan import Plan, Run, mission_digest
from stlc.verify import verify

HEAD = """
step 1 s
horizon {last}
workspace box [0, 10] x [0, 10]
agent r : single_integrator {{ start ({x}, {y}); control |u| <= 20 }}
{obstacles}
require clear: always forall o in obstacles: r outside o swept
"""


def judged(obstacles: str, *places: tuple[float, float]) -> tuple[Mission, Plan]:
    """A mission and the plan that goes straight from place to place."""
    (x, y), last = places[0], len(places) - 1
    mission = loads(HEAD.format(last=last, x=x, y=y, obstacles=obstacles))
    states, model = np.array(places, dtype=float), mission.agents["r"].dynamics
    names = (model.states, model.inputs, model.state_units, model.input_units)
    run = Run(states, np.diff(states, axis=0), *names)
    return mission, Plan("<text>", mission_digest(mission), 1.0, last, {"r": run})


def breaks(obstacles: str, *places: tuple[float, float]) -> str:
    """The messages of all violations."""
    mission, plan = judged(obstacles, *places)
    return " / ".join(v.message for v in verify(blind(mission), plan).violations)


def blind(mission: Mission) -> Mission:
    """The mission as an encoder would leave it that forgot its obstacles: all else must tell."""
    formula = mission.requirements[0].formula
    claims = [node for node in walk(formula) if node.swept is not None]
    said = And(tuple(Const(True, swept=node.swept) for node in claims))
    return dataclasses.replace(
        mission,
        requirements=(dataclasses.replace(mission.requirements[0], formula=Always(said, 0, None)),),
        obstacles={
            name: dataclasses.replace(o, frames=((),), bodies=((),), barrier=((),), sweeps=())
            for name, o in mission.obstacles.items()
        },
    )


@pytest.mark.parametrize(
    ("obstacles", "places", "words"),
    [
        ("obstacle w = box [4, 6] x [4, 6]", [(1, 5), (9, 5)], "fails between samples"),
        ("obstacle w = box [4, 6] x [4, 6]", [(1, 4), (9, 4)], ""),
        ("obstacle w = box [4, 6] x [4, 6] inflate 0.5 m", [(1, 3.6), (9, 3.6)], "fails between"),
        ("obstacle w = box [4, 6] x [4, 6] inflate 0.5 m", [(1, 3.5), (9, 3.5)], ""),
        ("obstacle w = box [4, 6] x [0, 6]", [(1, 0), (9, 0)], "fails between samples"),
        ("obstacle w = polygon (5, 0) (6, 3) (4, 3)", [(1, 0), (9, 0)], "fails between samples"),
        ("obstacle w = polygon (5, 0.1) (6, 3) (4, 3)", [(1, 0), (9, 0)], ""),
        ("obstacle w = box [4, 6] x [0, 5] + box [4, 6] x [5, 9]", [(1, 5), (9, 5)], "fails"),
        ("obstacle a = box [4, 6] x [0, 5]\nobstacle b = box [4, 6] x [5, 9]",
         [(1, 5), (9, 5)], "passes between a and b, which touch"),
        ("obstacle a = box [4, 5] x [0, 5]\nobstacle b = box [5, 6] x [5, 9]",
         [(4, 6), (6, 4)], "passes between a and b, which touch"),
        ("obstacle a = box [4, 6] x [0, 4.9]\nobstacle b = box [4, 6] x [5, 9]",
         [(1, 4.95), (9, 4.95)], ""),
        ("obstacle t = moving { 0: box [1, 2] x [4, 6]; 1: box [7, 8] x [4, 6] }",
         [(4, 5), (4, 5)], "fails between samples"),
        ("obstacle t = moving { 0: box [1, 2] x [4, 6]; 1: box [7, 8] x [4, 6] }",
         [(3, 5), (9, 5)], ""),
        ("obstacle t = moving { 0: box [1, 2] x [4, 6]; 1: box [1, 7] x [4, 6] }",
         [(4, 5), (4, 5)], "fails between samples"),
        ("obstacle t = moving { 0: box [1, 2] x [4, 6]; 1: box [1, 4] x [4, 6] }",
         [(4, 5), (4, 5)], ""),
        ("obstacle t = moving { 0: box [1, 2] x [4, 6]; 1: polygon (7, 4) (8, 5) (7, 6) }",
         [(4, 5), (4, 5)], "fails between samples"),
    ],
)  # fmt: skip
def test_motion_is_judged_by_the_corners_in_the_file(
    obstacles: str, places: list[tuple[float, float]], words: str
) -> None:
    found = breaks(obstacles, *places)
    assert (words in found) if words else not found, found


@pytest.mark.parametrize(("end", "good"), [(6, True), (7.01, False)])
def test_a_polygon_keeps_its_hole(end: float, good: bool) -> None:
    ring = "obstacle w = polygon (1, 1) (9, 1) (9, 9) (1, 9) hole (3, 3) (7, 3) (7, 7) (3, 7)"
    assert bool(breaks(ring, (4, 4), (end, end))) is not good


@pytest.mark.parametrize(
    ("places", "good"), [([(8, 2), (2, 2), (2, 8)], True), ([(8, 2), (2, 8)], False)]
)
def test_staying_in_a_region_is_judged_by_its_corners(
    places: list[tuple[float, float]], good: bool
) -> None:
    ell = "region ell = polygon (1, 1) (9, 1) (9, 3) (3, 3) (3, 9) (1, 9)\n"
    mission, plan = judged(ell + "obstacle far = box [9.5, 10] x [9, 10]", *places)
    held = Always(Const(True, swept=Swept(Motion.INSIDE, "r", place="ell")), 0, None)
    requirement = dataclasses.replace(mission.requirements[0], formula=held)
    assert verify(dataclasses.replace(mission, requirements=(requirement,)), plan).ok is good


def test_a_far_body_is_judged_like_a_near_one() -> None:
    """The rough chain only saves work: distances are those to the corners, in the nearest step."""
    mission, plan = judged("obstacle w = box [4, 6] x [4, 6] inflate 0.5 m", (1, 1), (1, 9), (9, 9))
    found = {c.what: c for c in verify(mission, plan).clearances}
    assert found["body"].value == pytest.approx(3.0, abs=1e-9)
    assert found["buffer"].value == pytest.approx(2.5, abs=1e-9)
    assert found["body"].time == pytest.approx(0.375, abs=0.13)


@pytest.mark.parametrize(("lane", "good"), [(2.0, False), (2.1, True)])
def test_no_way_between_a_wall_and_what_drives_along_it(lane: float, good: bool) -> None:
    moving = f"obstacle w = box [0, 10] x [0, 2]\nobstacle t = box [2, 6] x [{lane}, 4] "
    found = breaks(moving + "velocity (0.5, 0)", (1, 2), (8, 2))
    assert bool(found) is not good
    assert good or "passes between t and w, which touch" in found


@pytest.mark.parametrize(
    ("place", "relation", "at", "good"),
    [
        ("region p = box [4, 6] x [4, 6]", "in", (5, 5), True),
        ("region p = box [4, 6] x [4, 6]", "in", (6.001, 5), False),
        ("region p = polygon (1, 1) (9, 1) (9, 3) (3, 3) (3, 9) (1, 9)", "in", (5, 5), False),
        ("obstacle p = box [4, 6] x [4, 6] inflate 0.5 m", "outside", (6.5, 5), True),
        ("obstacle p = box [4, 6] x [4, 6] inflate 0.5 m", "outside", (6.4999, 5), False),
        ("obstacle p = box [0, 1] x [4, 6] velocity (4, 0)", "outside", (4.5, 5), False),
        ("obstacle p = box [0, 1] x [4, 6] velocity (4, 0)", "outside", (3.5, 5), True),
        ("obstacle p = moving { 0: box [0, 1] x [0, 1]; 1: box [4, 6] x [0, 6] }",
         "outside", (5, 5), False),
    ],
)  # fmt: skip
def test_samples_are_judged_by_the_corners_in_the_file(
    place: str, relation: str, at: tuple[float, float], good: bool
) -> None:
    """Whatever an encoder made of the place: here it forgot it, and the formula always holds."""
    mission, plan = judged(f"{place}\nobstacle far = box [9, 10] x [9, 10]", (1, 5), at)
    claim = Membership(relation == "in", "r", "p")
    said = Eventually(Const(True, member=claim), 1, 1)
    requirement = dataclasses.replace(mission.requirements[0], formula=said)
    report = verify(dataclasses.replace(mission, requirements=(requirement,)), plan)
    assert report.ok is good
    assert good or "by the corners in the file" in report.text()


@pytest.mark.parametrize("at", [(4.5, 5), (5.5, 5), (7, 7)])
def test_corners_agree_with_the_formulas_of_points_and_negations(at: tuple[float, float]) -> None:
    text = """step 1 s
workspace box [0, 10] x [0, 10]
agent r : single_integrator { start (1, 5); control |u| <= 20 }
region p = polygon (4, 4) (6, 4) (6, 6) (5, 6) (5, 5) (4, 5)
require a: eventually[1, 1] not ((r.x + 1 m, r.y) in p)
require b: eventually[1, 1] not (r in p)
"""
    mission = loads(text)
    model, states = mission.agents["r"].dynamics, np.array([(1, 5), at], dtype=float)
    names = (model.states, model.inputs, model.state_units, model.input_units)
    run = Run(states, np.diff(states, axis=0), *names)
    report = verify(mission, Plan("<text>", mission_digest(mission), 1.0, 1, {"r": run}))
    assert {r.name: r.corners for r in report.requirements} == {"a": None, "b": None}
