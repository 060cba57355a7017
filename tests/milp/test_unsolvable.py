"""Missions that no MILP can state: located errors with the number, before any solver is asked."""

from __future__ import annotations

import pytest
from support.command import inside as stlc

from stlc.api import loads
from stlc.errors import MissionError
from stlc.milp.compile import compile_mission

SIGNAL = """step 1 s
signal demand
dynamics tank = single_integrator { dimensions 1 }
agent t : tank { start 2; control |u| <= 1 }
require a: always[0, 5] t.px >= demand
minimize effort
"""
RECORDED = """step 1 s
signal speed [m/s]
signal gear
require calm: always[0 s, 3 s] speed <= 5 m/s
require shift: always (gear >= 2 implies eventually[0, 0] speed >= 1 m/s)
"""


@pytest.mark.parametrize(("text", "names"), [(SIGNAL, ["demand"]), (RECORDED, ["speed", "gear"])])
def test_recorded_signals_are_no_unknowns(text: str, names: list[str]) -> None:
    with pytest.raises(MissionError) as caught:
        compile_mission(loads(text))
    assert [(d.code, d.name) for d in caught.value.diagnostics] == [("E0804", n) for n in names]
    assert all(d.span is not None for d in caught.value.diagnostics)


@pytest.mark.parametrize("command", ["compile", "solve", "explain", "race"])
def test_every_command_names_monitor(command: str, tmp_path) -> None:
    (tmp_path / "m.stl").write_text(SIGNAL, encoding="utf-8")
    done = stlc(command, "m.stl", folder=tmp_path)
    assert done.returncode == 1
    assert "stlc monitor" in done.stderr


@pytest.mark.parametrize(
    ("agent", "rest", "line"),
    [
        ("A = [[1e200]]", "require a: eventually[0, 3] r.px >= 1\nminimize effort", 2),
        ("A = [[1]]", "require a: eventually[0, 3] r.px >= 1\nminimize 1e300 * effort", 4),
        ("A = [[1]]", "require a: always[0, 3] 1e16 * r.px >= 1e16 * r.u0 - 1", 3),
    ],
)
def test_numbers_that_no_solver_takes(agent: str, rest: str, line: int) -> None:
    text = f"dynamics k {{ {agent}; B = [[1]]; states px }}\n"
    text += f"agent r : k {{ start 0; px in [-1, 1]; u0 in [-1, 1] }}\n{rest}\n"
    with pytest.raises(MissionError) as caught:
        compile_mission(loads(text))
    (found,) = caught.value.diagnostics
    assert found.code == "E0805"
    assert found.span is not None
    assert found.span.line == line


def test_a_bound_beyond_the_digits_of_a_solver_is_refused() -> None:
    """1e16 beside states of 1: what is missing can't be told to within 1 m."""
    text = "agent r : single_integrator { start (0, 0); control |u| <= 1 }\n"
    with pytest.raises(MissionError) as caught:
        compile_mission(loads(f"{text}prefer left: eventually[3] r.x <= -1e16\n"))
    (found,) = caught.value.diagnostics
    assert (found.code, found.span.line) == ("E0805", 2)
