"""Formulas whose value is known before the run mean what the definition says, to the bit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.formulas import make_trace

from stlc.api import loads
from stlc.mission import Mission, Requirement
from stlc.passes import PIPELINE
from stlc.passes.base import Program
from stlc.verify.robustness import robustness

HEAD = "horizon 4\nsignal a [m]\nsignal b [m]\nparam p = 1.5 m\nlet c = p + 0.5 m\n"
A, B, P, C = 5.0, 3.0, 1.5, 2.0
TRACE = make_trace({"a": np.full(5, A), "b": np.full(5, B)})

Value = tuple[str, float]  # text, and what it is worth on TRACE
numbers: st.SearchStrategy[Value] = st.one_of(
    st.integers(-8, 8).map(lambda k: (f"{k / 4} m" if k >= 0 else f"(-{-k / 4} m)", k / 4)),
    st.sampled_from([("a", A), ("b", B), ("p", P), ("c", C)]),
)


def _deeper(inner: st.SearchStrategy[Value]) -> st.SearchStrategy[Value]:
    two = st.tuples(inner, inner)
    return st.one_of(
        two.map(lambda v: (f"max({v[0][0]}, {v[1][0]})", max(v[0][1], v[1][1]))),
        two.map(lambda v: (f"min({v[0][0]}, {v[1][0]})", min(v[0][1], v[1][1]))),
        two.map(lambda v: (f"({v[0][0]} + {v[1][0]})", v[0][1] + v[1][1])),
        two.map(lambda v: (f"({v[0][0]} - {v[1][0]})", v[0][1] - v[1][1])),
        inner.map(lambda v: (f"abs({v[0]})", abs(v[1]))),
        inner.map(lambda v: (f"2 * {v[0]}", 2 * v[1])),
    )


def _compared(pair: tuple[Value, Value], sign: str) -> Value:
    (left, x), (right, y) = pair
    rho = {">=": x - y, ">": x - y, "<=": y - x, "<": y - x, "==": -abs(x - y)}[sign]
    return f"({left} {sign} {right})", rho


values = st.recursive(numbers, _deeper, max_leaves=4)
comparisons = st.builds(
    _compared, st.tuples(values, values), st.sampled_from([">=", ">", "<=", "<", "=="])
)
atoms = st.one_of(comparisons, st.sampled_from([("true", math.inf), ("false", -math.inf)]))


def _joined(inner: st.SearchStrategy[Value]) -> st.SearchStrategy[Value]:
    two = st.tuples(inner, inner)
    return st.one_of(
        inner.map(lambda f: (f"(not {f[0]})", -f[1])),
        inner.map(lambda f: (f"(always[0, 1] {f[0]})", f[1])),
        inner.map(lambda f: (f"(eventually[0, 1] {f[0]})", f[1])),
        two.map(lambda f: (f"({f[0][0]} and {f[1][0]})", min(f[0][1], f[1][1]))),
        two.map(lambda f: (f"({f[0][0]} or {f[1][0]})", max(f[0][1], f[1][1]))),
        two.map(lambda f: (f"({f[0][0]} implies {f[1][0]})", max(-f[0][1], f[1][1]))),
        two.map(lambda f: (f"({f[0][0]} until[0, 1] {f[1][0]})", min(f[0][1], f[1][1]))),
    )


formulas = st.recursive(atoms, _joined, max_leaves=4)


def parsed(text: str) -> Mission:
    """The mission of one formula; at a margin of -inf nothing is ever refused."""
    return loads(f"{HEAD}require r: {text} or true\n")


def formula_of(text: str):
    return parsed(text).requirements[0].formula.args[0]


@given(formulas)
def test_the_robustness_of_numbers_is_their_difference(case):
    text, expected = case
    assert robustness(formula_of(text), TRACE)[0] == expected


@given(formulas)
def test_passes_that_keep_robustness_keep_that_of_numbers(case):
    text, expected = case
    mission = parsed(text)
    program = Program((Requirement("r", formula_of(text)),), mission)
    for step in PIPELINE:
        if step.preserves != "robustness":
            continue
        program = step.run(program)
        assert robustness(program.formulas[0], TRACE)[0] == expected, step.name


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("max(a, b) <= a", 0.0),
        ("a >= a", 0.0),
        ("not (a >= a)", 0.0),
        ("5 m >= 3 m", 2.0),
        ("2 != 2", -1.0),
        ("2 != 5", 2.0),
        ("2 == 5", -3.0),
        ("1.5 != 2", 0.5),
        ("(1, 2) in square", 1.0),
        ("distance((0, 0), (3, 4)) >= 4", 1.0),
        ("separation((0, 0), (3, 4)) >= (2, 5)", 1.0),
        ("|a - a| <= 1 m", 1.0),
        ("a - a in [-1, 3]", 1.0),
    ],
)
def test_examples(text, expected):
    head = HEAD + "region square = box [0, 4] x [0, 4]\n"
    mission = loads(f"{head}require r: ({text}) or true\n")
    assert robustness(mission.requirements[0].formula.args[0], TRACE)[0] == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("forall k in 1..3: (k == 2 implies a >= 4 m)", 1.0),
        ("forall k in 1..3: (k >= 2 implies a >= 2 * k * 1 m)", -1.0),
        ("forall i in 1..3: forall j in 1..3: (i < j implies a >= (j - i) * 1 m)", 3.0),
        ("exists k in [1, 2]: (floor(k / 2) != 0 and a >= k * 1 m)", 3.0),
        ("exists (i, j) in [(1, 1), (1, 2)]: (i != j and b >= 1 m)", 2.0),
        ("forall k in 1..3: (abs(k - 2) > 0 implies a >= k * 1 m)", 2.0),
    ],
)
def test_a_comparison_of_indices_picks_instances(text, expected):
    """It has no robustness of its own: at `k == 2` it must not hold of `k == 2` by 0 alone."""
    assert robustness(formula_of(f"({text})"), TRACE)[0] == expected
