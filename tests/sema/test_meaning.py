"""Lowered formulas mean what was written: compared with direct arithmetic on random runs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stlc.api import loads
from stlc.ir.nodes import And, Const, Iff, Implies, Linear, Node, Not, Or, Role, Signal

HEAD = """
horizon 3
agent a : double_integrator { start (1, 1) }
agent b : double_integrator { start (9, 1) }
region ell = polygon (0, 0) (4, 0) (4, 1) (1, 1) (1, 4) (0, 4)
obstacle pillar = box [4, 6] x [4, 6]
require: """

Values = dict[Signal, float]
coordinate = st.floats(-10, 10, allow_nan=False).map(lambda v: round(v, 3))
states = st.lists(coordinate, min_size=16, max_size=16)


def formula(text: str) -> Node:
    return loads(HEAD + text + "\n").requirements[0].formula


def run(values: list[float]) -> Values:
    """States of both agents at two steps, from 16 numbers."""
    keys = [
        Signal(owner, Role.STATE, k, shift) for owner in "ab" for k in range(4) for shift in (0, 1)
    ]
    return dict(zip(keys, values, strict=True))


def rho(node: Node, values: Values) -> float:
    match node:
        case Linear():
            return node.constant + sum(c * values[s] for s, c in node.terms)
        case And():
            return min((rho(a, values) for a in node.args), default=math.inf)
        case Or():
            return max((rho(a, values) for a in node.args), default=-math.inf)
        case Not():
            return -rho(node.arg, values)
        case Implies():
            return max(-rho(node.left, values), rho(node.right, values))
        case Iff():
            left, right = rho(node.left, values), rho(node.right, values)
            return min(max(-left, right), max(-right, left))
        case Const():
            return math.inf if node.value else -math.inf
    raise AssertionError(node)


EXACT = {
    "a.x - 2 * b.y >= 3": lambda ax, ay, bx, by: ax - 2 * by - 3,
    "abs(a.x - b.x) + abs(a.y - b.y) <= 4": lambda ax, ay, bx, by: 4 - abs(ax - bx) - abs(ay - by),
    "abs(a.x - b.x) - |a.y| >= 1": lambda ax, ay, bx, by: abs(ax - bx) - abs(ay) - 1,
    "norm1(a.x, b.x) >= norminf(a.y, b.y)": lambda ax, ay, bx, by: (
        abs(ax) + abs(bx) - max(abs(ay), abs(by))
    ),
    "min(a.x, max(a.y, b.x)) >= 2": lambda ax, ay, bx, by: min(ax, max(ay, bx)) - 2,
    "max(a.x, 3) - min(b.x, a.y) <= 2": lambda ax, ay, bx, by: 2 - max(ax, 3) + min(bx, ay),
    "separation(a, b) >= 2": lambda ax, ay, bx, by: max(abs(ax - bx), abs(ay - by)) - 2,
    "separation(a, b) >= (1, 2)": lambda ax, ay, bx, by: max(abs(ax - bx) - 1, abs(ay - by) - 2),
    "separation(a, b) <= (1, 2)": lambda ax, ay, bx, by: min(1 - abs(ax - bx), 2 - abs(ay - by)),
    "a.x == b.x": lambda ax, ay, bx, by: -abs(ax - bx),
    "1 <= a.x < b.x": lambda ax, ay, bx, by: min(ax - 1, bx - ax),
    "a.x in [1, 3]": lambda ax, ay, bx, by: min(ax - 1, 3 - ax),
    "a outside pillar": lambda ax, ay, bx, by: max(4 - ax, ax - 6, 4 - ay, ay - 6),
    "not a in pillar": lambda ax, ay, bx, by: max(4 - ax, ax - 6, 4 - ay, ay - 6),
    "sum r in agents: r.x >= 2": lambda ax, ay, bx, by: ax + bx - 2,
    "forall r in agents: r.x >= 2": lambda ax, ay, bx, by: min(ax, bx) - 2,
    "exists r in [a, b]: r.x >= 2": lambda ax, ay, bx, by: max(ax, bx) - 2,
    "forall k in 1..3: a.x >= k": lambda ax, ay, bx, by: ax - 3,
    "a.x >= 1 iff b.x >= 1": lambda ax, ay, bx, by: min(max(1 - ax, bx - 1), max(1 - bx, ax - 1)),
}


@pytest.mark.parametrize("text", EXACT)
@given(values=states)
def test_robustness_is_exact(text: str, values: list[float]) -> None:
    node, state = formula(text), run(values)
    place = [state[Signal(o, Role.STATE, k)] for o in "ab" for k in (0, 1)]
    assert rho(node, state) == pytest.approx(EXACT[text](*place), abs=1e-9)


@given(values=states)
def test_distance_is_sound_on_both_sides_and_under_negation(values: list[float]) -> None:
    state = run(values)
    ax, ay, bx, by = (state[Signal(o, Role.STATE, k)] for o in "ab" for k in (0, 1))
    true = math.hypot(ax - bx, ay - by)
    gap = 1.0 - math.cos(math.pi / 16)
    for text, value in {
        "distance(a, b) >= 3": true - 3,
        "distance(a, b) <= 3": 3 - true,
        "not distance(a, b) >= 3": 3 - true,
        "not distance(a, b) <= 3": true - 3,
        "distance(a, b) <= 3 implies false": true - 3,
    }.items():
        found = rho(formula(text), state)
        assert found <= value + 1e-9
        assert found >= value - gap * true / math.cos(math.pi / 16) - 1e-9


@given(values=states)
def test_an_equivalence_of_distances_is_sound(values: list[float]) -> None:
    state = run(values)
    ax, ay, bx, by = (state[Signal(o, Role.STATE, k)] for o in "ab" for k in (0, 1))
    true = math.hypot(ax - bx, ay - by) - 3
    exact = min(max(-true, ax - 1), max(1 - ax, true))
    assert rho(formula("distance(a, b) >= 3 iff a.x >= 1"), state) <= exact + 1e-9


@given(values=states, share=st.floats(0, 1))
def test_swept_conditions_hold_between_the_steps(values: list[float], share: float) -> None:
    """Along p + v s + a s^2/2, which joins the samples of a double integrator."""
    state = run(values)
    place = []
    for owner in "ab":
        for axis in (0, 1):
            p, v = (
                state[Signal(owner, Role.STATE, axis)],
                state[Signal(owner, Role.STATE, axis + 2)],
            )
            after = state[Signal(owner, Role.STATE, axis, 1)]
            place.append(p + v * share + (after - p - v) * share**2)
    ax, ay, bx, by = place
    outside = max(4 - ax, ax - 6, 4 - ay, ay - 6)
    assert rho(formula("a outside pillar swept"), state) <= outside + 1e-9
    apart = max(abs(ax - bx), abs(ay - by)) - 1
    assert rho(formula("(separation(a, b) >= 1) swept"), state) <= apart + 1e-9
    distance = math.hypot(ax - bx, ay - by) - 1
    assert rho(formula("(distance(a, b) >= 1) swept"), state) <= distance + 1e-9


@given(values=states)
def test_a_region_in_pieces_is_their_union(values: list[float]) -> None:
    state = run(values)
    x, y = (state[Signal("a", Role.STATE, k)] for k in (0, 1))
    inside = 0 <= x <= 4 and 0 <= y <= 4 and (x <= 1 or y <= 1)
    assert (rho(formula("a in ell"), state) >= 0) == inside
    near = min(abs(v - w) for v, w in ((x, 0), (x, 1), (x, 4), (y, 0), (y, 1), (y, 4)))
    if near > 1e-9:
        assert (rho(formula("a outside ell"), state) >= 0) == (not inside)


def test_the_cut_of_a_region_is_inside() -> None:
    state = run([0.5, 0, 0.5, 0, 0, 0, 0, 0, *[0.0] * 8])
    for step in np.linspace(0.05, 0.95, 19):
        state[Signal("a", Role.STATE, 0)] = state[Signal("a", Role.STATE, 1)] = float(step)
        assert rho(formula("a outside ell"), state) < 0
