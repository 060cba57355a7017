"""The size of a model is known before it is built."""

from __future__ import annotations

import pytest
from support.command import inside as stlc

from stlc.analysis.sizes import check_size, formula_size
from stlc.api import loads
from stlc.errors import MissionError
from stlc.ir.rewrite import postorder
from stlc.milp.compile import CompileOptions, compile_mission
from stlc.passes import horizon, nnf, unroll
from stlc.passes.base import Program

AGENT = "agent r : double_integrator { start (1, 1); control |u| <= 1 }\n"
LONG = AGENT + "require a: always[0, 60000] (r.x >= 0 m until[0, 60000] r.y >= 1 m)\n"


@pytest.mark.parametrize(
    "text",
    [
        "always[0, 60] r.x >= 0 m",
        "always[0, 60] eventually[0, 40] r.x >= 0 m",
        "always[0, 60] (r.x >= 0 m until[0, 40] r.y >= 1 m)",
        "eventually[5, 60] (r.x >= 0 m release[3, 30] r.y >= 1 m)",
        "always[0, 30] eventually[0, 30] always[0, 30] (r.x >= 0 m or r.y >= 2 m)",
        "r.x >= 0 m until[10, 80] (r.y >= 1 m and eventually[0, 5] r.y >= 2 m)",
    ],
)
def test_the_estimate_is_near_what_unrolling_makes(text: str) -> None:
    mission = loads(f"{AGENT}require a: {text}\n")
    program = Program(mission.requirements, mission)
    for step in (nnf, horizon, unroll):
        program = step.run(program)
    made = sum(max(len(n.children), 1) for n in postorder(program.formulas))
    assert 0.4 <= formula_size(mission.requirements[0], mission.horizon) / made <= 2.5


def test_too_large_a_model_is_refused_at_what_is_largest() -> None:
    with pytest.raises(MissionError) as caught:
        compile_mission(loads(LONG))
    (found,) = caught.value.diagnostics
    assert found.code == "E0806"
    assert found.span is not None
    assert found.span.line == 2
    many = "horizon 3000\nagent u[1..90] : double_integrator { start (i, 1); control |u| <= 1 }\n"
    with pytest.raises(MissionError, match="E0806"):
        check_size(loads(many + "require a: eventually u[1].x >= 2 m\n"))


def test_states_over_a_long_horizon_count_for_the_time_that_they_take() -> None:
    """An agent over 30,000 steps takes half a minute to bound, whatever is asked of it."""
    agent = "agent r : double_integrator { start (1, 1); control |u| <= 1 }\n"
    lines = "require a: always[0, {last}] r.x >= 0 m\n"
    check_size(loads(agent + lines.format(last=20_000)))
    with pytest.raises(MissionError, match="the model would have 600,020 parts"):
        check_size(loads(agent + lines.format(last=30_000)))


def test_the_limit_can_be_moved(tmp_path) -> None:
    text = AGENT + "require a: eventually[0, 5] r.x >= 2 m\nminimize effort\n"
    (tmp_path / "m.stl").write_text(text, encoding="utf-8")
    for command in ("compile", "solve"):
        done = stlc(command, "m.stl", "--max-size", "20", folder=tmp_path)
        assert done.returncode == 1
        assert "E0806" in done.stderr
        assert stlc(command, "m.stl", "--max-size", "200", folder=tmp_path).returncode == 0
    assert compile_mission(loads(text), CompileOptions(max_size=200)).model.columns
