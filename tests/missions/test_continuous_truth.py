"""Plans with `swept` and a workspace, simulated densely by an integrator of the test's own."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.linalg import expm

from stlc.api import loads, solve, verify
from stlc.errors import InfeasibleError
from stlc.mission import Mission
from stlc.places import Polytope
from stlc.plan import Plan, make_plan

POINTS = 200
SLACK = 2e-6
ZERO, EYE = np.zeros((2, 2)), np.eye(2)
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])

SECOND = np.block([[ZERO, EYE], [ZERO, ZERO]])
CONTINUOUS = {
    "single_integrator": (ZERO, EYE),
    "double_integrator": (SECOND, np.vstack([ZERO, EYE])),
    "damped": (np.block([[ZERO, EYE], [ZERO, -0.6 * EYE]]), np.vstack([ZERO, EYE])),
    "turning": (np.block([[ZERO, EYE], [ZERO, 0.9 * TURN - 0.2 * EYE]]), np.vstack([ZERO, EYE])),
}
"""x' = A x + B u of each kind."""


def matrix(values: np.ndarray) -> str:
    return "[" + ", ".join("[" + ", ".join(f"{v:.17g}" for v in row) + "]" for row in values) + "]"


def held(kind: str, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Zero-order hold over dt."""
    a, b = CONTINUOUS[kind]
    n, m = b.shape
    whole = np.zeros((n + m, n + m))
    whole[:n] = np.hstack([a, b])
    found = expm(whole * dt)
    return found[:n, :n], found[:n, n:]


def dynamics(kind: str, step: float, *, discrete: bool = False) -> str:
    """The statement that declares `cart`."""
    if kind.endswith("integrator"):
        return f"dynamics cart = {kind}"
    a, b = held(kind, step) if discrete else CONTINUOUS[kind]
    word = "" if discrete else "continuous; "
    names = "states px py vx vy; inputs ux uy"
    return f"dynamics cart {{ {word}{names}\nA = {matrix(a)}\nB = {matrix(b)} }}"


def dense(kind: str, mission: Mission, plan: Plan) -> dict[str, np.ndarray]:
    """Positions (T, POINTS + 1, 2) of every agent, from starts of steps and inputs alone."""
    found = {}
    for name, run in plan.runs.items():
        along = []
        for share in np.linspace(0.0, 1.0, POINTS + 1):
            a, b = held(kind, share * mission.step)
            along.append((run.states[:-1] @ a.T + run.inputs @ b.T)[:, :2])
        found[name] = np.stack(along, axis=1)
    return found


def world(kind: str, seed: int, *, discrete: bool = False, step: float = 1.0) -> str:
    """Two agents that swap sides past a pillar."""
    random = np.random.default_rng(seed)
    x, y = random.uniform(3.2, 4.2), random.uniform(2.0, 3.4)
    y1, y2 = random.uniform(0.3, 4.7, 2)
    rest = "" if kind == "single_integrator" else "vx in [-2.5, 2.5]; vy in [-2.5, 2.5];"
    return f"""
step {step} s
horizon 7
workspace box [0, 8] x [0, 5]
{dynamics(kind, step, discrete=discrete)}
agent a : cart {{ start (0.5, {y1}); {rest} control |u| <= 2 }}
agent b : cart {{ start (7.5, {y2}); {rest} control |u| <= 2 }}
obstacle pillar = box [{x}, {x + 0.7}] x [{y}, {y + 0.8}]
region east = box [6.5, 8] x [0, 5]
region west = box [0, 1.5] x [0, 5]
require there: eventually (a in east and b in west)
require clear: always forall r in agents: r outside pillar swept
require apart: always (separation(a, b) >= 0.6 m) swept
minimize effort
"""


@pytest.mark.parametrize(
    ("kind", "seed", "discrete"),
    [
        *product(CONTINUOUS, (1, 2), [False]),
        ("damped", 3, True),
        ("turning", 3, True),
    ],
)
def test_plans_hold_at_all_times(kind: str, seed: int, discrete: bool) -> None:
    mission = loads(world(kind, seed, discrete=discrete))
    assert mission.workspace_swept
    plan = solve(mission).plan
    motion = dense(kind, mission, plan)
    space, pillar = mission.workspace, mission.obstacles["pillar"].frames[0][0]
    assert space is not None
    for place in motion.values():
        assert (place @ space.normals.T - space.offsets).max() <= SLACK
        assert (place @ pillar.normals.T - pillar.offsets).max(axis=-1).min() >= -SLACK
    assert np.abs(motion["a"] - motion["b"]).max(axis=-1).min() >= 0.6 - SLACK


def distance(place: np.ndarray, box: Polytope) -> float:
    """Euclidean distance of a motion to a box, negative inside it."""
    behind = place @ box.normals.T - box.offsets
    away = np.linalg.norm(np.maximum(behind, 0.0), axis=-1)
    return float(np.where(away > 0.0, away, behind.max(axis=-1)).min())


@pytest.mark.parametrize("kind", CONTINUOUS)
def test_verdicts_on_random_runs_are_sound(kind: str) -> None:
    """No verdict is better than 200 samples a step say, and none is much worse."""
    random = np.random.default_rng(7)
    mission = loads(world(kind, 1))
    pillar = mission.obstacles["pillar"].frames[0][0]
    space = mission.workspace
    assert space is not None
    for _ in range(20):
        states, inputs = {}, {}
        for name, agent in mission.agents.items():
            u = random.uniform(-1.0, 1.0, (mission.horizon, 2))
            x = [agent.start]
            for row in u:
                x.append(agent.dynamics.A @ x[-1] + agent.dynamics.B @ row)
            states[name], inputs[name] = np.array(x), u
        plan = make_plan(mission, states, inputs)
        report, motion = verify(mission, plan), dense(kind, mission, plan)
        truth = {
            "clear": min(distance(place, pillar) for place in motion.values()),
            "apart": np.abs(motion["a"] - motion["b"]).max(axis=-1).min() - 0.6,
        }
        for one in report.requirements:
            if one.name in truth:
                assert one.swept is not None
                assert one.swept <= truth[one.name] + 1e-6
                assert one.swept >= truth[one.name] - 5e-3
                assert one.robustness is not None
                assert one.robustness <= truth[one.name] + 1e-6
        out = max((p @ space.normals.T - space.offsets).max() for p in motion.values())
        assert (out > 2e-6) <= any(v.kind == "workspace" for v in report.violations)


BOAT = """
step 2 s
horizon 2
dynamics boat {
  A = [[0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 0, -1.5], [0, 0, 1.5, 0]]
  B = [[0, 0], [0, 0], [1, 0], [0, 1]]
  continuous
  states px py vx vy; inputs ux uy
}
agent a : boat { start (5, 5, 0, 2); control |u| <= 0.1 }
obstacle w = box [3.4, 3.9] x [6.1, 6.6]
require safe: always a outside w swept
"""


def test_a_turning_boat_is_not_judged_by_its_chord() -> None:
    """Its chord clears w by 0.92 m; its true arc is 0.233 m inside at 1.05 s."""
    mission = loads(BOAT)
    with pytest.raises(InfeasibleError):
        solve(mission)
    agent = mission.agents["a"]
    x = [agent.start]
    for _ in range(2):
        x.append(agent.dynamics.A @ x[-1])
    report = verify(mission, make_plan(mission, {"a": np.array(x)}, {"a": np.zeros((2, 2))}))
    body = next(c for c in report.clearances if c.what == "body")
    assert body.value == pytest.approx(-0.2333, abs=1e-3)
    assert body.time == pytest.approx(1.05, abs=0.02)
    assert not report.ok


FAST = """
step 2 s
workspace box [0, 10] x [0, 10] {times}
agent r : double_integrator {{ start (1.2, 5, -2, 0); control |u| <= 2 }}
region goal = box [8, 9] x [4, 6]
require reach: eventually[0, 6] r in goal
minimize effort
"""


@pytest.mark.parametrize(("times", "kept"), [("", False), ("sampled", False), ("swept", True)])
def test_the_workspace_between_samples_is_kept_where_promised(times: str, kept: bool) -> None:
    mission = loads(FAST.format(times=times))
    outcome = solve(mission)
    out = -dense("double_integrator", mission, outcome.plan)["r"][..., 0].min()
    assert (out <= SLACK) == kept
    notes = "\n".join(outcome.plan.certificate.notes)
    assert ("leaves the workspace by" in notes) == (not kept)
    assert ("holds between samples too" in notes) == kept
    swept = loads(FAST.format(times="swept"))
    verdict = verify(swept, make_plan(swept, *(
        {"r": getattr(outcome.plan.runs["r"], part)} for part in ("states", "inputs")
    )))  # fmt: skip
    assert [v.kind for v in verdict.violations] == ([] if kept else ["workspace"])
