"""Whole missions from their text: solved, certified, and verified independently of the encoder."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from stlc.api import loads
from stlc.milp.compile import CompileOptions
from stlc.solve.driver import solve_mission
from stlc.solve.outcome import Outcome, SolveSettings

SPACE = "step 1 s\nhorizon {horizon}\nworkspace box [0, 10] x [0, 10]\n"
CART = "agent a : double_integrator {{ start {start}; control |u| <= 1; speed <= 2\n{more} }}\n"


def plan(text: str, horizon: int = 6, stl: str = "auto") -> Outcome:
    """Solve and verify."""
    mission = loads(SPACE.format(horizon=horizon) + text)
    outcome = solve_mission(mission, SolveSettings(compile=CompileOptions(stl=stl), threads=1))
    assert outcome.report.ok
    return outcome


def positions(outcome: Outcome, name: str = "a") -> np.ndarray:
    return np.asarray(outcome.plan.runs[name].states)[:, :2]


def crosses(run: np.ndarray, low: float, high: float) -> bool:
    """Whether a chord of the run enters the open box [low, high]^2."""
    share = np.linspace(0, 1, 101)[:, None]
    chords = np.concatenate([p + share * (q - p) for p, q in pairwise(run)])
    return bool(((chords > low + 1e-5) & (chords < high - 1e-5)).all(axis=1).any())


BEHIND = (  # the way round costs more than the way through
    "agent a : single_integrator { start (3, 5); control |u| <= 3 }\n"
    "obstacle block = box [4, 6] x [4, 6]\nregion goal = box [6.5, 7] x [4.9, 5.1]\n"
    "require arrive: eventually a in goal\nminimize effort\n"
)


@pytest.mark.parametrize("stl", ["auto", "hull"])
def test_swept_keeps_the_motion_between_samples_outside(stl: str) -> None:
    clear = "require clear: always a outside block"
    loose, tight = (positions(plan(BEHIND + clear + end, 4, stl)) for end in ("", " swept"))
    assert crosses(loose, 4, 6)
    assert not crosses(tight, 4, 6)


@pytest.mark.parametrize("literal", [False, True])
def test_turning_rate_holds_on_the_plan(literal: bool) -> None:
    start, more = ("(2, 2, 1, 0)", "turn_rate literal") if literal else ("(2, 2)", "turn_rate on")
    text = CART.format(start=start, more=more)
    outcome = plan(
        text + "region up = box [3, 8] x [3, 8]\nrequire go: eventually a in up\nminimize effort"
    )
    run = outcome.plan.runs["a"]
    speed = np.linalg.norm(np.asarray(run.states)[:-1, 2:], axis=1)
    push = np.linalg.norm(np.asarray(run.inputs), axis=1)
    assert ((push <= speed / 2 + 1e-6) | (not literal and (speed < 0.1))).all()


def test_integer_inputs_are_whole() -> None:
    text = (
        "agent a : double_integrator { start (1, 1); control |u| <= 2; state |v| <= 3; integer }\n"
        "region goal = box [4.2, 4.8] x [1, 2]\nrequire go: eventually a in goal\nminimize effort"
    )
    inputs = np.asarray(plan(text).plan.runs["a"].inputs)
    assert np.array_equal(inputs, np.round(inputs))
    assert np.abs(inputs).sum() > 0


def test_a_moving_obstacle_is_met_where_it_is() -> None:
    text = CART.format(start="(1, 5)", more="") + (
        "obstacle ferry = moving { 0: box [3, 4] x [0, 10]; 4: box [0, 0.5] x [0, 10] }\n"
        "region goal = box [5, 9] x [4, 6]\n"
        "require clear: always a outside ferry\nrequire go: eventually a in goal\nminimize effort"
    )
    run = positions(plan(text, 9))
    assert not ((run[:4, 0] > 3 + 1e-5) & (run[:4, 0] < 4 - 1e-5)).any()
    assert ((run[4:, 0] > 3) & (run[4:, 0] < 4)).any() or (run[:4, 0] >= 4 - 1e-5).any()
    assert (run[:, 0] >= 5 - 1e-5).any()


LINKED = (
    "agent a : single_integrator { start (8, 8); control |u| <= 2 }\n"
    "station base at (1, 1)\n"
    "channel radio { path_loss L0 = -12.89 dBm, n = 3; fading 4 dB^2; shadowing 4 dB^2\n"
    "  length 2 m; noise_floor -60 dBm; partition 5 x 5 }\n"
)


@pytest.mark.parametrize("predicate", [
    "P(rssi(a, base) >= -36 dBm) >= 0.9", "rssi(a, base) >= -30 dBm", "snr(a, base) >= 30 dB",
])  # fmt: skip
def test_link_predicates_in_a_robustness_objective(predicate: str) -> None:
    text = LINKED + f"require talk: eventually {predicate}\nmaximize robustness(talk)"
    outcome = plan(text, 5)
    reached = next(r for r in outcome.plan.requirements if r.name == "talk")
    assert reached.robustness >= 0
    assert outcome.plan.solve.objective == pytest.approx(reached.robustness, abs=1e-4)
