"""`minimize time(..)`: the first time at which something holds."""

from __future__ import annotations

import pytest

from stlc import api
from stlc.errors import MissionError
from stlc.solve.outcome import SolveSettings

HEAD = """
step 0.5 s
horizon 8
workspace box [0, 12] x [0, 4]
agent r1 : single_integrator { start (1, 1); control |u| <= 2 }
region near = box [3, 4] x [0, 4]
region far = box [7.5, 9] x [0, 4]
"""


def _times(text: str) -> tuple[float | None, dict[str, float]]:
    outcome = api.solve(api.loads(HEAD + text), SolveSettings(time_limit=60.0))
    reports = outcome.report.preferences
    assert all(r.kept and r.cost for r in reports)
    return outcome.plan.solve.objective, {r.name: r.violation for r in reports}


def test_a_requirement_with_a_deadline_is_met_as_soon_as_can_be() -> None:
    objective, times = _times("require reach: eventually r1 in far\nminimize time(reach)\n")
    assert objective == pytest.approx(3.5)  # 6.5 m at 2 m/s, in steps of 0.5 s
    assert times == {"time(reach)": pytest.approx(3.5)}


def test_formulas_have_times_too_and_weights_count() -> None:
    text = """
require reach: (r1.x <= 9 m) until[0, 8] r1 in far
require back: eventually[4, 8] r1 in near
minimize 2 * time(reach) + time(r1.x >= 2 m) + time(back)
"""
    objective, times = _times(text)
    assert times["time(r1.x >= 2 m)"] == pytest.approx(0.5)
    assert times["time(reach)"] == pytest.approx(4.0)  # it waits to be near at step 4
    assert times["time(back)"] == pytest.approx(0.0)  # counted from step 4
    assert objective == pytest.approx(8.5)


@pytest.mark.parametrize(
    "text",
    [
        "require a: always r1.x >= 0 m\nminimize time(a)",
        "require a: eventually r1 in far\nminimize normalised(time(a))",
        "require a: eventually r1 in far\nminimize time(a)[0, 4]",
        "require a: eventually r1 in far\nminimize time()",
    ],
)
def test_what_has_no_first_time_is_an_error(text: str) -> None:
    with pytest.raises(MissionError, match="E0701"):
        api.loads(HEAD + text + "\n")


def test_times_are_not_maximised() -> None:
    with pytest.raises(MissionError, match="E0703"):
        api.loads(HEAD + "require a: eventually r1 in far\nmaximize time(a)\n")


def test_what_holds_eventually_always_holds_at_the_end() -> None:
    text = """
agent r2 : double_integrator { start (1, 1, 1, 0); control |u| <= 1; speed <= 2 }
require reach: eventually r2.x >= 3 m
require rest: eventually always |r2.vx| <= 0
minimize effort
"""
    plan = api.solve(api.loads(HEAD + text), SolveSettings(time_limit=60.0)).plan
    speeds = plan.runs["r2"].states[:, 2]
    assert abs(speeds[-1]) <= 1e-6
    assert abs(speeds[0]) == 1.0
