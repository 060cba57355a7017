"""Soft missions against every run of a small system, by the words of the language guide."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.command import inside as stlc

from stlc import api
from stlc.errors import MissionError
from stlc.solve.given_up import prices
from stlc.solve.outcome import SolveSettings

T = 3
HEAD = """step 1 s
horizon 3
workspace box [0, 4] x [0, 4]
agent a : single_integrator { start (1, 1); control |u| <= 1; integer }
obstacle rock = box [1.8, 2.2] x [0, 1.5]
require away: always a outside rock
"""

Run = np.ndarray  # (T+1, 2) positions

LINES = {
    "far": (": ", "always[3,3] a.x >= 4 m"),
    "top": (" late: ", "eventually[0,1] a.y >= 2 m"),
    "low": (" share: ", "always a.y <= 1 m"),
    "left": (" share: ", "(always[1,2] a.x <= 0 m) and (eventually a.y >= 3 m)"),
    "band": (" margin 0.5 scale 2 m: ", "always[1,3] |a.x - a.y| <= 1 m"),
}


def _far(p: Run) -> float:
    return max(0.0, 4 - p[3, 0])


def _top(p: Run) -> float:
    there = np.flatnonzero(p[:, 1] >= 2)
    return float(max(0, (there[0] if len(there) else T + 1) - 1))


def _low(p: Run) -> float:
    return float((p[:, 1] > 1).mean())


def _left(p: Run) -> float:
    return sum(map(int, (p[1, 0] > 0, p[2, 0] > 0, p[:, 1].max() < 3))) / 3


def _band(p: Run) -> float:
    return max(0.0, 0.5 - (1 - np.abs(p[1:, 0] - p[1:, 1]).max())) / 2


VIOLATION: dict[str, Callable[[Run], float]] = {
    "far": _far, "top": _top, "low": _low, "left": _left, "band": _band,
}  # fmt: skip


def _runs() -> list[tuple[Run, float]]:
    """Every run that keeps the hard rules, and its effort."""
    found = []
    for moves in itertools.product(itertools.product((-1, 0, 1), repeat=2), repeat=T):
        u = np.array(moves, dtype=float)
        p = np.vstack([[1.0, 1.0], 1.0 + np.cumsum(u, axis=0)])
        in_rock = (np.abs(p[:, 0] - 2) < 0.2) & (p[:, 1] < 1.5)
        if (p >= 0).all() and (p <= 4).all() and not in_rock.any():
            found.append((p, float(np.abs(u).sum())))
    return found


RUNS = _runs()


@pytest.mark.parametrize("seed", range(8))
def test_weights_match_brute_force(seed: int) -> None:
    rng = np.random.default_rng(seed)
    names = list(rng.permutation(list(LINES))[:3])
    weights = {name: float(w) for name, w in zip(names, rng.uniform(0.1, 3, 3), strict=True)}
    effort = float(rng.uniform(0, 0.6))
    text = HEAD + "\n".join(f"prefer {_headed(n, f'weight {weights[n]}')}" for n in names)
    outcome = api.solve(api.loads(f"{text}\nminimize {effort} * effort\n"))
    best = min(effort * cost + sum(weights[n] * VIOLATION[n](p) for n in names) for p, cost in RUNS)
    assert outcome.plan.solve.objective == pytest.approx(best, abs=1e-5)
    assert outcome.report.ok
    told = {r.name: r.violation for r in outcome.report.preferences}
    run = np.round(outcome.plan.runs["a"].states, 4)
    for n in names:
        scale = 2 if n == "band" else 1
        assert told[n] == pytest.approx(scale * VIOLATION[n](run), abs=1e-4)


def _headed(name: str, words: str) -> str:
    """The line of a preference, with further words in its head."""
    return f"{name} {words}{''.join(LINES[name])}"


@pytest.mark.parametrize("seed", range(6))
def test_tiers_are_lexicographic(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    names = list(rng.permutation(list(LINES))[:4])
    ranks = dict(zip(names, (1, 2, 2, 3), strict=True))
    weights = {name: float(w) for name, w in zip(names, rng.uniform(0.5, 2, 4), strict=True)}
    lines = [f"prefer {_headed(n, f'priority {ranks[n]} weight {weights[n]}')}" for n in names]
    mission = api.loads(HEAD + "\n".join(lines) + "\nminimize effort\n")
    outcome = api.solve(mission)
    left = RUNS
    for rank in (1, 2, 3):
        tier = [n for n in names if ranks[n] == rank]
        scores = [sum(weights[n] * VIOLATION[n](p) for n in tier) for p, _ in left]
        left = [r for r, s in zip(left, scores, strict=True) if s <= min(scores) + 1e-6]
    assert outcome.plan.solve.objective == pytest.approx(min(e for _, e in left), abs=1e-4)
    assert api.verify(mission, outcome.plan).ok


def test_a_price_is_that_of_the_mission_which_requires_it() -> None:
    soft = HEAD + "prefer far weight 0.4: always[3,3] a.x >= 3 m\nminimize effort\n"
    mission = api.loads(soft)
    outcome = api.solve(mission)
    assert [r.kept for r in outcome.report.preferences] == [False]
    (price,) = prices(mission, outcome, SolveSettings(), 20.0)
    hard = api.solve(api.loads(soft.replace("prefer far weight 0.4", "require far")))
    assert price.objective == pytest.approx(hard.plan.solve.objective, abs=1e-5)
    never = api.loads(HEAD + "prefer far: always a.x >= 3 m\nminimize effort\n")
    (price,) = prices(never, api.solve(never), SolveSettings(), 20.0)
    assert price.objective is None
    assert price.proven


def test_a_claim_of_less_violation_is_refuted(tmp_path: Path) -> None:
    from dataclasses import replace

    mission = api.loads(HEAD + "prefer far: always a.x >= 3 m\nminimize effort\n")
    plan = api.solve(mission).plan
    assert plan.solve.objective == pytest.approx(2.0)
    lie = replace(plan, solve=replace(plan.solve, objective=1.0, bound=1.0))
    assert not api.verify(mission, lie).ok


def test_links_may_be_preferred() -> None:
    text = """step 1 s
horizon 3
workspace box [0, 8] x [0, 2]
agent a : single_integrator { start (1, 1); control |u| <= 2 }
station mast at (7, 1)
channel radio { path_loss L0 = -20 dBm, n = 2; fading 4 dB^2, shadowing 4 dB^2, length 2 m
  partition 8 x 2; bound centre }
prefer near weight 0.2: always[3,3] rssi(a, mast) >= -21 dBm
prefer heard weight 3 share: always[1,3] rssi(a, mast) >= -34 dBm
minimize effort
"""
    mission = api.loads(text)
    outcome = api.solve(mission)
    assert outcome.report.ok
    told = {r.name: r for r in outcome.report.preferences}
    assert told["heard"].kept
    assert not told["near"].kept
    assert api.verify(mission, outcome.plan).ok


@pytest.mark.parametrize(
    "line",
    [
        "prefer x weight -1: always a.x >= 1 m",
        "prefer x priority 0: always a.x >= 1 m",
        "prefer x scale 0: always a.x >= 1 m",
        "prefer x late: always a.x >= 1 m",
        "prefer x late share: eventually[0,1] a.x >= 1 m",
        "prefer x scale 2 dB: always a.x >= 1 m",
        "prefer away: always a.x >= 1 m",
        "maximize robustness\nprefer x: always a.x >= 1 m",
        "prefer x weight 1 weight 2: always a.x >= 1 m",
    ],
)
def test_preferences_without_meaning_are_told(line: str) -> None:
    with pytest.raises(MissionError) as caught:
        api.loads(HEAD + line + "\n")
    assert all(d.span is not None for d in caught.value.diagnostics)


def test_the_command_tells_what_was_given_up(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(
        HEAD + "prefer far weight 0.4: always[3,3] a.x >= 3 m\nminimize effort\n"
    )
    done = stlc("solve", "m.stl", "-o", "p.json", "--progress", "none", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "gave up far by 2 m" in done.stdout
    assert "keeping it makes the objective 3 in place of 0.8" in done.stdout
    said = json.loads(stlc("solve", "m.stl", "--json", folder=tmp_path).stdout)
    assert said["preferences"][0]["kept"] is False
    assert said["keeping"][0]["proven"] is True
    assert "gave up far" in stlc("verify", "m.stl", "p.json", folder=tmp_path).stdout
