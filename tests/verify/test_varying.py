"""Dynamics whose matrices change from step to step, from the text to a plan that is renewed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stlc import api
from stlc.analysis.reach import reach
from stlc.errors import MissionError
from stlc.mission import Mission
from stlc.plan import make_plan
from stlc.renew.past import along
from stlc.renew.remaining import remaining
from stlc.renew.world import SimulatedWorld
from stlc.simulate import simulate
from stlc.verify import verify

TEXT = """step 1 s
horizon {horizon}
dynamics boat {{
  {laws}
  states px py vx vy; inputs ux uy
}}
agent b : boat {{ start (0, 0, 0, 0); control |u| <= 1 }}
region dock = box [4, 6] x [2, 3]
require go: eventually b in dock
minimize effort
"""


def _laws(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gliders whose drag, thrust and wind change."""
    eye, zero = np.eye(2), np.zeros((2, 2))
    A = np.array([np.block([[eye, eye], [zero, rng.uniform(0.6, 1.1) * eye]])
                  for _ in range(count)])  # fmt: skip
    A[:, 2, 3] = rng.uniform(-0.3, 0.3, count)
    B = np.array([np.vstack([zero, rng.uniform(0.5, 2.0) * eye]) for _ in range(count)])
    return A, B, np.column_stack([np.zeros((count, 2)), rng.uniform(-0.2, 0.2, (count, 2))])


def _written(A: np.ndarray, B: np.ndarray, c: np.ndarray) -> str:
    return f"A = {A.tolist()}; B = {B.tolist()}; c = {c.tolist()}"


def _mission(laws: str, horizon: int = 5) -> Mission:
    return api.loads(TEXT.format(laws=laws, horizon=horizon))


def _moved(laws: tuple[np.ndarray, ...], start: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    states = [start]
    for t, u in enumerate(inputs):
        A, B, c = (part[min(t, len(part) - 1)] for part in laws)
        states.append(A @ states[-1] + B @ u + c)
    return np.array(states)


@pytest.mark.parametrize("seed", range(3))
def test_plans_follow_each_step_s_own_law(seed: int) -> None:
    laws = _laws(np.random.default_rng(seed), 5)
    mission = _mission(_written(*laws))
    outcome = api.solve(mission)
    assert outcome.report.ok
    run = outcome.plan.runs["b"]
    truth = _moved(laws, np.zeros(4), run.inputs)
    np.testing.assert_allclose(run.states, truth, atol=1e-6)
    steady = _mission(_written(*(part[:1] for part in laws)))
    assert not mission.agents["b"].dynamics.flow
    assert {v.kind for v in verify(steady, outcome.plan).violations} == {"dynamics"}
    ranges = reach(mission)["b"]
    assert (run.states >= ranges.state_lower - 1e-6).all()
    assert (run.states <= ranges.state_upper + 1e-6).all()


def test_laws_that_are_all_alike_are_one() -> None:
    A, B, c = (np.repeat(part, 5, axis=0) for part in _laws(np.random.default_rng(7), 1))
    varying, steady = _mission(_written(A, B, c)), _mission(_written(A[:1], B[:1], c[:1]))
    assert varying.agents["b"].dynamics.varies
    assert not steady.agents["b"].dynamics.varies
    one, other = (reach(replace(m, requirements=()))["b"] for m in (varying, steady))
    np.testing.assert_allclose(one.state_lower, other.state_lower, atol=1e-6)
    np.testing.assert_allclose(one.state_upper, other.state_upper, atol=1e-6)
    costs = [api.solve(m).plan.solve.objective for m in (varying, steady)]
    assert costs[0] == pytest.approx(costs[1], rel=1e-4)


def test_reach_is_what_inputs_at_their_ends_make() -> None:
    rng = np.random.default_rng(3)
    laws = _laws(rng, 4)
    mission = replace(_mission(_written(*laws), 6), requirements=())
    ranges = reach(mission)["b"]
    most = np.full((7, 4), -np.inf)
    for _ in range(4000):
        most = np.maximum(most, _moved(laws, np.zeros(4), rng.choice([-1.0, 1.0], (6, 2))))
    assert (most <= ranges.state_upper + 1e-6).all()
    np.testing.assert_allclose(most[:, 1], ranges.state_upper[:, 1], atol=1e-5)


def test_one_matrix_serves_all_steps_and_the_last_law_goes_on() -> None:
    A, B, c = _laws(np.random.default_rng(4), 3)
    some = _mission(f"A = {A.tolist()}; B = {B[0].tolist()}; c = {c[0].tolist()}")
    model = some.agents["b"].dynamics
    for t in range(5):
        law = model.law(t)
        np.testing.assert_allclose(law.A, A[min(t, 2)])
        np.testing.assert_allclose(law.B, B[0])
        np.testing.assert_allclose(law.drift, c[0])


def test_laws_of_a_file_are_those_of_the_text(tmp_path: Path) -> None:
    laws = dict(zip("ABc", _laws(np.random.default_rng(5), 5), strict=True))
    np.savez(tmp_path / "laws.npz", **laws)
    path = tmp_path / "m.stl"
    path.write_text(TEXT.format(laws='laws "laws.npz"', horizon=5))
    read = api.load(path).agents["b"].dynamics
    told = _mission(_written(*laws.values())).agents["b"].dynamics
    for one, other in zip(read.over(5), told.over(5), strict=True):
        np.testing.assert_allclose(one, other)
    np.savez(tmp_path / "laws.npz", A=laws["A"], B=laws["B"][:4])
    with pytest.raises(MissionError, match="the arrays are A"):
        api.load(path)
    np.savez(tmp_path / "laws.npz", A=laws["A"])
    with pytest.raises(MissionError, match="no array 'B'"):
        api.load(path)


def test_continuous_laws_are_held_step_by_step() -> None:
    text = "A = [[[0, 1], [0, -1]], [[0, 1], [0, -2]]]; B = [[0], [1]]; continuous"
    mission = api.loads(
        f"step 0.5 s\nhorizon 3\ndynamics d {{ {text}; states p v; inputs u }}\n"
        "agent b : d { start (0, 1); control |u| <= 1 }\nrequire go: eventually b.p >= 0.2\n"
    )
    decays = [mission.agents["b"].dynamics.law(t).A[1, 1] for t in range(3)]
    assert decays == pytest.approx([np.exp(-0.5), np.exp(-1.0), np.exp(-1.0)])
    assert api.solve(mission).report.ok


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ("require c: always b in dock swept", "whose matrices change"),
        ("agent d : boat { start (0, 0, 0, 0); disturbance 0.1 }", "no feedback is known"),
    ],
)
def test_what_is_not_known_of_changing_laws_is_refused(more: str, told: str) -> None:
    laws = _written(*_laws(np.random.default_rng(6), 3))
    with pytest.raises(MissionError, match=told):
        api.loads(TEXT.format(laws=laws, horizon=5) + more + "\n")
    straight = TEXT.format(laws=laws + "; straight", horizon=5)
    api.loads(straight + "require c: eventually b in dock swept\n")


def test_a_renewed_plan_goes_on_by_the_laws_to_come() -> None:
    laws = _laws(np.random.default_rng(8), 6)
    mission = _mission(_written(*laws), 6)
    plan = api.solve(mission).plan
    now = plan.runs["b"].states[2] + np.array([0.05, -0.05, 0.0, 0.02])
    left = remaining(mission, along(mission, plan, 2, {"b": now})).mission
    for t in range(4):
        np.testing.assert_allclose(left.agents["b"].dynamics.law(t).A, laws[0][t + 2])
    again = api.replan(mission, plan, 2, {"b": now})
    assert again.report.ok
    ahead = again.plan.runs["b"]
    truth = _moved(tuple(part[2:] for part in laws), now, ahead.inputs[2:])
    np.testing.assert_allclose(ahead.states[2:], truth, atol=1e-6)


def test_worlds_and_simulations_go_by_each_step_s_law() -> None:
    laws = _laws(np.random.default_rng(9), 5)
    text = TEXT.format(laws=_written(*laws), horizon=5)
    mission = api.loads(text.replace("|u| <= 1 }", "|u| <= 1; control_noise 1e-9 }"))
    inputs = np.random.default_rng(1).uniform(-1, 1, (5, 2))
    truth = _moved(laws, np.zeros(4), inputs)
    world = SimulatedWorld(mission, np.random.default_rng(0))
    states = dict(world.begin().states)
    for t in range(5):
        states = dict(world.step(states, {"b": inputs[t]}).states)
        np.testing.assert_allclose(states["b"], truth[t + 1], atol=1e-6)
    plan = make_plan(mission, {"b": truth}, {"b": inputs})
    noisy = text.replace("|u| <= 1 }", "|u| <= 1; control_noise 0.1 }").replace(
        "eventually b in dock", f"always[5] b.px <= {truth[5, 0]}"
    )
    found = simulate(api.loads(noisy), plan, draws=4000, seed=2)
    gain, spread = np.eye(4), 0.0
    for t in reversed(range(5)):
        spread += float(((gain @ laws[1][t])[0] ** 2).sum()) * 0.01
        gain = gain @ laws[0][t]
    (estimate,) = found.requirements
    assert estimate.robustness.std() == pytest.approx(np.sqrt(spread), rel=0.05)
