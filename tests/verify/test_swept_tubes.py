"""Between the steps disturbed agents keep what is asked of them, whatever pushes them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import shapely

from stlc import api
from stlc.errors import MissionError
from stlc.matrices import exponential
from stlc.mission import Agent, Mission
from stlc.plan import Plan
from stlc.simulate import simulate
from stlc.verify import verify
from stlc.verify.paths import state_paths
from stlc.verify.regions import zonotope

SPIN = """dynamics spin {
  A = [[0, 0, 1, 0], [0, 0, 0, 1], [0, 0, -0.2, 0.6], [0, 0, -0.6, -0.2]]
  B = [[0, 0], [0, 0], [1, 0], [0, 1]]
  continuous; states px py vx vy; inputs ux uy; state_units m m m/s m/s
}
"""
HEAD = """step 1 s
workspace box [0, 10] x [0, 10]
agent a : {kind} {{ start (1, 1); control |u| <= 1; speed <= 2; disturbance |w| <= 0.03 }}
"""
OBSTACLE = "obstacle o = box [3, 5] x [0, 5]\n"
GO = "region dock = box [6, 8] x [1, 4]\nrequire go: eventually[0, {last}] a in dock\n"
CLEAR = "require clear: always a outside o swept\n"
PILLAR = shapely.box(3, 0, 5, 5)
KINDS = [("single_integrator", 11), ("double_integrator", 9), ("spin", 9)]


def mission_of(kind: str, last: int, asked: str) -> Mission:
    text = (SPIN if kind == "spin" else "") + HEAD.format(kind=kind) + GO.format(last=last)
    return api.loads(text + asked + "minimize effort\n")


def pushes_of(agent: Agent, steps: int, count: int) -> Iterator[np.ndarray]:
    """Pushes (T, m): the largest there are, the same or another at each step, and any."""
    rng, (_, m) = np.random.default_rng(3), agent.dynamics.B.shape
    for k in range(count):
        hard = rng.choice([-1.0, 1.0], (steps, m) if k % 3 else (1, m))
        drawn = rng.uniform(-1.0, 1.0, (steps, m)) if k % 3 == 2 else hard
        yield agent.tube.bound * np.broadcast_to(drawn, (steps, m))


def carried_out(agent: Agent, plan: Plan, pushes: np.ndarray, fine: int = 20) -> np.ndarray:
    """The true states (T * fine + 1, n) at all times, the feedback at work."""
    flow, run = agent.dynamics.flow, plan.runs[agent.name]
    n, m = flow.B.shape
    matrix = np.zeros((n + m + 1, n + m + 1))
    matrix[:n] = np.column_stack([flow.A, flow.B, flow.drift])
    onward, x, found = exponential(matrix * (plan.step / fine)), run.states[0], []
    for t, w in enumerate(pushes):
        u = run.inputs[t] + agent.tube.gain @ (x - run.states[t]) + w
        z = np.concatenate([x, u, [1.0]])
        for _ in range(fine):
            found.append(z[:n])
            z = onward @ z
        x = z[:n]
    return np.array([*found, x])


@pytest.mark.parametrize(("kind", "last"), KINDS)
def test_no_disturbance_takes_an_agent_into_an_obstacle(kind: str, last: int) -> None:
    mission = mission_of(kind, last, OBSTACLE + CLEAR)
    outcome = api.solve(mission)
    assert outcome.report.ok
    agent, least = mission.agents["a"], np.inf
    for pushes in pushes_of(agent, mission.horizon, 120):
        at = carried_out(agent, outcome.plan, pushes)[:, :2]
        assert at.min() >= -1e-6
        assert at.max() <= 10 + 1e-6
        least = min(least, float(shapely.distance(PILLAR, shapely.points(at)).min()))
    told = {r.name: r.swept for r in outcome.report.requirements}["clear"]
    assert -1e-6 <= told <= least + 1e-6
    assert least > 0.0 or not shapely.contains(PILLAR, shapely.points(at)).any()
    if kind == "double_integrator":
        assert told == pytest.approx(least, abs=1e-6)  # a corner of the tube is on the corner
        found = simulate(mission, outcome.plan, draws=300, seed=1)
        assert all(e.hold == 300 for e in found.requirements)


@pytest.mark.parametrize(("kind", "last"), KINDS[1:])
def test_a_plan_that_leaves_no_room_between_the_steps_fails(kind: str, last: int) -> None:
    """At the steps it keeps clear wherever its tube is, and between them only on its plan."""
    at_steps = mission_of(kind, last, OBSTACLE + CLEAR.replace(" swept", ""))
    plan = api.solve(at_steps).plan
    swept = mission_of(kind, last, OBSTACLE + CLEAR)
    assert verify(at_steps, plan).ok
    report = verify(swept, plan)
    assert not report.ok
    clear = {r.name: r for r in report.requirements}["clear"]
    assert clear.swept < -1e-3


@pytest.mark.parametrize(
    ("kind", "asked", "slack"),
    [
        ("double_integrator", "always |a.vx| <= 0.9 swept", lambda x: 0.9 - np.abs(x[:, 2])),
        ("spin", "always (a.px + 1 s * a.vy <= 8 m or a.vx <= 0.1 m/s) swept",
         lambda x: np.maximum(8 - x[:, 0] - x[:, 3], 0.1 - x[:, 2])),
        ("spin", "always[0, 5] separation(a, b) >= 0.8 m swept",
         lambda x: np.abs(x[: 5 * 20 + 1, :2] - [4.0, 2.0]).max(axis=1) - 0.8),
        ("double_integrator", "always a in hall swept",
         lambda x: np.minimum(6.4 - x[:, 1], x[:, 1])),
        ("double_integrator", "always a outside ferry swept",
         lambda x: np.abs(x[:, :2] - np.column_stack(
             [2.5 + 0.5 * np.arange(len(x)) / 20, np.full(len(x), 3.0)])).max(axis=1) - 0.5),
    ],
)  # fmt: skip
def test_conditions_hold_at_all_times(kind: str, asked: str, slack: object) -> None:
    last = dict(KINDS)[kind]
    more = (
        "station b at (4, 2)\nregion hall = box [0, 10] x [0, 6.4]\n"
        "obstacle ferry = box [2, 3] x [2.5, 3.5] velocity (0.5, 0)\n"
    )
    mission = mission_of(kind, last, f"{more}require it: {asked}\n")
    outcome = api.solve(mission)
    assert outcome.report.ok
    told = {r.name: r for r in outcome.report.requirements}["it"]
    for pushes in pushes_of(mission.agents["a"], mission.horizon, 60):
        states = carried_out(mission.agents["a"], outcome.plan, pushes)
        assert slack(states).min() >= told.robustness - 1e-6
        assert slack(states).min() >= -1e-6


def test_what_turns_is_kept_clear_of() -> None:
    turning = "obstacle o = moving { 0: polygon (3, 1) (5, 1) (5, 5) (3, 5); "
    turning += "9: polygon (3, 0) (6, 2) (5, 5) (3, 4) } linear\n"
    mission = mission_of("double_integrator", 9, turning + CLEAR)
    outcome = api.solve(mission)
    assert outcome.report.ok
    (near,) = (c for c in outcome.report.clearances if c.what == "body")
    assert near.value >= -1e-6
    calm = api.loads(mission.source.text.replace("; disturbance |w| <= 0.03", ""))
    assert not verify(mission, api.solve(calm).plan).ok


def test_separations_of_two_disturbed_agents_take_both_tubes() -> None:
    text = HEAD.format(kind="double_integrator") + HEAD.format(kind="double_integrator").split(
        "\n"
    )[2].replace("agent a", "agent b").replace("(1, 1)", "(9, 1)")
    asked = """
require a: eventually[0, 8] a.x >= 8 m
require b: eventually[0, 8] b.x <= 2 m
require apart: always separation(a, b) >= 0.5 m swept
minimize effort
"""
    mission = api.loads(text + asked)
    outcome = api.solve(mission)
    assert outcome.report.ok
    apart = outcome.report.requirements[-1]
    agents, draws = mission.agents, list(pushes_of(mission.agents["a"], mission.horizon, 60))
    least = min(
        float(np.abs(one - other).max(axis=1).min())
        for one, other in zip(
            (carried_out(agents["a"], outcome.plan, w)[:, :2] for w in draws),
            (carried_out(agents["b"], outcome.plan, -w)[:, :2] for w in draws),
            strict=True,
        )
    )
    assert least >= 0.5 - 1e-6
    assert apart.swept <= least - 0.5 + 1e-6


def test_tubes_between_the_steps_are_what_the_worst_pushes_make() -> None:
    """Of one push the verifier's tube is exact at all times, the inputs included."""
    asked = "require r: always[0, 1] a.px >= 0 m swept\nminimize effort\n"
    mission = api.loads(SPIN + HEAD.format(kind="spin") + asked)
    agent, plan = mission.agents["a"], api.solve(mission).plan
    (sway,) = state_paths(mission, plan.runs)["a"].sways
    pieces = sway.points.shape[1]
    rows = np.vstack([np.eye(6), [[1.0, 0.0, 0.0, 2.0, 0.0, -1.0]]])
    told = sway.support(rows)[0].reshape(-1, pieces, 7)
    still, worst = carried_out(agent, plan, np.zeros((2, 2)), pieces), np.zeros((2 * pieces, 7))
    end = np.zeros(4)
    for signs in np.ndindex(2, 2, 2, 2):
        w = 0.03 * (2.0 * np.reshape(signs, (2, 2)) - 1.0)
        off = carried_out(agent, plan, w, pieces) - still
        inputs = np.repeat([agent.tube.gain @ off[t * pieces] + w[t] for t in range(2)], pieces, 0)
        both = np.hstack([off[:-1], inputs])
        worst, end = np.maximum(worst, np.abs(both @ rows.T)), np.maximum(end, np.abs(off[-1]))
    np.testing.assert_allclose(told[:2].reshape(-1, 7), worst, atol=1e-9)
    np.testing.assert_allclose(told[2, 0, :4], end, atol=1e-9)


def test_zonotopes_hold_all_sums_and_no_more() -> None:
    parts = np.random.default_rng(0).normal(size=(2, 6))
    hull = shapely.convex_hull(shapely.MultiPoint(zonotope(parts)))
    signs = 2.0 * np.array(list(np.ndindex(*[2] * 6))) - 1.0
    sums = shapely.convex_hull(shapely.MultiPoint(signs @ parts.T))
    assert hull.symmetric_difference(sums).area < 1e-9
    assert zonotope(np.zeros((2, 1))).tolist() == [[0.0, 0.0], [0.0, 0.0]]


def test_flying_past_what_has_heights_is_refused() -> None:
    text = """workspace box [0, 10] x [0, 10]
dynamics drone = double_integrator { dimensions 3; pz in [0, 9]; control |u| <= 1 }
agent a : drone { start (1, 1, 5); disturbance 0.03 }
obstacle tower = box [3, 5] x [0, 5] x [0, 3]
obstacle column = box [7, 8] x [0, 5]
require a: always[0, 4] a outside column swept
"""
    api.loads(text)
    with pytest.raises(MissionError, match="its motion in space between the steps"):
        api.loads(text + "require b: always[0, 4] a outside tower swept\n")
