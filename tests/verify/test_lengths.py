"""Lengths are judged as Euclidean ones, whatever polygons a model takes for them."""

import math

import numpy as np
import pytest

from stlc.api import loads
from stlc.monitor import monitor
from stlc.plan import make_plan
from stlc.solve.driver import solve_mission
from stlc.verify import verify
from stlc.verify.lengths import GAP, Curve, least

HEAD = """
horizon 1
workspace box [-10, 10] x [-10, 10]
agent r1 : single_integrator {{ start (2.95, 0.6); control |u| <= 1 }}
station base at (0, 0)
require a: {}
"""
D = math.hypot(2.95, 0.6)


def judged(requirement: str, move=(0.0, 0.0)):
    mission = loads(HEAD.format(requirement))
    runs = {"r1": mission.agents["r1"].start + np.array([[0.0, 0.0], move])}
    plan = make_plan(mission, runs, {"r1": np.array([move])})
    return verify(mission, plan).requirements[0]


def robustness(requirement: str) -> float | None:
    return judged(requirement).robustness


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


def test_lengths_of_who_is_not_disturbed_are_euclidean_beside_who_is():
    other = (
        "agent d : single_integrator {{ start (9, 9); control |u| <= 1; disturbance |w| <= 0.1 }}"
    )
    text = (HEAD + other).format("always distance(r1, base) >= 3.005")
    mission = loads(text)
    runs = {name: np.tile(agent.start, (2, 1)) for name, agent in mission.agents.items()}
    plan = make_plan(mission, runs, dict.fromkeys(runs, np.zeros((1, 2))))
    found = verify(mission, plan).requirements[0]
    assert found.robustness == pytest.approx(D - 3.005, abs=1e-9)


STAY, WEST, SOUTH = (0.0, 0.0), (-1.0, 0.0), (0.0, -1.0)


@pytest.mark.parametrize(
    ("condition", "move", "value"),
    [
        ("distance(r1, base) >= 3.005", STAY, D - 3.005),
        ("distance(r1, base) <= 3.005", WEST, 3.005 - D),
        ("distance(r1, (2.45, 0)) >= 0.5", WEST, 0.1),
        ("distance(r1, base, 4) >= 2.5", SOUTH, 0.45),
        ("(not (norm(r1.x, r1.y) <= 2.9 m)) ", SOUTH, 0.05),
        ("(distance(r1, base) - distance(r1, (5, 0)) >= 0)", WEST,
         math.hypot(1.95, 0.6) - math.hypot(3.05, 0.6)),
        ("(r1.y <= 0.1 m implies distance(r1, base) >= 2.9)", SOUTH, 0.05),
    ],
)  # fmt: skip
def test_lengths_are_euclidean_between_the_steps(condition, move, value):
    found = judged(f"always {condition} swept", move)
    assert found.swept == pytest.approx(value, abs=2e-7)
    assert found.satisfied == (value >= 0)


def test_least_values_of_lengths_are_those_of_dense_samples():
    """Of any sums, minima and maxima, never above the true value."""
    random = np.random.default_rng(5)
    s = np.linspace(0.0, 1.0, 1001)
    powers = np.stack([np.ones_like(s), s, s * s])
    for _ in range(5):
        rest, places = random.normal(size=(3, 3, 4)), random.normal(size=(3, 3, 4, 2))
        factors = random.normal(size=3)
        curves = [
            Curve(r, ((c, p), (0.5, p[::-1])))
            for r, c, p in zip(rest, factors, places, strict=True)
        ]  # fmt: skip
        combine = lambda q: np.minimum(q[..., 0], np.maximum(q[..., 1], q[..., 2]))  # noqa: E731
        dense = np.stack([c.at(np.repeat(np.arange(4), len(s)), np.tile(s, 4)) for c in curves], -1)
        for c, r, p, values in zip(factors, rest, places, dense.T, strict=True):
            sizes = [np.linalg.norm(np.einsum("krd,ks->rsd", k, powers), axis=-1)
                     for k in (p, p[::-1])]  # fmt: skip
            made = np.einsum("kr,ks->rs", r, powers) + c * sizes[0] + 0.5 * sizes[1]
            assert made.ravel() == pytest.approx(values)
        true = combine(dense).reshape(4, -1).min(axis=1)
        found = least(curves, combine, 4)
        assert (found <= true + 1e-12).all()
        assert (found >= true - GAP - 1e-3).all()


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
