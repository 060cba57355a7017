"""What moves between samples: flows of matrices, their Bezier points, the workspace in time."""

from __future__ import annotations

from math import comb

import numpy as np
import pytest
from scipy.linalg import expm

from stlc.api import loads, solve, verify
from stlc.bezier import curve
from stlc.dynamics import Dynamics, Flow
from stlc.errors import InfeasibleError, MissionError
from stlc.ir.nodes import Motion, walk
from stlc.plan import make_plan
from stlc.sema.discretise import zero_order_hold
from stlc.sema.flow import held_flow

TURN = np.array([[0.0, -1.0], [1.0, 0.0]])
EYE, ZERO = np.eye(2), np.zeros((2, 2))


def flow(lower: np.ndarray, drift: float = 0.0) -> Flow:
    """p' = v, v' = lower v + u + drift."""
    a = np.block([[ZERO, EYE], [ZERO, lower]])
    return Flow(a, np.vstack([ZERO, EYE]), np.array([0.0, 0.0, drift, 0.0]))


FLOWS = {
    "double integrator": flow(ZERO),
    "drag and wind": flow(-0.4 * EYE, 0.7),
    "turning": flow(1.5 * TURN),
    "stiff": flow(-9.0 * EYE),
    "single integrator": Flow(ZERO, EYE, np.zeros(2)),
}


def dynamics(one: Flow, dt: float) -> Dynamics:
    n, m = one.B.shape
    names = tuple(f"x{k}" for k in range(n)), tuple(f"u{k}" for k in range(m))
    held = zero_order_hold(one.A, one.B, one.drift, dt)
    return Dynamics("d", *held, *names, ("",) * n, ("",) * m, flow=one)


@pytest.mark.parametrize("dt", [0.1, 1.0, 2.0])
@pytest.mark.parametrize("kind", FLOWS)
def test_bezier_points_make_the_motion(kind: str, dt: float) -> None:
    one = FLOWS[kind]
    n, m = one.B.shape
    found = curve(dynamics(one, dt), dt)
    assert found is not None
    degree = found.degree([0, 1])
    assert degree is not None
    points = found.points(degree)
    whole = np.zeros((n + m + 1, n + m + 1))
    whole[:n] = np.column_stack([one.A, one.B, one.drift])
    for part in range(found.parts):
        for s in np.linspace(0.0, 1.0, 11):
            weights = [comb(degree, j) * s**j * (1 - s) ** (degree - j) for j in range(degree + 1)]
            made = np.tensordot(weights, points[part], 1)[:2]
            true = expm(whole * dt * (part + s) / found.parts)[:2]
            assert np.abs(made - true).max() <= 2e-8 * max(1.0, dt**2)


def test_integrators_have_the_points_of_their_lines_and_parabolas() -> None:
    double, single = (
        curve(dynamics(FLOWS[k], 0.5), 0.5) for k in ("double integrator", "single integrator")
    )
    assert double is not None
    assert single is not None
    assert (double.parts, double.degree([0, 1]), double.degree([2, 3])) == (1, 2, 1)
    assert (single.parts, single.degree()) == (1, 1)
    middle = double.points(2)[0, 1, 0]
    assert middle.tolist() == [1.0, 0.0, 0.25, 0.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("kind", FLOWS)
def test_discrete_matrices_give_their_flow_back(kind: str) -> None:
    one = FLOWS[kind]
    held = Flow(*zero_order_hold(one.A, one.B, one.drift, 0.5))
    found = held_flow(held, 0.5)
    assert found is not None
    for there, here in ((found.A, one.A), (found.B, one.B), (found.drift, one.drift)):
        assert np.allclose(there, here, atol=1e-9)


@pytest.mark.parametrize("matrix", [[[0.0, 1.0], [1.0, 0.0]], [[1.0, 0.0], [0.0, 0.0]]])
def test_a_negative_or_zero_eigenvalue_has_no_flow(matrix: list[list[float]]) -> None:
    assert held_flow(Flow(np.array(matrix), EYE, np.zeros(2)), 1.0) is None


HOP = """
horizon 3
workspace box [0, 9] x [0, 9] {times}
dynamics hop {{ A = [[0, 1], [1, 0]]; B = [[1, 0], [0, 1]]; states px py; {word} }}
agent h : hop {{ start (1, 2); control |u| <= 1 }}
obstacle wall = box [4, 5] x [0, 9]
require clear: always h outside wall {swept}
"""


@pytest.mark.parametrize(("times", "swept"), [("", "swept"), ("swept", ""), ("sampled", "swept")])
def test_unknown_motion_is_refused_unless_it_is_said_to_be_straight(times: str, swept: str) -> None:
    with pytest.raises(MissionError) as caught:
        loads(HOP.format(times=times, word="", swept=swept))
    assert {d.code for d in caught.value.diagnostics} == {"E0412"}
    mission = loads(HOP.format(times=times, word="straight", swept=swept))
    outcome = solve(mission)
    assert any("straight lines, as the mission says" in note for note in outcome.report.notes)


def test_sampled_conditions_ask_nothing_of_the_motion() -> None:
    assert not loads(HOP.format(times="", word="", swept="")).workspace_swept


WORLD = """
horizon 3
workspace box [0, 9] x [0, 9] {times}
agent r : double_integrator {{ start (1, 1); control |u| <= 1; speed <= 1 }}
let calm = (r.vx <= 1 m/s) swept
require a: always {formula}
"""


@pytest.mark.parametrize(
    ("times", "formula", "kept"),
    [
        ("", "r.x <= 8 m", False),
        ("", "(r.x <= 8 m) swept", True),
        ("", "calm", True),
        ("swept", "r.x <= 8 m", True),
        ("sampled", "calm", False),
    ],
)
def test_the_workspace_follows_what_is_swept(times: str, formula: str, kept: bool) -> None:
    assert loads(WORLD.format(times=times, formula=formula)).workspace_swept == kept


def test_every_swept_condition_says_what_it_stands_for() -> None:
    mission = loads(WORLD.format(times="", formula="(r.x + r.y <= 3 m) swept"))
    claims = [n.swept for r in mission.requirements for n in walk(r.formula) if n.swept]
    assert [claim.motion for claim in claims] == [Motion.CONDITION]
    assert claims[0].condition is not None


GATE = """step 1 s
horizon 8
workspace box [0, 6] x [0, 6]
agent r : single_integrator {{ start (3, 1); control |u| <= 2 }}
obstacle one = box [-1, 3] x [2, 3]
obstacle two = box [3, 7] x [2, 3]
obstacle ferry = moving {{ 0: box [0, 1] x [4, 5]; 3: box [2, 3] x [4, 5] }}
region low = box [0, 6] x [0, 1.5]
region high = box [0, 6] x [4, 6]
let clear(a) = a outside one and a outside two
require a: {formula}
require b: eventually r in high
"""


@pytest.mark.parametrize(
    ("formula", "spelt"),
    [
        ("always (r outside one and r outside two) swept",
         "always (r outside one swept and r outside two swept)"),
        ("always (clear(r)) swept", "always (r outside one swept and r outside two swept)"),
        ("always (forall o in [one, two]: r outside o) swept",
         "always (r outside one swept and r outside two swept)"),
        ("always[0, 7] (r outside ferry) swept", "always[0, 7] r outside ferry swept"),
        ("always[0, 7] (r.x <= 5 and (r in low and r outside ferry)) swept",
         "always[0, 7] ((r.x <= 5) swept and (r in low swept and r outside ferry swept))"),
    ],
)  # fmt: skip
def test_a_conjunction_holds_between_samples_where_its_parts_do(formula: str, spelt: str) -> None:
    """As one condition the pieces at a step stood for a place that moves, or touches others."""
    found, wanted = (
        loads(GATE.format(formula=f)).requirements[0].formula for f in (formula, spelt)
    )
    assert found == wanted
    claims = [{n.swept for n in walk(f) if n.swept is not None} for f in (found, wanted)]
    assert claims[0] == claims[1]


def test_no_way_between_obstacles_that_touch_under_one_swept() -> None:
    with pytest.raises(InfeasibleError):
        solve(loads(GATE.format(formula="always (r outside one and r outside two) swept")))


@pytest.mark.parametrize(
    "formula", ["(r outside ferry or r.x >= 3) swept", "(clear(r) or r.x >= 3) swept"]
)
def test_alternatives_of_what_moves_or_touches_are_refused(formula: str) -> None:
    with pytest.raises(MissionError) as caught:
        loads(GATE.format(formula=formula))
    assert [d.code for d in caught.value.diagnostics] == ["E0412"]


LOGIC = """
horizon 4
workspace box [0, 10] x [0, 10]
agent a : single_integrator {{ start (1, 1); control |u| <= 3 }}
region g = box [4, 6] x [0, 5]
require d: always {condition} swept
"""

DETOUR = np.array([[1, 1], [4, 4], [6, 5.5], [9, 4], [9, 1]], dtype=float)


@pytest.mark.parametrize(
    ("condition", "value"),
    [
        ("(a.x >= 5 implies a.y >= 3)", -2.0),
        ("(a.x >= 5 implies not (a.y <= 0.5))", 0.5),
        ("(not a.x >= 5 or a.y >= 3)", -2.0),
        ("(a.y >= 1 iff a.x >= 1)", 0.0),
        ("(not (a.x >= 8 iff a.y >= 20))", -7.0),
        ("(not (a in g) or a.y >= 4.5)", -2.0 / 7.0),
        ("(not (a in g and a.x <= 3))", 0.5),
    ],
)
def test_brackets_may_hold_any_logic(condition: str, value: float) -> None:
    mission = loads(LOGIC.format(condition=condition))
    plan = make_plan(mission, {"a": DETOUR}, {"a": np.diff(DETOUR, axis=0)})
    found = verify(mission, plan).requirements[0]
    assert found.robustness is not None
    assert found.swept == pytest.approx(value)
    assert found.robustness <= value + 1e-9


@pytest.mark.parametrize("part", ["next a.x >= 2", "eventually[0, 1] a.x >= 2",
                                  "a.x >= 2 until[0, 1] a.y >= 2"])  # fmt: skip
def test_brackets_speak_of_one_step(part: str) -> None:
    with pytest.raises(MissionError) as caught:
        loads(LOGIC.format(condition=f"(a.y >= 1 or ({part}))"))
    (found,) = caught.value.diagnostics
    assert (found.code, found.hint) == ("E0412", "put it inside: `always (..) swept`")  # type: ignore[attr-defined]
