"""Objectives, horizons, and missions published elsewhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stlc.api import load, loads
from stlc.errors import MissionError
from stlc.ir.nodes import Always, Eventually, Or
from stlc.mission import ObjectiveTerm, PolygonKind, TermKind

HEAD = """
workspace box [0, 10] x [0, 10]
agent a : double_integrator { start (1, 1) }
agent b : double_integrator { start (9, 1) }
channel radio { path_loss L0 = -40 dBm, n = 2; noise_floor -90 dBm; partition 2 x 2 }
station base at (5, 0)
param alpha = 0.25
let total = effort + 2 * link_cost(radio)
require apart: always[0, 5] separation(a, b) >= 1 m
require near: always[0, 5] separation(a, b) <= 9 m
"""


def terms(objective: str) -> tuple[ObjectiveTerm, ...]:
    return loads(HEAD + objective + "\n").objective


def test_weights() -> None:
    effort, link = terms("minimize alpha * effort + (1 - alpha) * link_cost(radio) / 3")
    assert (effort.kind, effort.weight) == (TermKind.EFFORT, 0.25)
    assert (link.kind, link.weight) == (TermKind.LINK_COST, 0.25)
    assert [t.weight for t in terms("minimize 3 * total")] == [3.0, 6.0]
    assert [t.weight for t in terms("minimize -(-effort) * 2 + 0 * effort(a)")] == [2.0]


def test_windows_and_members() -> None:
    (term,) = terms("minimize effort(a)[1, 4 s]")
    assert (term.agents, term.window) == (("a",), (1, 4))
    assert [t.agents for t in terms("minimize sum r in agents: effort(r)")] == [("a",), ("b",)]
    (link,) = terms("minimize normalised(link_cost(radio, (a, base)))")
    assert (link.pairs, link.normalised) == ((("a", "base"),), True)


def test_robustness() -> None:
    (term,) = terms("maximize robustness")
    assert (term.kind, term.weight, term.requirement) == (TermKind.ROBUSTNESS, -1.0, None)
    (one,) = terms("maximize 2 * robustness(apart)")
    assert (one.weight, one.requirement) == (-2.0, "apart")
    assert [t.weight for t in terms("minimize effort\nmaximize robustness")] == [1.0, -1.0]
    mixed = "require talk: always[0, 5] rssi(a, b) >= -70 dBm\n"
    (scaled,) = terms(mixed + "maximize robustness(scale(1 m, 10 dB))")
    assert scaled.scales == {"m": 1.0, "dB": 10.0}
    terms(mixed + "maximize robustness(talk)")


@pytest.mark.parametrize(
    ("objective", "code"),
    [
        ("minimize effort + 3", "E0701"),
        ("minimize effort / 0", "E0701"),
        ("minimize normalised(robustness)", "E0701"),
        ("minimize normalised(effort(a))", "E0701"),  # nothing bounds its inputs
        ("maximize robustness(apartt)", "E0201"),
        ("minimize effort(base)", "E0203"),
        ("minimize effort[4, 1]", "E0502"),
        ("maximize robustness(scale(0 m))", "E0701"),
        ("minimize total\nlet total = effort", "E0202"),
    ],
)
def test_mistakes(objective: str, code: str) -> None:
    with pytest.raises(MissionError) as caught:
        terms(objective)
    assert [d.code for d in caught.value.diagnostics] == [code]


@pytest.mark.parametrize(
    ("formula", "horizon"),
    [
        ("eventually[0, 8] a.x >= 1", 8),
        ("eventually[0, 8] always[0, 3] a.x >= 1", 11),
        ("(eventually[0, 8] a.x >= 1) and always b.x >= 1", 8),
        ("(a.x >= 1) until[2, 6] (next a.y >= 1)", 7),
        ("always[0, 8] (a.x >= 1 swept)", 9),
        ("always[0, 8] a.ux <= 1", 9),
    ],
)
def test_horizons_come_from_the_formula(formula: str, horizon: int) -> None:
    text = (
        "agent a : double_integrator { start (0, 0) }\n"
        f"agent b : double_integrator {{ start (0, 0) }}\nrequire: {formula}\n"
    )
    assert loads(text).horizon == horizon


def test_the_paper_setting_with_every_number_fixed() -> None:
    path = Path(__file__).parents[2] / "benchmarks" / "missions" / "two_agents_t8.stl"
    mission = load(path)
    agent = mission.agents["a1"]
    assert mission.horizon == 8
    assert np.array_equal(agent.dynamics.B, [[0.5, 0], [0, 0.5], [1, 0], [0, 1]])
    assert np.array_equal(agent.state_upper, [np.inf, np.inf, 2, 2])
    assert (agent.state_norms[0].sides, agent.state_norms[0].kind) == (8, PolygonKind.OUTER)
    assert np.array_equal(agent.effort_state, [0, 0, 1, 1])
    reach = mission.requirements[0].formula
    assert isinstance(reach, Eventually)
    assert (reach.start, reach.end) == (1, 8)
    clear = mission.requirements[2].formula
    assert isinstance(clear, Always)
    assert isinstance(clear.arg, Or)
    assert len(clear.arg.args) == 4
    table = mission.channels["radio"].tables[None]
    assert table.shape == (100, 100)
    cells = mission.channels["radio"].partition
    assert cells.boxes[10 * 3 + 7].tolist() == [3, 4, 7, 8]


def test_obstacles_may_reach_beyond_the_bounds_in_silence() -> None:
    mission = loads(
        """
horizon 20
dynamics car {
  states px py vx vy
  inputs ux uy
  A = [[1, 0, 1, 0], [0, 1, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]]
  B = [[0, 0], [0, 0], [1, 0], [0, 1]]
}
agent r : car { start (6, 1, 0, 0); px in [0, 15]; py in [0, 10]; vx in [-2, 2]; vy in [-2, 2]
  control |u| <= 0.5 }
obstacle wall = box [8, 15.01] x [-0.01, 4]
region door = box [12.8, 14] x [3.99, 6.01]
region key = box [1, 2] x [1, 2]
region goal = box [14.1, 14.9] x [4.1, 5.9]
require spec: (always r outside wall) and ((r outside door) until[0, 20] (r in key))
  and (eventually[0, 20] r in goal)
maximize robustness
"""
    )
    assert mission.warnings == ()


def test_a_misspelt_cost_is_recognised() -> None:
    with pytest.raises(MissionError) as caught:
        terms("minimize efort")
    (found,) = caught.value.diagnostics
    assert found.help_text == "did you mean `effort`?"


@pytest.mark.parametrize("cost", ["effort(a, a)", "link_cost(radio, (a, b), (b, a))"])
def test_nothing_is_counted_twice(cost: str) -> None:
    with pytest.raises(MissionError, match="is listed twice"):
        terms(f"minimize {cost}")
