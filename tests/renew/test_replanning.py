"""Plans made anew against all runs of small systems, and against what cannot be kept."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.command import inside as stlc

from stlc import api
from stlc.errors import UsageError
from stlc.mission import Mission
from stlc.plan import Plan, make_plan, read_plan
from stlc.renew.past import along
from stlc.renew.replanning import Renewed, replan
from stlc.verify import verify

HEAD = """step 1 s
horizon 6
workspace box [0, 5] x [0, 4]
agent a : single_integrator { start (1, 1); control |u| <= 1; integer; effort_state (0.1, 0) }
region east = box [3, 5] x [0, 4]
region north = box [0, 5] x [3, 4]
obstacle bar = box [2, 2.5] x [0, 2] velocity (0, 0.5)
obstacle gate = moving { 0: box [3, 4] x [3, 4]; 4: box [0, 1] x [3, 4] }
"""

MOVES = [np.array(move, dtype=float) for move in itertools.product((-1, 0, 1), repeat=2)]

ASKED = [
    "require go: eventually[0, 6] a in east\nminimize effort",
    "require go: (eventually[1, 5] a in east) and eventually[0, 5] always[0, 1] a in north\n"
    "minimize effort[1, 5]",
    "require go: (a.y <= 2 m) until[2, 6] (a in east)\nminimize effort",
    "require out: always a outside bar\nrequire go: eventually a in east\nminimize effort",
    "require out: always a outside gate\nrequire go: eventually[0, 6] a in north\nminimize effort",
    "require go: eventually[0, 5] a in north\nminimize time(go) + 0.1 * effort",
    "require go: eventually[0, 6] a in east\n"
    "prefer early weight 3 late: eventually[0, 2] a in north\n"
    "prefer low weight 2 share: always a.y <= 2 m\nminimize effort",
    "require go: always[0, 4] eventually[0, 2] a.y <= 1 m\nrequire t: eventually a in north\n"
    "minimize effort",
    "require go: eventually[0, 6] a in east\nmaximize robustness - 0.01 * effort",
]


PUSHES = ((0.0, 0.0), (0.0, 1.0), (-1.0, 0.0))

TWO_WAYS = """step 1 s
horizon 6
workspace box [0, 9] x [0, 9]
agent a : single_integrator { start (4, 1); control |u| <= 1 }
region east = box [6, 9] x [0, 9]
region west = box [0, 2] x [0, 9]
require east: eventually[0, 6] a in east
require west: eventually[0, 6] a in west
minimize effort
"""


def _objective(mission: Mission, plan: Plan) -> float | None:
    """By the verifier; None where the run is none of the mission's."""
    report = verify(mission, plan)
    if not report.ok or report.objective is None:
        return None
    return report.objective[0] * (1.0 if report.sense.value == "minimize" else -1.0)


def _best(mission: Mission, states: np.ndarray, inputs: np.ndarray) -> float | None:
    """Least objective of the whole run over all continuations of a past."""
    left = mission.horizon - len(inputs)
    found = []
    for moves in itertools.product(MOVES, repeat=left):
        u = np.vstack([inputs, *[m[None, :] for m in moves]])
        x = np.vstack([states, states[-1] + np.cumsum(np.array(moves), axis=0)])
        if (x[len(states) :] < 0).any() or (x[len(states) :] > [5, 4]).any():
            continue
        plan = make_plan(mission, {"a": x}, {"a": u})
        value = _objective(mission, _executed(plan, len(inputs)))
        if value is not None:
            found.append(value)
    return min(found, default=None)


def _executed(plan: Plan, step: int) -> Plan:
    return replace(plan, executed=step)


@pytest.mark.parametrize(("asked", "now"), [*((a, 4) for a in ASKED), (ASKED[1], 3), (ASKED[4], 3)])
def test_the_best_of_all_continuations(asked: str, now: int) -> None:
    """Also where the agent is not where it was to be: a step off, carried out with other inputs."""
    mission = api.loads(HEAD + asked)
    plan = api.solve(mission).plan
    for push in PUSHES if now == 4 else PUSHES[1:2]:  # nine times the continuations
        run = plan.runs["a"]
        measured = np.clip(np.rint(run.states[now]) + push, 0, [5, 4])
        past = along(mission, plan, now, {"a": measured})
        best = _best(mission, past.states["a"], past.inputs["a"])
        found = replan(mission, past, old=plan)
        assert found.plan.executed == now
        assert found.plan.horizon == 6
        assert found.kept == (best is not None)
        if best is not None:
            assert _objective(mission, found.plan) == pytest.approx(best, abs=1e-4)


def _plan(text: str) -> tuple[Mission, Plan]:
    mission = api.loads(text)
    return mission, api.solve(mission).plan


CART = """step 1 s
horizon 8
workspace box [0, 10] x [0, 10]
agent a : double_integrator { start (2, 5); control |u| <= 1; speed <= 1.5; vx >= -1 }
obstacle wall = box [4, 5] x [0, 6]
require go: eventually[0, 8] a.y >= 6.5 m
require clear: always a outside wall
minimize effort
"""


def _renewed(measured: tuple[float, ...], now: int = 2, text: str = CART) -> Renewed:
    mission, plan = _plan(text)
    return replan(mission, along(mission, plan, now, {"a": np.array(measured)}), old=plan)


def test_bounds_that_the_measured_state_breaks_are_exceeded_as_little_as_can_be() -> None:
    found = _renewed((-0.2, 6.0, -0.4, 0.3))
    (left,) = found.softened
    assert left.text == "a: within the workspace"
    assert left.now == pytest.approx(0.2)
    # braking at 1 m/s^2 from -0.4 m/s: outside by 0.6 - 0.5 = 0.1 m at the next step at least
    states = found.plan.runs["a"].states[3:]
    out = np.maximum(-states[:, 0], 0.0)
    assert out.sum() == pytest.approx(0.1, abs=1e-4)
    assert left.until == 3
    assert not found.kept
    assert {v.kind for v in found.report.violations} == {"workspace"}
    assert all(r.satisfied for r in found.report.requirements)


def test_speeds_and_states_beyond_their_bounds() -> None:
    fast = _renewed((2.0, 3.5, 0.0, 3.1))
    assert [s.text for s in fast.softened] == ["a: norm of vx and vy <= 1.5"]
    assert fast.softened[0].now == pytest.approx(1.6)
    assert fast.softened[0].until == 3  # 2.1 m/s at the next step, then 1.1
    slow = _renewed((2.0, 5.5, -1.2, 0.0))
    assert [s.text for s in slow.softened] == ["a: vx >= -1"]
    assert slow.report.ok
    assert not slow.kept  # what was measured is beyond the bound all the same
    assert slow.softened[0].until is None
    assert "kept again" in str(slow.softened[0])


def test_what_is_lost_stays_lost_and_the_rest_is_kept() -> None:
    found = _renewed((4.1, 5.5, 0.0, 0.2))
    assert [x.name for x in found.lost] == ["clear"]
    assert found.lost[0].robustness == pytest.approx(-0.1)
    by = {r.name: r for r in found.report.requirements}
    assert by["go"].satisfied
    assert not by["clear"].satisfied
    states = found.plan.runs["a"].states[3:]
    inside = (states[:, 0] > 4 + 1e-6) & (states[:, 0] < 5 - 1e-6) & (states[:, 1] < 6 - 1e-6)
    assert not inside.any()


def test_a_deadline_that_is_out_of_reach_is_missed_by_as_little_as_can_be() -> None:
    mission, plan = _plan(CART)
    before = np.tile([2.0, 1.0, 0.0, 0.0], (6, 1)), np.zeros((6, 2))
    past = along(mission, plan, 6, {"a": before[0][0]}, {"a": before})
    found = replan(mission, past, old=plan)
    assert found.given_up == ("go",)
    assert not found.kept
    # 1/2 m at full thrust, then from 1 m/s to the speed that the polygon of 16 allows
    most = 1.0 + 0.5 + (1.0 + 1.5 * np.cos(np.pi / 16)) / 2
    assert found.plan.runs["a"].states[-1, 1] == pytest.approx(most, abs=1e-3)


def test_requirements_that_are_done_stay_done() -> None:
    text = CART.replace("eventually[0, 8] a.y >= 6.5 m", "eventually[0, 8] a.y >= 5.1 m")
    mission, plan = _plan(text.replace("start (2, 5)", "start (2, 5.2)"))
    found = api.replan(mission, plan, 2, {"a": np.array([2.0, 4.0, 0.0, 0.0])})
    assert found.done == ("go",)
    assert found.kept
    assert np.abs(found.plan.runs["a"].inputs[2:]).max() < 1e-6


def test_the_verifier_blames_no_plan_for_what_was_measured() -> None:
    mission, plan = _plan(CART)
    found = replan(mission, along(mission, plan, 2, {"a": np.array([2.2, 5.4, 0.1, 0.2])}))
    assert found.kept
    blamed = verify(mission, _executed(found.plan, 0))
    assert {v.kind for v in blamed.violations} == {"dynamics"}
    again = replan(mission, along(mission, found.plan, 5, {}), old=found.plan)
    assert again.kept
    assert again.plan.executed == 5
    assert again.plan.solve.objective == pytest.approx(found.plan.solve.objective, abs=1e-4)


def test_bad_pasts() -> None:
    mission, plan = _plan(CART)
    for step, states in ((8, {}), (2, {"b": np.zeros(4)}), (2, {"a": np.zeros(3)})):
        with pytest.raises(UsageError):
            along(mission, plan, step, states)
    with pytest.raises(UsageError):
        along(mission, plan, 2, {"a": np.full(4, np.nan)})


def test_the_command(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(CART)
    assert stlc("solve", "m.stl", "-o", "p.json", "--progress", "none", folder=tmp_path)
    (tmp_path / "now.json").write_text('{"step": 2, "states": {"a": {"px": 2.3, "vy": 0.1}}}')
    words = ("replan", "m.stl", "p.json", "--at", 2, "--state", "now.json")
    done = stlc(*words, "-o", "q.json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "steps before 2 were carried out" in done.stdout
    plan = read_plan(tmp_path / "q.json")
    assert plan.executed == 2
    assert plan.runs["a"].states[2, 0] == 2.3
    assert stlc("verify", "m.stl", "q.json", folder=tmp_path).returncode == 0
    (tmp_path / "now.json").write_text('{"states": {"a": [-0.2, 6.0, -0.4, 0.3]}}')
    soft = stlc(*words, "--json", folder=tmp_path)
    assert soft.returncode == 6
    assert json.loads(soft.stdout)["softened"][0]["until"] == 3


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[", "not JSON"),
        ("[]", "an object is needed"),
        ('{"states": 1}', "states: an object"),
        ('{"states": {"b": {}}}', "no agent 'b'"),
        ('{"states": {"a": {"pz": 1}}}', "no state 'pz'"),
        ('{"states": {"a": [1, 2]}}', "shape (2,)"),
        ('{"states": {"a": ["x", 2, 3, 4]}}', "numbers are needed"),
        ('{"states": {"a": [NaN, 2, 3, 4]}}', "finite numbers"),
        ('{"states": {}, "history": {"a": {}}}', "`states` and `inputs`"),
        ('{"states": {}, "step": 3}', "at step 3, not at 2"),
        ('{"states": {}, "more": 3}', "unknown entry 'more'"),
    ],
)
def test_measurements_that_are_none(tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "m.stl").write_text(CART)
    _mission, plan = _plan(CART)
    plan.write(tmp_path / "p.json")
    (tmp_path / "now.json").write_text(text)
    done = stlc("replan", "m.stl", "p.json", "--at", 2, "--state", "now.json", folder=tmp_path)
    assert done.returncode == 2
    assert told in done.stderr


def test_bounds_that_inertia_is_going_to_break_give_way_too() -> None:
    found = _renewed((2.0, 8.0, 0.0, 2.5))
    assert {s.text for s in found.softened} == {
        "a: norm of vx and vy <= 1.5",
        "a: within the workspace",
    }
    late = {s.text: s for s in found.softened}["a: within the workspace"]
    assert late.now == 0.0
    # 8 + 2.5 - 0.5 = 10 at 1.5 m/s, then 11 at 0.5, then back: 0.1 too far along both faces
    assert late.most == pytest.approx(1.0, abs=0.1)
    assert found.given_up == ()


def test_what_has_to_hold_at_all_times_is_given_up_last() -> None:
    """The deadline is missed; the wall is kept out of, though through it less would be missed."""
    text = CART.replace("a.y >= 6.5 m", "a.x >= 9.5 m").replace(
        "minimize effort", "maximize robustness - 0.01 * effort"
    )
    mission = api.loads(text.replace("[0, 6]\n", "[0, 9.5]\n").replace("vx >= -1", "vx >= -1.2"))
    plan = api.solve(api.loads(text.replace("9.5 m", "5.5 m"))).plan
    before = np.tile([2.0, 3.0, 0.0, 0.0], (4, 1)), np.zeros((4, 2))
    past = along(mission, plan, 4, {"a": before[0][0]}, {"a": before})
    found = replan(mission, past)
    assert found.given_up == ("go",)
    states = found.plan.runs["a"].states[4:]
    assert not ((states[:, 0] > 4 + 1e-6) & (states[:, 0] < 5 - 1e-6) & (states[:, 1] < 6)).any()
    by = {r.name: r for r in found.report.requirements}
    assert by["clear"].satisfied


def test_no_second_solver_is_asked_where_something_gives_way_anyhow(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where not everything can be kept the mission of wishes tells by itself what can."""
    asked = []
    monkeypatch.setattr("stlc.solve.confirm.confirm_infeasible", lambda *a, **k: asked.append(a))
    mission, plan = _plan(TWO_WAYS)
    found = replan(mission, along(mission, plan, 1, {"a": np.array([4.0, 1.0])}), old=plan)
    assert len(found.given_up) == 1
    assert asked == []
