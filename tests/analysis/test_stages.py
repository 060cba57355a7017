"""Interval hulls of conjunctions of predicates."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stlc.analysis.stages import box_of
from stlc.api import loads
from stlc.errors import MissionError
from stlc.ir.nodes import Linear, Role, Signal
from stlc.milp.compile import compile_mission

X, Y = (Signal("r", Role.STATE, k) for k in range(2))


def _hull(predicate: Linear, low: list[float], high: list[float]) -> list[list[float]]:
    found = box_of([predicate], lambda unit: 0.0, np.array(low), np.array(high))
    return [side.tolist() for side in found]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        ([0, 0], [10, 10], [[0, 0], [4, 4]]),
        ([-math.inf, 0], [math.inf, 10], [[-math.inf, 0], [4, 10]]),
        ([-math.inf, -math.inf], [math.inf, math.inf], [[-math.inf] * 2, [math.inf] * 2]),
    ],
)
def test_a_face_bounds_what_the_other_signals_leave(
    low: list[float], high: list[float], expected: list[list[float]]
) -> None:
    """x + y <= 4: an unbounded x is bounded by the rest, and bounds nothing itself."""
    face = Linear(((X, -1.0), (Y, -1.0)), 4.0, "m")
    assert _hull(face, low, high) == expected


@pytest.mark.filterwarnings("error")
def test_an_unbounded_agent_is_not_called_out_of_reach() -> None:
    mission = loads(
        "horizon 6\nagent a : double_integrator { start (9, 9) }\n"
        "obstacle o = box [4, 5] x [4, 5]\nrequire clear: always a outside o\n"
    )
    with pytest.raises(MissionError) as error:
        compile_mission(mission)
    assert [d.code for d in error.value.diagnostics] == ["E0802"]


@pytest.mark.filterwarnings("error")
def test_a_gain_next_to_nothing_bounds_nothing() -> None:
    mission = loads(
        "horizon 5\ndynamics car { states px py vx vy\n"
        "A = [[1, 0, 1, 0], [0, 1, 0, 1e-320], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
        "B = [[0, 0], [0, 0], [1, 0], [0, 1]] }\n"
        "agent r : car { start (6, 1, 0, 0); px in [0, 15]; py in [0, 10]; vx in [-2, 2]\n"
        "vy in [-2, 2]; control |u| <= 0.5 }\nminimize effort\n"
    )
    assert compile_mission(mission).model.columns > 0
