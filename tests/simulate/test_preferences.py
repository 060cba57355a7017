"""How often preferences are kept, and how much they are violated, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from stlc import api
from stlc.mission import Mission
from stlc.plan import Plan, make_plan
from stlc.simulate import simulate

DRAWS = 40_000

HEAD = """step 1 s
horizon 4
workspace box [0, 10] x [0, 10]
agent a : single_integrator {{ start (1, 1); control |u| <= 1; {a} }}
agent b : single_integrator {{ start (6, 1); control |u| <= 1 }}
channel radio {{ path_loss L0 = -10 dBm, n = 2; fading 4 dB^2; partition 4 x 4 }}
"""


def _mission(*lines: str, a: str = "") -> Mission:
    return api.loads(HEAD.format(a=a) + "\n".join(lines))


def _plan(mission: Mission, moves: dict[str, list[tuple[float, float]]] | None = None) -> Plan:
    """The plan of given inputs; who has none stays where it is."""
    states, inputs = {}, {}
    for name, agent in mission.agents.items():
        u = np.array((moves or {}).get(name, [(0.0, 0.0)] * mission.horizon))
        inputs[name] = u
        states[name] = agent.start + np.vstack([np.zeros(2), np.cumsum(u, axis=0)])
    return make_plan(mission, states, inputs)


def test_preferences_are_kept_as_often_as_the_same_requirement_holds() -> None:
    """In the same draws: `prefer` beside `require`, by the same formula and margin."""
    formula = "always[0, 3] rssi(a, b) >= -25 dBm"
    lines = (f"require r: {formula}", f"prefer p weight 2 margin 1: {formula}")
    mission = _mission(*lines)
    found = simulate(mission, _plan(mission), draws=DRAWS, seed=3)
    (required,), (wished,) = found.requirements, found.preferences
    assert required.robustness is not None
    assert wished.hold == int((required.robustness >= 1.0 - 1e-6).sum())
    assert 0 < wished.hold < required.hold < DRAWS
    lack = np.maximum(0.0, 1.0 - required.robustness).mean()
    assert wished.violation == pytest.approx(lack)
    assert (wished.unit, wished.margin) == ("dB", 1.0)
    assert found.joint.hold == required.hold  # preferences are none of it
    assert f"violated by {lack:.4g} dB on average" in found.text()
    assert found.as_dict()["preferences"][0]["violation"] == pytest.approx(lack)


def test_late_and_shared_preferences_count_their_parts() -> None:
    """A noisy agent: each part by itself is a normal probability."""
    lines = (
        "prefer soon late: eventually[0, 2] a.x >= 1.5 m",
        "prefer kept share: always[1, 4] a.y >= 1 m",
        "prefer sure: always b.x >= 5 m",
    )
    mission = _mission(*lines, a="start_noise 0.2 m")
    plan = _plan(mission, {"a": [(0.1, 0.0)] * 4})
    found = simulate(mission, plan, draws=DRAWS, seed=5, confidence=0.9999)
    soon, kept, sure = found.preferences
    assert soon.low <= float(norm.sf(1.5, 1.2, 0.2)) <= soon.high
    late = sum(float(norm.cdf(1.5, 1.0 + 0.1 * t, 0.2)) for t in (2, 3, 4))
    assert soon.violation == pytest.approx(late, rel=0.02)
    assert soon.unit == "s"
    assert kept.low <= 0.5 <= kept.high
    assert kept.violation == pytest.approx(0.5, abs=0.02)
    assert sure.certain
    assert sure.violation == 0.0


def test_costs_that_are_lowered_to_preferences_are_none() -> None:
    lines = ("require r: eventually a.x >= 0 m", "minimize time(r)")
    mission = _mission(*lines)
    assert simulate(mission, _plan(mission), draws=10).preferences == ()
