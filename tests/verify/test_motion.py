"""One break at a time: each is found, at its step, and nothing else is."""

from dataclasses import replace

import numpy as np
import pytest
from support.missions import agent, box, mission, roll

from stlc.errors import UsageError
from stlc.mission import NormBound, PolygonKind, TurnRate
from stlc.plan import RequirementValue, SolveInfo, make_plan
from stlc.verify import verify

T = 6
PUSH = [[0.5, 0.0], [0.5, 0.0], [0.0, 0.25], [-0.5, 0.0], [-0.5, 0.0], [0.0, -0.25]]


def judged(one, states, inputs, **extra):
    there = mission([one], horizon=T, **extra)
    plan = make_plan(there, {one.name: states}, {one.name: inputs})
    return verify(there, plan)


def kinds(report):
    return [(v.kind, v.step) for v in report.violations]


def test_an_exact_run_is_fine():
    one = agent("r1", (1, 1))
    report = judged(one, *roll(one, PUSH), workspace=box(0, 10, 0, 10))
    assert report.ok
    assert report.residual == 0.0


def test_dynamics_and_start():
    one = agent("r1", (1, 1))
    x, u = roll(one, PUSH)
    x[3, 1] += 2e-6
    report = judged(one, x, u)
    assert kinds(report) == [("dynamics", 3)]
    assert "py doesn't follow" in report.violations[0].message
    assert report.residual == pytest.approx(2e-6)
    moved = replace(one, start=np.array([1.0, 1.0, 1e-3, 0.0]))
    assert kinds(judged(moved, *roll(one, PUSH))) == [("start", 0)]


def test_bounds():
    one = agent("r1", (1, 1), u_max=0.4)
    assert kinds(judged(one, *roll(one, PUSH))) == [("input bound", 0), ("input bound", 3)]
    slow = replace(agent("r1", (1, 1)), state_upper=np.array([np.inf, np.inf, 0.9, np.inf]))
    report = judged(slow, *roll(slow, PUSH))
    assert kinds(report) == [("state bound", 2)]
    assert "vx = 1 is above its bound 0.9" in report.violations[0].message
    wide = replace(slow, state_upper=np.array([np.inf, np.inf, 1 - 9e-7, np.inf]))
    assert judged(wide, *roll(wide, PUSH)).ok


def test_integer_inputs():
    one = agent("r1", (1, 1), integer_inputs=True)
    assert kinds(judged(one, *roll(one, PUSH))) == [("integer input", 0)]
    assert judged(one, *roll(one, np.rint(PUSH))).ok


def test_a_norm_holds_at_the_start_too():
    bound = NormBound((2, 3), 2.0, 16, PolygonKind.INSCRIBED)
    fast = replace(agent("r1", (1, 1)), state_norms=(bound,), start=np.array([1.0, 1.0, 3.0, 0.0]))
    brake = [[-1.0, 0.0]] + [[0.0, 0.0]] * (T - 1)
    assert ("norm", 0) in kinds(judged(fast, *roll(fast, brake)))


def test_inscribed_norm_is_euclidean():
    bound = NormBound((2, 3), 1.0, 8, PolygonKind.INSCRIBED)
    one = agent("r1", (1, 1), state_norms=(bound,))
    report = judged(one, *roll(one, PUSH))
    assert kinds(report) == [("norm", 3)]
    assert report.violations[0].amount == pytest.approx(np.hypot(1, 0.25) - 1)


def test_outer_norm_is_its_polygon_and_says_how_far_it_goes():
    corner = np.array([np.sin(np.pi / 8), np.cos(np.pi / 8)]) / np.cos(np.pi / 8)
    inputs = np.vstack([corner, np.zeros((T - 1, 2))])
    for kind, fine in ((PolygonKind.OUTER, True), (PolygonKind.INSCRIBED, False)):
        one = agent("r1", (1, 1), 2.0, input_norms=(NormBound((0, 1), 1.0, 8, kind),))
        report = judged(one, *roll(one, inputs))
        assert report.ok is fine
        assert any("8.24 % above 1" in note for note in report.notes) is fine
    one = agent("r1", (1, 1), 2.0, input_norms=(NormBound((0, 1), 0.99, 8, PolygonKind.OUTER),))
    assert kinds(judged(one, *roll(one, inputs))) == [("norm", 0)]


def test_turn_rate():
    """|u| <= (u_max / v_max) |v| unless at rest; literally, a start at rest is stuck."""
    rate = TurnRate(1.0, 1.0)
    one = agent("r1", (1, 1), turn_rate=rate)
    gentle = [[0.5, 0], [0.5, 0], [0, 0.5], [0, 0], [0, 0], [-1.0, -0.5]]
    assert judged(one, *roll(one, gentle)).ok
    literal = replace(one, turn_rate=TurnRate(1.0, 1.0, literal=True))
    assert kinds(judged(literal, *roll(one, gentle))) == [("turn rate", 0)]
    sharp = [[0.5, 0], [0.5, 0.2], *[[0, 0]] * 4]
    report = judged(one, *roll(one, sharp))
    assert kinds(report) == [("turn rate", 1)]
    assert report.violations[0].amount == pytest.approx(np.hypot(0.5, 0.2) - 0.5)


def test_workspace():
    one = agent("r1", (1, 1))
    report = judged(one, *roll(one, PUSH), workspace=box(0, 3, 0, 10))
    assert kinds(report) == [("workspace", 5)]
    assert "outside the workspace" in report.violations[0].message


def test_a_plan_of_another_shape_is_refused():
    one = agent("r1", (1, 1))
    x, u = roll(one, PUSH)
    there = mission([one], horizon=T)
    plan = make_plan(there, {"r1": x}, {"r1": u})
    other = mission([agent("r2", (1, 1))], horizon=T)
    with pytest.raises(UsageError, match="agents r1; the mission has r2"):
        verify(other, plan)
    with pytest.raises(UsageError, match="the plan has 6 steps; the mission has 5"):
        verify(mission([one], horizon=5), plan)
    with pytest.raises(UsageError, match=r"step is 1 s; the mission's is 0.5 s"):
        verify(mission([one], horizon=T, step=0.5), plan)
    with pytest.raises(UsageError, match="not finite"):
        judged(one, x * np.nan, u)
    with pytest.raises(UsageError, match=r"inputs of shape \(5, 2\)"):
        judged(one, x, u[1:])


@pytest.mark.parametrize(
    ("field", "labels", "message"),
    [
        ("state_names", ("py", "px", "vx", "vy"), r"states of r1 are \(py, px, vx, vy\)"),
        ("input_names", ("ax", "ay"), r"inputs of r1 are \(ax, ay\); the mission's are \(ux, uy\)"),
        ("state_units", ("m", "m", "km/h", "km/h"), "units of states of r1"),
        ("input_units", ("", ""), r"units of inputs of r1 are \(-, -\)"),
    ],
)
def test_a_plan_with_other_labels_is_refused(field, labels, message):
    one = agent("r1", (1, 1))
    x, u = roll(one, PUSH)
    there = mission([one], horizon=T)
    plan = make_plan(there, {"r1": x}, {"r1": u})
    run = replace(plan.runs["r1"], **{field: labels})
    with pytest.raises(UsageError, match=message):
        verify(there, replace(plan, runs={"r1": run}))


@pytest.mark.parametrize(
    "change",
    [
        {"step": float("nan")},
        {"solve": SolveInfo(objective=float("nan"))},
        {"solve": SolveInfo(objective=float("inf"))},
        {"solve": SolveInfo(bound=float("nan"))},
        {"solve": SolveInfo(bound=float("inf"))},
        {"solve": SolveInfo(gap=float("nan"))},
        {"requirements": (RequirementValue("a", float("nan")),)},
        {"requirements": (RequirementValue("a", 0.0, float("nan")),)},
    ],
)
def test_a_plan_that_claims_no_numbers_is_refused(change):
    one = agent("r1", (1, 1))
    x, u = roll(one, PUSH)
    there = mission([one], horizon=T)
    plan = replace(make_plan(there, {"r1": x}, {"r1": u}), **change)
    with pytest.raises(UsageError, match=r"step is nan|not a number|not finite"):
        verify(there, plan)


def test_a_run_that_overflows_is_no_run():
    one = agent("r1", (1, 1))
    huge = np.full((T + 1, 4), 1.7e308)
    huge[0] = one.start
    with pytest.raises(UsageError, match="numbers for r1 beyond"):
        judged(one, huge, np.full((T, 2), -1.7e308))
