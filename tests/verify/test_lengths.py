"""Lengths are judged as Euclidean ones, whatever polygons a model takes for them."""

import math

import numpy as np
import pytest

from stlc.api import loads
from stlc.monitor import monitor
from stlc.plan import make_plan
from stlc.solve.driver import solve_mission
from stlc.verify import verify

HEAD = """
horizon 1
workspace box [-10, 10] x [-10, 10]
agent r1 : single_integrator {{ start (2.95, 0.6); control |u| <= 1 }}
station base at (0, 0)
require a: {}
"""
D = math.hypot(2.95, 0.6)


def robustness(requirement: str) -> float | None:
    mission = loads(HEAD.format(requirement))
    runs = {"r1": np.tile(mission.agents["r1"].start, (2, 1))}
    plan = make_plan(mission, runs, {"r1": np.zeros((1, 2))})
    return verify(mission, plan).requirements[0].robustness


@pytest.mark.parametrize(
    ("requirement", "value"),
    [
        ("always distance(r1, base) >= 3.005", D - 3.005),
        ("always distance(r1, base) <= 3.005", 3.005 - D),
        ("always not (distance(r1, base) <= 3.005)", D - 3.005),
        ("always norm(r1.x, r1.y) >= 3.005 m", D - 3.005),
        ("always 2 * distance(r1, base) - r1.x >= 3 m", 2 * D - 5.95),
        ("always max(distance(r1, base), r1.x) >= 3 m", D - 3.0),
        ("always min(distance(r1, base), r1.x) <= 2.9 m", -0.05),
        ("always distance(r1, base) + distance(r1, (5, 0)) <= 6", 6 - D - math.hypot(2.05, 0.6)),
        ("always (distance(r1, base) >= 3 iff r1.x >= 2 m)", D - 3.0),
    ],
)
def test_the_verifier_measures_lengths(requirement, value):
    assert robustness(requirement) == pytest.approx(value, abs=1e-9)


def test_the_monitor_measures_lengths(tmp_path):
    mission = loads("signal x [m]\nsignal y [m]\nrequire a: norm(x, y) >= 3.005 m")
    trace = tmp_path / "trace.csv"
    trace.write_text("t,x,y\n0,2.95,0.6\n")
    report = monitor(mission, trace)
    assert report.ok
    assert report.formulas[0].robustness[0] == pytest.approx(D - 3.005, abs=1e-9)


def test_a_proven_bound_is_one_on_the_polygons():
    text = HEAD.format("always distance(r1, base) >= 2.5") + "maximize robustness(a)\n"
    outcome = solve_mission(loads(text))
    (requirement,) = outcome.report.requirements
    assert requirement.robustness == pytest.approx(D - 2.5, abs=1e-6)
    assert outcome.report.ok
