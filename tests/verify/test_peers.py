"""The evaluator against other people's monitors, where the semantics agree.

rtamt leaves the witness step out of until and cuts windows at the end of the run, so it is asked
about formulas without until, at the steps whose whole horizon lies within the run; its iff is
-|a - b|, so ours is written as two implications. mstlo reads until as the paper does. Neither
has release, which is written as its dual for mstlo.
"""

import numpy as np
import pytest
from hypothesis import given
from support.formulas import LENGTH, formulas, horizon, make_trace, traces

from stlc.ir.nodes import (
    Always,
    And,
    Eventually,
    Iff,
    Implies,
    Linear,
    Node,
    Not,
    Or,
    Release,
    Until,
)
from stlc.verify.robustness import robustness


def _atom(node: Linear) -> str:
    ((signal, coefficient),) = node.terms
    if coefficient > 0:
        return f"({signal.owner} >= {-node.constant})"
    return f"({signal.owner} <= {node.constant})"


def to_rtamt(node: Node) -> str:
    parts = [to_rtamt(child) for child in node.children]
    match node:
        case Linear():
            return _atom(node)
        case Not():
            return f"(not {parts[0]})"
        case And():
            return f"({' and '.join(parts)})"
        case Or():
            return f"({' or '.join(parts)})"
        case Implies():
            return f"({parts[0]} implies {parts[1]})"
        case Iff():
            return f"(({parts[0]} implies {parts[1]}) and ({parts[1]} implies {parts[0]}))"
        case Always(start=a, end=b):
            return f"(always[{a},{b}] {parts[0]})"
        case Eventually(start=a, end=b):
            return f"(eventually[{a},{b}] {parts[0]})"
    raise AssertionError(node)


def to_mstlo(node: Node) -> str:
    parts = [to_mstlo(child) for child in node.children]
    match node:
        case Linear():
            return _atom(node)
        case Not():
            return f"!({parts[0]})"
        case And():
            return "(" + " && ".join(parts) + ")"
        case Or():
            return "(" + " || ".join(parts) + ")"
        case Implies():
            return f"({parts[0]} -> {parts[1]})"
        case Always(start=a, end=b):
            return f"(G[{a},{b}] ({parts[0]}))"
        case Eventually(start=a, end=b):
            return f"(F[{a},{b}] ({parts[0]}))"
        case Until(start=a, end=b):
            return f"(({parts[0]}) U[{a},{b}] ({parts[1]}))"
        case Release(start=a, end=b):
            return f"!((!({parts[0]})) U[{a},{b}] (!({parts[1]})))"
    raise AssertionError(node)


@given(formulas(until=False), traces)
def test_rtamt_agrees_without_until(formula, values):
    rtamt = pytest.importorskip("rtamt", reason="rtamt needs Python < 3.13")
    ours = robustness(formula, make_trace(values))
    assert len(ours) == max(LENGTH - horizon(formula), 0)
    spec = rtamt.StlDiscreteTimeSpecification()
    for name in values:
        spec.declare_var(name, "float")
    spec.spec = to_rtamt(formula)
    spec.parse()
    run = {"time": list(range(LENGTH)), **{n: v.tolist() for n, v in values.items()}}
    theirs = [value for _, value in spec.evaluate(run)]
    np.testing.assert_allclose(ours, theirs[: len(ours)], atol=1e-12)


@given(formulas(until=True, iff=False), traces)
def test_mstlo_agrees_with_until(formula, values):
    mstlo = pytest.importorskip("mstlo_python", reason="mstlo has no wheel for this platform")
    ours = robustness(formula, make_trace(values))
    monitor = mstlo.Monitor(mstlo.parse_formula(to_mstlo(formula)), semantics="DelayedQuantitative")
    rows = [(name, float(v), float(t)) for name in values for t, v in enumerate(values[name])]
    verdicts = dict(monitor.update_batch(rows).verdicts())
    theirs = [verdicts[float(t)] for t in range(len(ours)) if float(t) in verdicts]
    assert len(theirs) == len(ours)
    np.testing.assert_allclose(ours[: len(theirs)], theirs, atol=1e-12)
