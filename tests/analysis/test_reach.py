"""Interval reach sets."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

from stlc.analysis.forward import Box
from stlc.analysis.reach import propagate, reach
from stlc.api import loads
from stlc.errors import InfeasibleError, MissionError
from stlc.ir.nodes import Linear, Role, Signal
from stlc.milp.compile import compile_mission
from stlc.mission import Mission

FREE = """step 1 s
horizon 3
agent a : double_integrator { start (1, 1) }
region far = box [5, 6] x [1, 2]
require visit: always[3, 3] a in far
minimize effort
"""


def test_what_nothing_bounds_stays_infinite() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ranges = reach(loads(FREE, name="free.stl"))["a"]
    assert np.isneginf(ranges.state_lower[2:]).all()
    assert np.isposinf(ranges.state_upper[2:]).all()
    assert np.isneginf(ranges.input_lower).all()
    assert np.isposinf(ranges.input_upper).all()


UNSTABLE = """step 1 s
horizon 50
dynamics k { A = [[10, 0], [0, 1]]; B = [[1, 0], [0, 1]]; states px py }
agent r : k { start (START, 1); control |u| <= 1; BOUND }
require a: eventually[0, 50] r.y >= 2 m
"""


def unstable(start: str, bound: str = "") -> Mission:
    text = UNSTABLE.replace("START", start).replace("BOUND", bound)
    return loads(text, name="unstable.stl")


@pytest.mark.parametrize("start", ["1", "0"])
def test_a_state_that_outgrows_doubles_is_a_located_error(start: str) -> None:
    with pytest.raises(MissionError) as caught:
        compile_mission(unstable(start))
    (found,) = caught.value.diagnostics
    assert found.code == "E0803"
    assert found.span is not None
    assert found.span.line == 4


def test_powers_of_a_that_overflow_are_a_located_error() -> None:
    text = UNSTABLE.replace("[[10, 0]", "[[1e300, 0]").replace("START", "0").replace("BOUND", "")
    with pytest.raises(MissionError, match="E0803"):
        compile_mission(loads(text))


def test_bounds_keep_an_unstable_state_within_doubles() -> None:
    assert compile_mission(unstable("0", "px in [-5, 5]")).model.columns
    with pytest.raises(InfeasibleError, match="no value of px is left at step 2"):
        compile_mission(unstable("1", "px in [-5, 5]"))


def test_unbounded_inputs_leave_an_unstable_state_unbounded() -> None:
    text = UNSTABLE.replace("START", "1").replace("control |u| <= 1; BOUND", "u1 <= 1")
    ranges = reach(loads(text))["r"]
    assert np.isposinf(ranges.state_upper[50, 0])


@pytest.mark.parametrize("offset", [0.0, 5e6, 9e7])
def test_far_from_the_origin_rounding_cuts_nothing_off(offset: float) -> None:
    """The steps of a walk that just arrives, hundreds of steps long."""
    text = f"""step 0.1 s
horizon 800
param o = {offset!r} m
agent r : double_integrator {{ start (o, o); vx in [-1, 1]; vy in [-1, 1]; control |u| <= 0.1 }}
require a: always[800, 800] (r.x >= o + 70 m and r.y <= o - 70 m)
"""
    mission = loads(text)
    ranges = reach(mission, within=reach(mission))["r"]
    drive = np.concatenate([np.full(100, 0.1), np.zeros(700)])
    x = np.array([offset, offset, 0.0, 0.0])
    dynamics = mission.agents["r"].dynamics
    for step, u in enumerate(drive):
        x = dynamics.A @ x + dynamics.B @ np.array([u, -u])
        assert (x >= ranges.state_lower[step + 1] - 1e-6).all()
        assert (x <= ranges.state_upper[step + 1] + 1e-6).all()


def test_small_entries_do_not_make_rounding_large() -> None:
    """A state that barely moves another says nothing about where it is itself."""
    text = """horizon 3
dynamics k { A = [[1, 1e-13], [0, 1]]; B = [[0], [1]]; states px py }
agent r : k { start (100, 0); control |u| <= 1 }
require a: always[0, 3] r.px >= 99 m
"""
    ranges = reach(loads(text))["r"]
    assert ranges.state_lower[3, 1] <= -3
    assert ranges.state_upper[3, 1] >= 3


HUGE = """step 1 s
horizon 3
workspace box [0, 10] x [0, 10]
dynamics k { A = [[1, 0], [0, ENTRY]]; B = [[1, 0], [0, 1]]; states px py }
agent r : k { start (1, 2); control |u| <= 1 }
require a: always[0, 3] r.x >= 0 m
"""


def test_a_step_that_overflows_is_a_located_error_and_not_infeasible() -> None:
    with pytest.raises(MissionError) as caught:
        compile_mission(loads(HUGE.replace("ENTRY", "1e308")))
    (found,) = caught.value.diagnostics
    assert (found.code, found.span is not None) == ("E0803", True)
    assert "`py` of agent `r` can be inf at step 1" in str(caught.value)
    with pytest.raises(InfeasibleError):
        compile_mission(loads(HUGE.replace("ENTRY", "1e200")))


def _box(matrix: list[list[float]], low: list[float], high: list[float]) -> Box:
    """An agent's intervals at two steps, as wide as `low` and `high` say, inputs within 1."""
    mission = loads(UNSTABLE.replace("START", "0").replace("BOUND", "").replace("50", "1"))
    agent = mission.agents["r"]
    agent = replace(agent, dynamics=replace(agent.dynamics, A=np.array(matrix)))
    ends = (np.tile(np.array(end, dtype=float), (2, 1)) for end in (low, high))
    return Box(agent, *ends, -np.ones((1, 2)), np.ones((1, 2)))


@pytest.mark.parametrize(
    ("matrix", "value"),
    [
        ([[1e200, 0.0], [0.0, 1.0]], [1e200, 0.0]),  # a product overflows
        ([[1e308, 1e308], [0.0, 1.0]], [1.0, 1.0]),  # a sum does
        ([[1e-320, 0.0], [0.0, 1.0]], [3.0, 0.0]),  # a product that lost its digits
    ],
)
@pytest.mark.filterwarnings("error")
def test_what_overflows_says_nothing(matrix: list[list[float]], value: list[float]) -> None:
    box = _box(matrix, value, value)
    box.x_lower[1], box.x_upper[1] = [-np.inf, -np.inf], [np.inf, np.inf]
    propagate({"r": box}, [])
    assert not np.isnan(np.concatenate([box.x_lower, box.x_upper])).any()
    assert (box.x_lower[0] <= value).all()
    assert (box.x_upper[0] >= value).all()
    assert (box.x_lower[1] < np.inf).all()
    assert (box.x_upper[1] > -np.inf).all()


def test_a_demand_on_what_differs_much_in_size_cuts_no_point_off() -> None:
    """The rest of a sum, worked out as the sum less one part, forgets what is small."""
    box = _box([[1.0, 0.0], [0.0, 1.0]], [-1e16, -1.0], [1e16, 1.0])
    px, py = (Signal("r", Role.STATE, index, 0) for index in (0, 1))
    propagate({"r": box}, [(Linear(((px, 1.0), (py, 1.0)), 0.0, "m"), 0.5)])
    assert box.x_lower[0, 0] <= -0.5  # where py is 1


@pytest.mark.filterwarnings("error")
def test_bounds_whose_difference_overflows_warn_nobody() -> None:
    """An input between -1e308 and 1e308 is as wide as no double."""
    text = """horizon 6
workspace box [0, 10] x [0, 10]
agent b : single_integrator { start (8, 2); control |u| <= 1e308 }
require up: always[5, 6] b.y >= 4 m
"""
    ranges = reach(loads(text))["b"]
    assert (ranges.state_lower[6, 1], ranges.state_upper[6, 1]) == (0.0, 10.0)
