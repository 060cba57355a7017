"""Shapes of many corners and pieces, and obstacles of many steps: the same as one by one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stlc.api import loads
from stlc.errors import MissionError
from stlc.ir.nodes import Always, And
from stlc.sema import scope, tracks
from stlc.sema.crossings import TOGETHER, unheld
from stlc.sema.decompose import decompose
from stlc.sema.geometry import polytope
from stlc.sema.seams import closed
from stlc.sema.tracks import Pieces, translated

HEAD = "step 1 s\nhorizon 400\nworkspace box [0, 90] x [0, 90]\n"
AGENT = "agent r : single_integrator { start (80, 80); control |u| <= 1 }\n"
KEEP_OUT = "require: always forall o in obstacles: r outside o\n"


def test_a_star_is_cut_into_its_points_and_what_is_between() -> None:
    """As many pieces as it has reflex corners, and one: fewer there can't be by halves."""
    turns = [(math.pi * k / 50, 90 if k % 2 else 50) for k in range(100)]
    pieces = decompose([(r * math.cos(a), r * math.sin(a)) for a, r in turns])
    assert len(pieces) == 51


def test_a_moved_obstacle_is_closed_as_it_would_be_by_itself() -> None:
    """At the border, away from it, and on its way along and out."""
    space = polytope([(0, 0), (20, 0), (20, 20), (0, 20)])
    shape: Pieces = (
        polytope([(0, 0), (2, 0), (2, 2), (0, 2)]),
        polytope([(2, 0), (3, 0), (3, 2), (2, 2)]),
    )
    for step in ((0.5, 0.0), (0.0, 0.5), (0.5, 0.5), (1.0, 0.1)):
        frames = tuple(
            tuple(translated(p, (step[0] * t, step[1] * t)) for p in shape) for t in range(45)
        )
        for got, frame in zip(tracks.barriers(frames, space), frames, strict=True):
            want = closed(frame, space)
            assert len(got) == len(want)
            for one, other in zip(got, want, strict=True):
                np.testing.assert_allclose(one.vertices, other.vertices, atol=1e-8)


@pytest.mark.parametrize(
    ("declared", "size"),
    [
        (
            "obstacle o = moving { 0: box [1, 2] x [1, 2]; 400000: box [3, 4] x [1, 2] } linear",
            "400,001 polygons of moving obstacles",
        ),
        (
            "\n".join(
                f"obstacle o{k} = box [{k}, {k + 1}] x [1, 2] velocity (0, 0.1)" for k in range(80)
            ),
            "32,080 polygons of moving obstacles",
        ),
        (
            "obstacle o = "
            + " + ".join(
                f"box [{k / 10}, {k / 10 + 40}] x [1, {k / 10 + 2}]" for k in range(400)
            ),
            "79,800 pairs of touching pieces",
        ),
    ],
    ids=["frames", "velocities", "union"],
)  # fmt: skip
def test_what_is_too_large_is_told_at_the_obstacle(declared: str, size: str) -> None:
    with pytest.raises(MissionError) as caught:
        loads(HEAD + AGENT + declared + "\n" + KEEP_OUT)
    first = caught.value.diagnostics[0]
    assert {d.code for d in caught.value.diagnostics} == {"E0224"}
    assert size in first.title_text
    assert first.span is not None
    assert first.span.line >= 5


def test_seams_of_many_requirements_are_those_of_their_windows() -> None:
    """Only steps in windows of both obstacles are closed between, however many say so."""
    windows = [(3 * k, 3 * k + k % 2) for k in range(40)]
    lines = [f"require: always[{a}, {b}] r outside {'ab'[a % 2]}" for a, b in windows]
    places = "obstacle a = box [1, 2] x [1, 2]\nobstacle b = box [2, 3] x [1, 2]\n"
    text = "\n".join([*lines, "require: always[4, 9] r outside a"]) + "\n"
    *others, last = loads(HEAD + AGENT + places + text).requirements
    assert not any(isinstance(other.formula, And) for other in others)
    assert isinstance(last.formula, And)
    _, *seams = last.formula.args
    assert [(s.start, s.end) for s in seams if isinstance(s, Always)] == [(4, 4), (9, 9)]


def moving(count: int, gap: float) -> str:
    boxes = (f"box [{k}, {k + 1 - gap}] x [1, 2]" for k in range(count))
    return "".join(f"obstacle o{k} = {box} velocity (0, 0.1)\n" for k, box in enumerate(boxes))


def test_twenty_obstacles_may_move_over_hundreds_of_steps() -> None:
    (requirement,) = loads(HEAD + AGENT + moving(20, 0.5) + KEEP_OUT).requirements
    (formula,) = requirement.formula.children
    assert [len(part.children) for part in formula.children] == [401] * 20


@pytest.mark.parametrize("when", ["", " swept"])
def test_what_moving_obstacles_touch_is_told_where_it_is_too_much(
    when: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Plugs are written out once the horizon is known: they are told of all the same."""
    monkeypatch.setattr(scope, "MOST_WORK", 22_000 * (2 if when else 1))
    rule = f"require: always forall o in obstacles: r outside o{when}\n"
    text = HEAD.replace("400", "40") + AGENT
    assert loads(text + moving(15, 0.5) + rule).requirements
    with pytest.raises(MissionError, match="E0224") as caught:
        loads(text + moving(15, 0) + rule)
    (found,) = caught.value.diagnostics
    assert found.span is not None
    assert found.span.text == f"r outside o{when}"


def test_points_that_no_piece_has_inside() -> None:
    """Asked one by one: those in the interior of a piece go, those on its border stay."""
    random = np.random.default_rng(5)
    pieces = []
    for _ in range(3 * TOGETHER):
        x, y, wide, high = random.integers(0, 20, 2).tolist() + random.integers(1, 6, 2).tolist()
        pieces.append(polytope([(x, y), (x + wide, y), (x + wide, y + high), (x, y + high)]))
    points = np.array([(x, y) for x in range(26) for y in range(26)], dtype=float)
    held = [any((p.normals @ at < p.offsets - 1e-7).all() for p in pieces) for at in points]
    left = {(float(x), float(y)) for x, y in unheld(points, pieces)}
    assert left == {(float(x), float(y)) for (x, y), h in zip(points, held, strict=True) if not h}
    assert 0 < len(left) < len(points)
