"""Disturbed agents: plans hold whatever the disturbance does, and are not stricter than that."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from stlc import api
from stlc.analysis.tubes import spreads
from stlc.channels import true_robustness, true_values
from stlc.errors import InfeasibleError, MissionError
from stlc.ir.nodes import Link, Role, walk
from stlc.mission import Agent, Mission
from stlc.plan import Plan
from stlc.simulate import simulate
from stlc.verify import verify
from stlc.verify.robustness import Evaluator
from stlc.verify.trace import Trace
from stlc.verify.tubes import half_widths

HEAD = """step 1 s
horizon 6
workspace box [0, 10] x [0, 10]
agent a : double_integrator {{ start (1, 1); control |u| <= 1; speed <= 2; {more} }}
obstacle pillar = box [3, 5] x [0, 5]
region dock = box [6, 8] x [1, 4]
"""
ASKED = """require clear: always a outside pillar
require go: eventually[0, 6] a in dock
require calm: always[5, 6] |a.vx| <= 0.8
minimize effort
"""


def _mission(more: str = "disturbance |w| <= 0.04", asked: str = ASKED) -> Mission:
    return api.loads(HEAD.format(more=more) + asked)


def _pushed(agent: Agent, plan: Plan, pushes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The true run (T+1, n) and commanded inputs (T, m) under pushes (T, m)."""
    model, run = agent.dynamics, plan.runs[agent.name]
    states, inputs = [run.states[0]], []
    for t, w in enumerate(pushes):
        u = run.inputs[t] + agent.tube.gain @ (states[-1] - run.states[t])
        inputs.append(u)
        states.append(model.A @ states[-1] + model.B @ (u + w) + model.drift)
    return np.array(states), np.array(inputs)


def test_plans_hold_whatever_the_disturbance_does() -> None:
    mission = _mission()
    agent = mission.agents["a"]
    outcome = api.solve(mission)
    assert outcome.report.ok
    assert any("whatever its disturbance does" in note for note in outcome.report.notes)
    rng = np.random.default_rng(0)
    draws = [rng.uniform(-0.04, 0.04, (6, 2)) for _ in range(100)]
    draws += [0.04 * rng.choice([-1.0, 1.0], (6, 2)) for _ in range(300)]
    least = np.inf
    for pushes in draws:
        x, u = _pushed(agent, outcome.plan, pushes)
        assert (x[:, :2] >= -1e-6).all()
        assert (np.abs(u) <= 1 + 1e-6).all()
        assert (np.hypot(x[1:, 2], x[1:, 3]) <= 2 + 1e-6).all()
        trace = Trace(7, {("a", Role.STATE): x, ("a", Role.INPUT): u})
        judge = Evaluator(trace)
        values = [judge.robustness(r.formula)[0] for r in mission.requirements]
        assert min(values) >= -1e-6
        least = min(least, *values)
    told = min(r.robustness for r in outcome.report.requirements)
    assert told <= least + 1e-6


def test_a_plan_without_room_is_none() -> None:
    plan = api.solve(_mission("")).plan
    report = verify(_mission(), plan)
    assert not report.ok
    assert api.solve(_mission()).plan.solve.objective > plan.solve.objective + 1e-3
    with pytest.raises(InfeasibleError):
        api.solve(_mission("disturbance 0.6"))


@pytest.mark.parametrize("horizon", [1, 4, 7])
def test_tubes_are_what_the_worst_pushes_make(horizon: int) -> None:
    mission = _mission("disturbance (0.04, 0.1)")
    agent = mission.agents["a"]
    found, by_verifier = spreads(agent, horizon), half_widths(agent, horizon)
    for one, other in zip(found, by_verifier, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)
    model, gain = agent.dynamics, agent.tube.gain
    worst = np.zeros_like(found[0])
    steps = min(horizon, 4)
    for signs in itertools.product((-1.0, 1.0), repeat=2 * steps):
        e = np.zeros(4)
        for t, w in enumerate(np.reshape(signs, (steps, 2))):
            e = model.A @ e + model.B @ (gain @ e + agent.tube.bound * w)
            worst[t + 1] = np.maximum(worst[t + 1], np.abs(e))
    np.testing.assert_allclose(worst[: steps + 1], found[0][: steps + 1], atol=1e-9)


def test_the_simulation_agrees() -> None:
    mission = _mission()
    found = simulate(mission, api.solve(mission).plan, draws=2000, seed=1)
    assert all(e.hold == 2000 for e in found.requirements)


def test_negations_and_constants_are_strict_too() -> None:
    asked = (
        "require off: always not (a.x >= 5 m)\nrequire up: eventually a.y >= 4 m\nminimize effort"
    )
    mission = _mission(asked=asked)
    plan = api.solve(mission).plan
    report = verify(mission, plan)
    width = spreads(mission.agents["a"], 6)[0]
    off = (5 - plan.runs["a"].states[:, 0] - width[:, 0]).min()
    up = (plan.runs["a"].states[:, 1] - width[:, 1] - 4).max()
    values = {r.name: r.robustness for r in report.requirements}
    assert values["off"] == pytest.approx(off, abs=1e-9)
    assert values["up"] == pytest.approx(up, abs=1e-9)


HEARD = "rssi(a, base) >= -47 dBm"
RADIO = """station base at (9, 9)
channel c { path_loss L0 = -30 dBm, n = 2; partition 5 x 5 }
"""


@pytest.mark.parametrize(
    ("more", "asked", "told"),
    [
        ("disturbance -1", ASKED, "not below 0"),
        ("disturbance |w| >= 1", ASKED, "size of the disturbance"),
        ("disturbance (1, 2, 3)", ASKED, ""),
        ("disturbance 0.1; integer", ASKED, "can't be `integer`"),
        ("disturbance 0.1; turn_rate on", ASKED, "can't be `turn_rate`"),
        (
            "disturbance 0.1",
            RADIO.replace("5 x 5", "5 x 5; bound centre") + "require l: eventually " + HEARD,
            "`bound centre`",
        ),
    ],
)
def test_what_no_tube_tells(more: str, asked: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(MissionError) as caught:
        _mission(more, asked)
    assert told in str(caught.value)


LINKS = RADIO.replace("5 x 5", "10 x 10") + "require hear: eventually[3, 4] always[0, 2] "
STILL = "require s: eventually[0, 6] a.x >= 0.5 m\n"


@pytest.mark.parametrize(
    "asked", [HEARD, "P(rssi(a, base) >= -49 dBm) >= 0.9", "rssi(a, base) <= -49 dBm"]
)
def test_links_hold_wherever_a_disturbance_carries_their_ends(asked: str) -> None:
    """No push takes a link below its threshold (or above it), and the verdict knows that."""
    pushed = "disturbance |w| <= 0.04"
    mission = _mission(pushed, LINKS.replace("n = 2", "n = 2; fading 1 dB^2") + asked)
    outcome = api.solve(mission)
    (told,) = (r.robustness for r in outcome.report.requirements)
    assert outcome.report.ok
    rng = np.random.default_rng(1)
    agent, channel = mission.agents["a"], mission.channels["c"]
    base = np.tile(mission.stations["base"].place, (7, 1))
    for _ in range(60):
        x, _ = _pushed(agent, outcome.plan, 0.04 * rng.choice([-1.0, 1.0], (6, 2)))
        places = np.column_stack([x[:, :2], np.zeros(7)])
        (link,) = {n for r in mission.requirements for n in walk(r.formula) if isinstance(n, Link)}
        values = true_values(mission, channel, ("a", "base"), places, base)
        held = true_robustness(channel, link, values)
        best = max(held[t : t + 3].min() for t in (3, 4))
        assert best >= told - 1e-6


def test_a_link_is_judged_at_the_corners_of_a_tube() -> None:
    """A run on the verge is good where the agent is on its plan, and not where it may be off."""
    asked = LINKS + "rssi(a, base) >= -46 dBm"
    runs = [
        verify(_mission(more, asked), api.solve(_mission(more, STILL + "minimize effort")).plan)
        for more in ("mass 1 kg", "disturbance |w| <= 0.04")
    ]
    calm, shaken = (r.requirements[-1].true for r in runs)
    assert calm is not None
    assert shaken is not None
    assert shaken < calm - 0.05


def test_what_stays_near_its_plan_does_so_for_ever() -> None:
    agent = _mission("disturbance |w| <= 0.04").agents["a"]
    assert agent.tube is not None
    whole = agent.tube.widest(agent.dynamics.A, agent.dynamics.B)
    for horizon in (5, 60):
        found = spreads(agent, horizon)
        assert found is not None
        assert (found[0][-1] <= whole + 1e-12).all()
    assert found[0][-1] == pytest.approx(whole, rel=1e-3)


FLYING = """step 1 s
workspace box [0, 10] x [0, 10]
dynamics drone = double_integrator { dimensions 3; pz in [0, 12]; control |u| <= 2 }
agent a : drone { start (1, 1, 6); disturbance (0.03, 0.03, 0.2) }
agent b : single_integrator { start (9, 5); control |u| <= 1; disturbance 0.03; antenna 1 m }
channel c { path_loss L0 = -30 dBm, n = 2; partition 3 x 3 x 3 }
require near: always[2, 4] rssi(a, b) >= -49 dBm
require far: eventually[2, 4] rssi(a, b) <= -42 dBm
minimize effort
"""


def test_links_in_space_hold_wherever_disturbances_carry_their_ends() -> None:
    """The pushes are mostly up and down, which a box in the plane would not know."""
    mission = api.loads(FLYING)
    outcome = api.solve(mission)
    told = {r.name: r.robustness for r in outcome.report.requirements}
    assert outcome.report.ok
    rng, (a, b) = np.random.default_rng(2), (mission.agents["a"], mission.agents["b"])
    links = {r.name: n for r in mission.requirements for n in walk(r.formula) if type(n) is Link}
    for _ in range(60):
        hard = a.tube.bound * rng.choice([-1.0, 1.0], (mission.horizon, 3))
        x, _ = _pushed(a, outcome.plan, hard)
        y, _ = _pushed(b, outcome.plan, 0.03 * rng.choice([-1.0, 1.0], (mission.horizon, 2)))
        ends = x[:, :3], np.column_stack([y, np.zeros(len(y))])
        values = true_values(mission, mission.channels["c"], ("a", "b"), *ends)
        near, far = (true_robustness(mission.channels["c"], links[n], values) for n in links)
        assert near[2:5].min() >= told["near"] - 1e-6
        assert far[2:5].max() >= told["far"] - 1e-6


def test_the_verdict_on_a_flying_link_knows_the_heights_of_its_tube() -> None:
    calm = FLYING.replace("; disturbance (0.03, 0.03, 0.2)", "").replace("; disturbance 0.03", "")
    plan = api.solve(api.loads(calm)).plan
    upright = calm.replace("start (1, 1, 6)", "start (1, 1, 6); disturbance (0, 0, 0.2)")
    still, pushed = (
        {r.name: r.true for r in verify(api.loads(text), plan).requirements}
        for text in (calm, upright)
    )
    assert pushed["near"] < still["near"] - 0.05
    assert pushed["far"] < still["far"] - 0.05
