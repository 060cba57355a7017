"""Amounts that links carry over several steps: planned, verified, and those that are none."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from stlc import api
from stlc.channels import ChannelTables
from stlc.errors import MissionError
from stlc.ir.networks import Count
from stlc.mission import Mission
from stlc.plan import Plan, make_plan
from stlc.render import render
from stlc.verify import verify

HEAD = """step 2 s
horizon 4
workspace box [0, 6] x [0, 4]
agent a : single_integrator {{ start (1, 1); control |u| <= 1; integer }}
station base at (5.5, 0.5)
channel radio {{
  path_loss L0 = -40 dBm, n = 2; noise_floor -60 dBm; partition 6 x 4; bound {bound}
  rates {rates}
}}
"""
RATES = "(4 dB, 1 Mbit/s) (8 dB, 2.5 Mbit/s) (14 dB, 6 Mbit/s)"
LEVELS, SPEEDS = np.array([4.0, 8.0, 14.0]), np.array([0.0, 1.0, 2.5, 6.0])


def _mission(asked: str, bound: str = "worst", rates: str = RATES) -> Mission:
    return api.loads(HEAD.format(bound=bound, rates=rates) + asked)


def _carried(plan: Plan, first: int, last: int) -> float:
    """Mbit at the true positions, by hand."""
    places = plan.runs["a"].states[first : last + 1, :2]
    away = np.maximum(np.linalg.norm(places - [5.5, 0.5], axis=1), 1.0)
    snr = -40 - 20 * np.log10(away) + 60
    return float(2 * SPEEDS[np.searchsorted(LEVELS, snr, side="right")].sum())


@pytest.mark.parametrize("amount", [8, 17, 23, 36])
def test_the_least_effort_that_delivers(amount: int) -> None:
    """Of all runs on the grid that integer inputs leave (2 m a step)."""
    mission = _mission(f"require d: delivered(a, base) >= {amount} Mbit\nminimize effort")
    moves = [np.array(m, float) for m in itertools.product((-1, 0, 1), repeat=2)]
    tables, best = ChannelTables(mission), np.inf
    runs = itertools.product(moves, repeat=4)
    for steps in sorted(runs, key=lambda run: float(np.abs(run).sum())):
        u = np.array(steps)
        x = np.vstack([[1.0, 1.0], 1.0 + 2.0 * np.cumsum(u, axis=0)])
        if (x < 0).any() or (x > [6, 4]).any():
            continue
        plan = make_plan(mission, {"a": x}, {"a": u})
        if verify(mission, plan, tables).ok:
            best = float(np.abs(u).sum())
            assert _carried(plan, 0, 4) >= amount
            break
    outcome = api.solve(mission)
    assert outcome.plan.solve.objective == pytest.approx(best, abs=1e-4)
    assert _carried(outcome.plan, 0, 4) >= amount
    rate = outcome.plan.links[0].values["rate"]
    assert 2e-6 * rate.sum() == pytest.approx(_carried(outcome.plan, 0, 4))


@pytest.mark.parametrize("bound", ["worst", "centre", "mean"])
def test_windows_nest_and_turn(bound: str) -> None:
    mission = _mission(
        "require late: eventually[0, 2] delivered(a, base)[0, 2] >= 20 Mbit\n"
        "require little: delivered(a, base)[0, 1] <= 10 Mbit\n"
        "require also: 500 kbit <= delivered(a, base, radio)\nminimize effort",
        bound,
    )
    outcome = api.solve(mission)
    assert outcome.report.ok
    assert isinstance(mission.requirements[0].formula.children[0], Count)


def test_robustness_is_in_decibels_of_all_steps() -> None:
    mission = _mission("require d: delivered(a, base)[0, 0] >= 1 Mbit", "centre")
    x = np.tile([3.0, 1.0], (5, 1))
    report = verify(mission, make_plan(mission, {"a": x}, {"a": np.zeros((4, 2))}))
    # 2 s at 1 Mbit/s would do: the SNR in the better cell, 2 m away, is so far above 4 dB
    spare = 20 - 20 * np.log10(2.0) - 4
    assert report.requirements[0].robustness == pytest.approx(spare, abs=1e-6)


def test_more_than_all_rates_can_carry() -> None:
    mission = _mission("require d: eventually a.x >= 2 m and not (delivered(a, base) >= 61 Mbit)")
    assert api.solve(mission).report.ok
    with pytest.raises(MissionError, match="can never hold"):
        _mission("require d: delivered(a, base) >= 61 Mbit")


@pytest.mark.parametrize(
    ("asked", "rates", "told"),
    [
        ("delivered(a, base) >= 3 Mbit/s", RATES, "bit"),
        ("delivered(a, base) == 3 Mbit", RATES, "`>=` or `<=`"),
        ("delivered(a, base)[2] >= 3 Mbit", RATES, "two ends"),
        ("delivered(a, base)[3, 2] >= 3 Mbit", RATES, "3"),
        ("delivered(a) >= 3 Mbit", RATES, "two ends"),
        ("delivered(a, base) + 1 >= 3 Mbit", RATES, "an amount that is delivered"),
        ("delivered(a, base) >= delivered(a, base)", RATES, "an amount"),
        ("always delivered(a, base)[0, 9] >= 3 Mbit", RATES, "horizon"),
        ("delivered(a, base) >= 3 Mbit", "(4 dB, 2 Mbit/s) (3 dB, 3 Mbit/s)", "must rise"),
        ("delivered(a, base) >= 3 Mbit", "(4 dB, 2 Mbit/s) (5 dB, 1 Mbit/s)", "must rise"),
        ("delivered(a, base) >= 3 Mbit", "4 dB", "pairs of an SNR and a rate"),
        ("delivered(a, base) >= 3 Mbit", "(4 dB, 1000001 bit/s) (9 dB, 2 Mbit/s)", "round the"),
    ],
)
def test_amounts_that_are_none(asked: str, rates: str, told: str) -> None:
    with pytest.raises(MissionError) as caught:
        _mission(f"require d: {asked}", rates=rates)
    assert told in render(caught.value.diagnostics)


def test_what_channels_must_have() -> None:
    text = HEAD.format(bound="worst", rates="").replace("rates", "")
    with pytest.raises(MissionError) as caught:
        api.loads(text + "require d: delivered(a, base) >= 3 Mbit")
    assert "needs its rates" in render(caught.value.diagnostics)
