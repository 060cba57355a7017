"""Signals known beforehand, in predicates and in costs, against all runs of small systems."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from support.command import inside as stlc

from stlc import api
from stlc.errors import MissionError
from stlc.mission import Mission
from stlc.plan import make_plan
from stlc.render import render
from stlc.renew.past import along
from stlc.renew.replanning import replan
from stlc.verify import verify

DATA = """time,price,need,odd name
0,3,1,a
1,1,2,b
2,2,0,c
3,5,3,d
4,1,2,e
5,2,1,f
"""
PRICE, NEED = [3, 1, 2, 5, 1, 2], [1, 2, 0, 3, 2, 1]

HEAD = """step 1 s
horizon 5
dynamics tank { A = [[1]]; B = [[1, -1]]; states level; inputs fill drain
  fill in [0, 2]; drain in [0, 2]; level in [0, 4] }
agent t : tank { start 2; integer }
signal price from "data.csv"
signal need from "data.csv"
"""

ASKED = [
    "require enough: always t.level >= need\nminimize total(price * t.fill)",
    "require on: always[0, 4] t.drain >= 0.5 * need\n"
    "minimize total(price * t.fill + |t.level - 1|)",
    "require later: always[0, 3] t.level >= ahead(need, 2) - 1\n"
    "minimize total(price * t.fill)[1, 4]",
    "require cheap: always (price >= 2 implies t.level >= 1)\n"
    "minimize total(price * (t.fill - 0.5 * t.drain)) + total(max(t.level - 3, 1 - t.level, 0))",
    "require rest: always[end] t.level >= 3\nmaximize total(0.3 * price * t.drain - 2 * t.fill)",
    "let short = need - t.level\nrequire few: always short <= 0.5\n"
    "minimize total(short) + total(2 * t.fill)",
    "require both: eventually[0, 5] always[0, 1] price * t.level >= 4\n"
    "minimize total(min(price, 2) * t.fill) + effort",
]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "data.csv").write_text(DATA)
    return tmp_path


def _runs(mission: Mission, start: float, steps: int):
    moves = list(itertools.product((0.0, 1.0, 2.0), repeat=2))
    moves = [m for m in moves if min(m) == 0.0 or m == (1.0, 1.0)]
    todo = [(np.array([[start]]), np.empty((0, 2)))]
    for _ in range(steps):
        todo = [
            (np.vstack([x, [[y]]]), np.vstack([u, [m]]))
            for x, u in todo
            for m in moves
            if 0 <= (y := x[-1, 0] + m[0] - m[1]) <= 4
        ]
    return todo


def _costs(mission: Mission, runs) -> np.ndarray:
    """Objectives of the runs that the verifier accepts, to be minimised."""
    found = []
    for x, u in runs:
        report = verify(mission, make_plan(mission, {"t": x}, {"t": u}))
        if report.ok:
            sign = 1.0 if report.sense.value == "minimize" else -1.0
            found.append(sign * report.objective[0])
    return np.array(found)


@pytest.mark.parametrize("asked", ASKED)
def test_the_best_of_all_runs(asked: str, folder: Path) -> None:
    for long, short in (("[0, 5]", "[0, 3]"), ("[0, 4]", "[0, 3]"), ("need, 2", "need, 1")):
        asked = asked.replace(long, short)
    mission = api.loads(HEAD.replace("horizon 5", "horizon 4") + asked, folder=folder)
    best = _costs(mission, _runs(mission, 2.0, 4)).min()
    outcome = api.solve(mission)
    sign = 1.0 if outcome.plan.solve.sense.value == "minimize" else -1.0
    assert sign * outcome.plan.solve.objective == pytest.approx(best, abs=1e-4)


def test_robustness_and_costs_are_those_of_the_numbers(folder: Path) -> None:
    mission = api.loads(HEAD + ASKED[1].replace("always[0, 4]", "always[1, 4]"), folder=folder)
    x = np.array([2.0, 3, 2, 1, 3, 1])[:, None]
    u = np.array([[1.0, 0], [0, 1], [0, 1], [2, 0], [0, 2]])
    report = verify(mission, make_plan(mission, {"t": x}, {"t": u}))
    drains = [u[t, 1] - 0.5 * NEED[t] for t in range(1, 5)]
    assert report.requirements[0].robustness == pytest.approx(min(drains))
    cost = sum(PRICE[t] * u[t, 0] + abs(x[t, 0] - 1) for t in range(5))
    assert report.objective[0] == pytest.approx(cost)


def test_units_are_those_of_the_file(folder: Path) -> None:
    text = HEAD.replace("signal need", "signal need [km]").replace(
        "states level", "states level; state_units m"
    )
    mission = api.loads(text + "require a: eventually t.level >= need / 1000", folder=folder)
    x = np.array([2.0, 3, 2, 1, 3, 1])[:, None]
    report = verify(mission, make_plan(mission, {"t": x}, {"t": np.zeros((5, 2))}))
    assert report.requirements[0].robustness == pytest.approx(2.0)


def test_planned_anew_the_clock_goes_on(folder: Path) -> None:
    mission = api.loads(HEAD + ASKED[0], folder=folder)
    plan = api.solve(mission).plan
    again = replan(mission, along(mission, plan, 2, {}), old=plan)
    assert again.kept
    assert again.plan.solve.objective == pytest.approx(plan.solve.objective, abs=1e-4)
    pushed = along(mission, plan, 2, {"t": np.array([4.0])})
    assert replan(mission, pushed, old=plan).kept


def test_recordings_are_judged_against_them(folder: Path) -> None:
    (folder / "spec.stl").write_text(
        'step 1 s\nsignal need from "data.csv"\nsignal level\nrequire a: always level >= need\n'
    )
    (folder / "run.csv").write_text("time,level\n0,2\n1,2\n2,2\n3,3.5\n")
    done = stlc("monitor", "spec.stl", "run.csv", folder=folder)
    assert done.returncode == 0, done.stderr
    assert "robustness 0" in done.stdout


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ("horizon 9\nrequire a: always t.level >= need", "known up to step 5; step 9 is needed"),
        ("require a: always t.level >= ahead(need, 3)", "known up to step 2; step 5"),
        ("require a: eventually[0, need] t.level >= 1", "changes from step to step"),
        ("require a: eventually t.level >= 3\nminimize total(-|t.level|)", "not convex"),
        ("require a: eventually t.level >= 3\nmaximize total(|t.level|)", "not convex"),
        ("require a: eventually t.level >= 3\nminimize total(t.level, 3)", "of one thing"),
        ("require a: eventually t.level >= 3\nminimize total(| |t.level| - 1 |)", "within another"),
        ("signal free\nrequire a: eventually t.level >= 3\nminimize total(free)", "beforehand"),
        ("require a: eventually t.level >= 3\nminimize normalised(total(t.level))", "static range"),
        ('signal p from "none.csv"\nrequire a: eventually t.level >= p', "none.csv"),
        ('signal p from "data.csv"\nrequire a: eventually t.level >= p', "no column 'p'"),
        ('signal q from "late.csv"\nrequire a: eventually t.level >= q', "begins at 1 s"),
        ('signal q from "bad.csv"\nrequire a: eventually t.level >= q', "no number"),
    ],
)
def test_signals_that_are_not_known(asked: str, told: str, folder: Path) -> None:
    (folder / "late.csv").write_text("time,q\n1,1\n2,2\n3,3\n4,4\n5,5\n6,6\n7,7\n")
    (folder / "bad.csv").write_text("time,q\n0,1\n1,x\n2,3\n3,4\n4,5\n5,6\n")
    text = HEAD.replace("horizon 5\n", "") if asked.startswith("horizon") else HEAD
    with pytest.raises(MissionError) as caught:
        api.loads(text + asked, folder=folder)
    assert told in render(caught.value.diagnostics)
