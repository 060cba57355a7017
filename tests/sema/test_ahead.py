"""`ahead(x, time)`: the value of an expression some time later."""

from __future__ import annotations

import numpy as np
import pytest

from stlc.api import loads, solve
from stlc.errors import MissionError
from stlc.ir.nodes import Linear
from stlc.monitor import monitor_formulas
from stlc.recording import Recording

HEAD = "step 0.5 s\nsignal x\nsignal y\nparam d = 1 s\n"


def values(formula: str) -> list[float]:
    """Robustness over x = 0, 1, 4, 9, .. and y = 0, -1, -2, .."""
    mission = loads(f"{HEAD}require: {formula}\n")
    steps = np.arange(8.0)
    recording = Recording("trace", 0.5 * steps, {"x": steps**2, "y": -steps})
    (found,) = monitor_formulas(mission.requirements, recording, mission).formulas
    return found.robustness.tolist()


def test_signals_are_shifted() -> None:
    assert values("ahead(x, 1) - x >= 0") == [1, 3, 5, 7, 9, 11, 13]
    assert values("ahead(x - y, 1 s) >= 0") == [6, 12, 20, 30, 42, 56]
    assert values("ahead(ahead(x, 1), d) >= 0") == [9, 16, 25, 36, 49]
    assert values("ahead(3, 2) + y >= 0") == [3, 2, 1, 0, -1, -2, -3, -4]


def test_folds_are_shifted() -> None:
    assert values("ahead(abs(y), 500 ms) >= 0") == [1, 2, 3, 4, 5, 6, 7]
    assert values("min(x, ahead(x, 2)) - max(ahead(y, 1), y) >= 0") == [0, 2, 6, 12, 20, 30]


def test_equal_signals_cancel() -> None:
    mission = loads(f"{HEAD}require: ahead(x, 2) - ahead(x, 1 s) + y >= 0\n")
    formula = mission.requirements[0].formula
    assert isinstance(formula, Linear)
    assert [s.owner for s, _ in formula.terms] == ["y"]


def test_a_let_takes_the_time() -> None:
    mission = loads(f"{HEAD}let rise(k) = ahead(x, k) - x\nrequire: rise(d) >= 1\n")
    assert mission.horizon == 2


@pytest.mark.parametrize(
    ("call", "code"),
    [
        ("ahead(x, -1)", "E0503"),
        ("ahead(x, 0.3 s)", "E0501"),
        ("ahead(x, 1 m)", "E0507"),
        ("ahead(x, y)", "E0203"),
        ("ahead(x)", "E0204"),
    ],
)
def test_mistakes(call: str, code: str) -> None:
    with pytest.raises(MissionError) as caught:
        loads(f"{HEAD}require: {call} >= y\n")
    assert [d.code for d in caught.value.diagnostics] == [code]


def test_agents_move_as_asked() -> None:
    mission = loads(
        "step 1 s\nworkspace box [0, 10] x [0, 10]\n"
        "agent r1 : single_integrator { start (1, 1); control |u| <= 2 }\n"
        "require slow: always[0, 3] abs(ahead(r1.x, 2 s) - r1.x) <= 1\n"
        "require go: eventually[0, 6] r1.x >= 3\nminimize effort\n"
    )
    assert mission.horizon == 6
    outcome = solve(mission)
    x = outcome.plan.runs["r1"].states[:, 0]
    assert np.abs(x[2:6] - x[:4]).max() <= 1 + 1e-6
    assert x.max() >= 3 - 1e-6
