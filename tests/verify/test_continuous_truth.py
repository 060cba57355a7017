"""Plans between the samples, by a simulation and shapes that share nothing with the verifier."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from continuous_truth import LIMIT, Finding, examine
from truth.draw import FAMILIES, draw
from truth.judge import judge
from truth.motion import integrate
from truth.scene import DOUBLE, SINGLE, Body, Model, Obstacle, Part, Scene, Window, box

SPACE = ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0))
SEEDS = dict.fromkeys(FAMILIES, 1) | {
    "continuous": 3, "touching": 0, "flush": 9, "moving": 0, "three": 12, "inflated": 3,
    "inside": 16, "sampled": 6,
}  # fmt: skip
"""Scenes of each family; where a chord, a seam or a sampled frame would let an agent through."""


@pytest.mark.parametrize("family", SEEDS)
def test_plans_keep_their_promises(family: str) -> None:
    scene = draw(family, SEEDS[family])
    found = examine(scene, 600.0)
    assert found.verdict in ("plan", "infeasible")
    assert not found.is_fault(scene), found


def _straight(*obstacles: Obstacle, y: float, model: str = SINGLE) -> dict[str, float]:
    """What is found of an agent that goes straight from x = 1 to x = 9 in two steps."""
    rest = (0.0, 0.0) if model == DOUBLE else ()
    body = Body("r", Model(model), (1.0, y, *rest), 10.0)
    keep = {("r", o.name): Window(0, 2) for o in obstacles}
    scene = Scene("", 1.0, 2, SPACE, (body,), obstacles, keep)
    inputs = np.array([[4.0, 0.0]] * 2) if model == SINGLE else np.array([[8.0, 0], [-8.0, 0]])
    return judge(scene, {"r": integrate(body, inputs, 1.0)})


def test_a_seam_between_pieces_is_no_way_through() -> None:
    wall = Obstacle("w", {0: (box(4, 5, 0, 5), box(4, 5, 5, 10))})
    assert _straight(wall, y=5.0)["obstacle"] == pytest.approx(0.5, abs=1e-6)


def test_nor_are_two_obstacles_that_touch() -> None:
    parts = (Obstacle("a", {0: (box(4, 5, 0, 5),)}), Obstacle("b", {0: (box(4, 5, 5, 10),)}))
    assert _straight(*parts, y=5.0)["obstacle"] == pytest.approx(0.5, abs=1e-6)


def test_nor_is_the_border_of_the_workspace() -> None:
    wall = Obstacle("w", {0: (box(4, 6, 0, 3),)})
    assert _straight(wall, y=0.0)["obstacle"] == pytest.approx(1.0, abs=1e-6)


def test_a_face_may_be_touched() -> None:
    wall = Obstacle("w", {0: (box(4, 6, 1, 3),)})
    assert abs(_straight(wall, y=3.0)["obstacle"]) < 1e-9


def test_a_thin_wall_between_two_points_is_met() -> None:
    wall = Obstacle("w", {0: (box(4.00001, 4.00011, 1, 3),)})
    assert _straight(wall, y=2.0)["obstacle"] == pytest.approx(5e-5, rel=0.1)


def test_a_hole_is_free_and_its_ring_is_not() -> None:
    ring = Part(((3, 3), (7, 3), (7, 7), (3, 7)), (((4, 4), (6, 4), (6, 6), (4, 6)),))
    assert _straight(Obstacle("w", {0: (ring,)}), y=5.0)["obstacle"] == pytest.approx(0.5, abs=1e-6)


def test_a_truck_is_met_on_its_way_between_two_frames() -> None:
    frames = {0: (box(4, 6, 6, 8),), 1: (box(4, 6, 2, 4),)}
    found = _straight(Obstacle("w", frames), y=4.5)
    assert found["obstacle"] > 0.1
    assert found["sampled"] < 0


def test_integrators_have_the_motion_of_their_matrices() -> None:
    rows = ((0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0), (0.0,) * 4, (0.0,) * 4)
    push = ((0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
    named = Body("r", Model(DOUBLE), (1.0, 2.0, 0.5, -0.5), 3.0)
    general = replace(named, model=Model("matrices", rows, push, continuous=True))
    inputs = np.array([[1.0, -2.0], [0.5, 0.25]])
    one, other = (integrate(body, inputs, 0.7) for body in (named, general))
    s = np.linspace(0, 1, 7)
    np.testing.assert_allclose(one.at(1, s), other.at(1, s), atol=1e-12)
    np.testing.assert_allclose(one.states, other.states, atol=1e-12)


def test_a_plan_through_a_closed_wall_is_a_fault() -> None:
    scene = replace(draw("union", 1), closed=True)
    assert Finding("plan", {"obstacle": -1.0}).is_fault(scene)
    assert Finding("plan", {"obstacle": 2 * LIMIT}).is_fault(replace(scene, closed=False))
    assert Finding("SolverError: ..").is_fault(scene)
    assert not Finding("infeasible").is_fault(scene)
