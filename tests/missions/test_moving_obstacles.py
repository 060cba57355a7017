"""Obstacles that move: by frames, between frames, and for ever."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import shapely

from stlc.api import loads, solve
from stlc.errors import InfeasibleError, MissionError
from stlc.mission import Mission
from stlc.solve.driver import SolveSettings

TEXT = """
step 1 s
workspace box [0, 10] x [0, 4]
agent r : double_integrator {{ start (9, 2); control |u| <= 2; speed <= 3 }}
region goal = box [0, 1] x [1, 3]
obstacle t = {obstacle}
require clear: always[0, 5] r outside t swept
require reach: eventually[0, 5] r in goal
minimize effort
"""


def mission(obstacle: str) -> Mission:
    return loads(TEXT.format(obstacle=obstacle))


@pytest.mark.parametrize(
    "obstacle",
    [
        "box [0, 2] x [0, 4] velocity (1.5, 0)",
        "moving { 0: box [0, 2] x [0, 4]; 5: box [7.5, 9.5] x [0, 4] } linear",
        "moving { 0: box [2, 3] x [0, 4]; 2: box [6, 8] x [0, 4] }",
    ],
)
def test_nothing_passes_a_wall_that_comes_along(obstacle: str) -> None:
    with pytest.raises(InfeasibleError):
        solve(mission(obstacle), SolveSettings(threads=1))


@pytest.mark.parametrize(
    ("obstacle", "moved"),
    [
        ("box [1.2, 2] x [1, 3] velocity (1.5, 0)", lambda t: (1.5 * t, 0.0)),
        ("box [1.2, 2] x [0, 3] velocity (1, 0.5)", lambda t: (t, 0.5 * t)),
        ("moving { 0: box [1.2, 2] x [1, 3]; 4: box [7.2, 8] x [1, 3] } linear",
         lambda t: (1.5 * min(t, 4.0), 0.0)),
    ],
)  # fmt: skip
def test_plans_are_clear_at_every_time(
    obstacle: str, moved: Callable[[float], tuple[float, float]]
) -> None:
    planned = mission(obstacle)
    run = solve(planned, SolveSettings(threads=1)).plan.runs["r"]
    outline = planned.obstacles["t"].track
    assert outline is not None
    shape = shapely.Polygon(outline.frames[0][1][0].ring).buffer(-1e-6, join_style="mitre")
    for t, (state, force) in enumerate(zip(run.states, run.inputs, strict=False)):
        for s in np.linspace(0.0, 1.0, 301):
            place = state[:2] + s * state[2:4] + s * s * force / 2.0 - np.array(moved(t + s))
            assert not shape.contains(shapely.Point(place))


def test_frames_are_carried_on_to_the_horizon() -> None:
    frames = mission("box [0, 1] x [0, 1] velocity (2 m/s, 0)").obstacles["t"].frames
    assert [float(f[0].vertices[:, 0].min()) for f in frames] == [
        0.0,
        2.0,
        4.0,
        6.0,
        8.0,
        10.0,
        12.0,
    ]


def test_frames_are_held_or_joined() -> None:
    for end, middle in (("", 0.0), (" linear", 2.0)):
        text = "moving { 0: box [0, 1] x [0, 1]; 2: box [4, 5] x [0, 1]; 3: box [4, 5] x [0, 1] }"
        obstacle = mission(text + end).obstacles["t"]
        assert [float(f[0].vertices[:, 0].min()) for f in obstacle.frames] == [0, middle, 4, 4]
        assert obstacle.sweeps[1].move == (4.0 - middle, 0.0)


def test_linear_needs_as_many_corners() -> None:
    text = "moving { 0: box [0, 1] x [0, 1]; 2: polygon (1, 1) (2, 1) (2, 2) } linear"
    with pytest.raises(MissionError, match="number of corners"):
        mission(text)


ALONG = """
step 1 s
workspace box [0, 10] x [0, 10]
agent r : single_integrator {{ start (0.1, 2.1); control |u| <= 1.2 }}
obstacle wall = box [0, 10] x [0, 2]
obstacle truck = box [2, 6] x [{lane}, 10] velocity (0.1, 0)
require clear: always[0, 8] (r outside wall swept and r outside truck swept)
require reach: eventually[0, 8] r.x >= 7 m
minimize effort
"""


def test_no_way_between_a_wall_and_a_truck_that_drives_along_it() -> None:
    with pytest.raises(InfeasibleError):
        solve(loads(ALONG.format(lane=2)), SolveSettings(threads=1))
    assert solve(loads(ALONG.format(lane=2.2)), SolveSettings(threads=1)).report.ok


CHANGING = """
step 1 s
horizon 1
workspace box [0, 10] x [0, 10]
agent r : single_integrator { start (5, 5); control |u| <= 0.1 }
obstacle two = moving {
  0: box [1, 2] x [1, 2] + box [8, 9] x [8, 9]
  1: polygon (1, 1) (3, 1) (3, 2) (2, 3) (1, 2) + box [8, 9] x [8, 9.5]
}
require clear: always r outside two swept
"""


def test_what_changes_its_corners_takes_up_the_hull_of_each_polygon() -> None:
    """Not the hull of the whole, which would hold the way between its polygons."""
    assert solve(loads(CHANGING), SolveSettings(threads=1)).report.ok
    with pytest.raises(MissionError, match="E0406"):
        loads(CHANGING.replace("start (5, 5)", "start (1.5, 1.5)"))
