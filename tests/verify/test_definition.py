"""The evaluator against the definitions, on random formulas and runs."""

import numpy as np
import pytest
from hypothesis import given
from support.formulas import Naive, at_least, at_most, formulas, make_trace, signal, traces

from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Iff,
    Implies,
    Linear,
    Link,
    Not,
    Or,
    Quantity,
    Relation,
    Timed,
    Until,
)
from stlc.verify.robustness import Evaluator, robustness, satisfaction
from stlc.verify.trace import Trace
from stlc.verify.windows import until, window_min


@given(formulas(until=True, unbounded=True, timed=True), traces)
def test_equals_the_definitions(formula, values):
    got = robustness(formula, make_trace(values))
    np.testing.assert_array_equal(got, np.array(Naive(values).run(formula), dtype=float))


@given(formulas(until=True), traces)
def test_negation_turns_the_sign(formula, values):
    trace = make_trace(values)
    np.testing.assert_array_equal(robustness(Not(formula), trace), -robustness(formula, trace))


@given(formulas(until=True), formulas(until=True), traces)
def test_until_is_its_expansion(left, right, values):
    """f U[0,2] g is the disjunction over the witness step."""
    trace = make_trace(values)
    steps = [
        And((*(Always(left, k, k) for k in range(s + 1)), Always(right, s, s))) for s in range(3)
    ]
    expected = robustness(Or(tuple(steps)), trace)
    np.testing.assert_array_equal(robustness(Until(left, right, 0, 2), trace), expected)


def test_shift_shortens_the_run():
    rise = Linear(((signal("x", 1), 1.0), (signal("x"), -1.0)), 0.0)
    trace = make_trace({"x": np.array([0.0, 1.0, 3.0])})
    assert robustness(rise, trace).tolist() == [1.0, 2.0]


def test_window_past_the_end_cannot_be_judged():
    trace = make_trace({"x": np.arange(4.0)})
    assert robustness(Always(at_least("x", 0), 0, 3), trace).tolist() == [0.0]
    assert len(robustness(Always(at_least("x", 0), 0, 4), trace)) == 0


def test_unbounded_ranges_over_what_can_be_judged():
    """`always eventually[0,2] x >= 2` looks at steps 0..T-2 only."""
    trace = make_trace({"x": np.array([0.0, 0.0, 2.0, 0.0, 5.0])})
    formula = Always(Eventually(at_least("x", 2), 0, 2), 0, None)
    assert robustness(formula, trace).tolist() == [0.0, 0.0, 3.0]


def test_timed_follows_the_clock():
    trace = make_trace({"x": np.array([1.0, 2.0, 3.0, 4.0])})
    formula = Timed((at_least("x", 0), at_most("x", 0)))
    assert robustness(formula, trace).tolist() == [1.0, -2.0, -3.0, -4.0]


def test_empty_conjunction_and_disjunction():
    trace = make_trace({"x": np.zeros(2)})
    assert robustness(And(()), trace).tolist() == [np.inf, np.inf]
    assert robustness(Or(()), trace).tolist() == [-np.inf, -np.inf]


def test_satisfaction_has_margin_and_tolerance():
    trace = make_trace({"x": np.array([1.0, 1.0 - 9e-7, 1.0 - 2e-6])})
    assert satisfaction(at_least("x", 0), trace, 1.0).tolist() == [True, True, False]


def test_link_is_shifted_and_needs_a_radio():
    link = Link("radio", Quantity.RSSI, "a", "b", Relation.AT_LEAST, -70.0, shift=1)
    trace = Trace(3, {}, lambda node, positive: np.array([1.0, 2.0, 3.0]))
    assert robustness(link, trace).tolist() == [2.0, 3.0]
    with pytest.raises(ValueError, match="no radio"):
        robustness(link, Trace(3))


def test_intervals_are_judged_by_the_end_that_counts():
    link = Link("radio", Quantity.RSSI, "a", "b", Relation.AT_LEAST, -70.0)
    low, high = np.array([-1.0, 2.0]), np.array([1.0, 3.0])
    trace = Trace(2, {}, lambda node, positive: low if positive else high)
    assert robustness(link, trace).tolist() == [-1.0, 2.0]
    assert robustness(Not(link), trace).tolist() == [-1.0, -3.0]
    assert robustness(Not(Not(link)), trace).tolist() == [-1.0, 2.0]
    assert robustness(Implies(link, Const(False)), trace).tolist() == [-1.0, -3.0]
    assert robustness(Iff(link, Const(True)), trace).tolist() == [-1.0, 2.0]
    assert robustness(Iff(link, Const(False)), trace).tolist() == [-1.0, -3.0]


def test_depth_and_sharing():
    """50,000 levels and 2^60 paths are no trouble."""
    deep = at_least("x", 0)
    twin = at_least("x", 0)
    for _ in range(50_000):
        deep, twin = Not(deep), Not(twin)
    wide = at_least("x", 0)
    for _ in range(60):
        wide = And((wide, Or((wide, Const(False)))))
    evaluator = Evaluator(make_trace({"x": np.arange(3.0)}))
    for formula in (deep, twin, wide):
        assert evaluator.robustness(formula).tolist() == [0.0, 1.0, 2.0]


def test_long_windows_are_cheap():
    values = np.sin(np.arange(200_000.0))
    low = window_min(values, 10, 100_000)
    assert low[0] == values[10:100_001].min()
    assert low[-1] == values[len(low) + 9 :].min()
    assert len(until(values, values, 10, 100_000)) == len(low)


@given(formulas(until=True, unbounded=True, timed=True), traces, traces)
def test_many_runs_at_once_are_judged_as_each_alone(formula, one, other):
    alone = [robustness(formula, make_trace(values)) for values in (one, other)]
    signals = {
        key: np.stack([make_trace(values).signals[key] for values in (one, other)], axis=2)
        for key in make_trace(one).signals
    }
    length = len(next(iter(one.values())))
    both = robustness(formula, Trace(length, signals, many=True))
    np.testing.assert_array_equal(np.broadcast_to(both, (len(both), 2)), np.stack(alone, axis=1))
