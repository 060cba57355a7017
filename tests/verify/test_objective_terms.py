"""The objective term by term, and what a plan claims of it."""

from dataclasses import replace

import numpy as np
import pytest
from support.judged import GRID, STILL, T, judged
from support.missions import (
    box,
    inside,
)

from stlc.ir.nodes import (
    Eventually,
)
from stlc.mission import Channel, ObjectiveTerm, TermKind
from stlc.plan import SolveInfo
from stlc.sense import Sense


def test_objective_term_by_term():
    """a moves one metre in x from step 1 on; the table's entry is 100 cell(a) + cell(b)."""
    table = np.arange(10_000.0).reshape(100, 100)
    channel = Channel("radio", GRID, tables={None: table})
    push = np.array([[1.0, 0.0], [0.0, 0.0], [-1.0, 0.0], [0.0, 0.0]])
    objective = (
        ObjectiveTerm(TermKind.EFFORT, 0.5, ("a", "b")),
        ObjectiveTerm(TermKind.EFFORT, 1.0, ("a",), window=(2, 4)),
        ObjectiveTerm(TermKind.LINK_COST, 2.0, channel="radio", pairs=(("a", "b"),), window=(0, 2)),
        ObjectiveTerm(TermKind.ROBUSTNESS, -1.0, requirement="talk", scales={"m": 2.0}),
    )
    formula = Eventually(inside("a", box(2, 9, 0, 9)), 0, T)
    report = judged(formula, inputs=push, channels=[channel], objective=objective)
    a_cells = [30 + 2, 40 + 2]  # x = 3.0 is a border: cell 2 is cheaper; x = 4.0 likewise
    cheap = sum(100 * (c - 10) + 62 for c in a_cells)
    dear = sum(100 * c + 62 for c in a_cells)
    assert [(t.low, t.high) for t in report.terms] == [
        (2.0, 2.0),
        (1.0, 1.0),
        (cheap, dear),
        (1.25, 1.25),
    ]
    assert report.objective == (1.0 + 1.0 + 2 * cheap - 1.25, 1.0 + 1.0 + 2 * dear - 1.25)
    assert "best of tied cells" in report.text()
    assert f"+2 x link_cost(radio)[0, 2] = 2 x {cheap} = {2 * cheap}\n" in report.text()
    maximised = replace(report, sense=Sense.MAXIMIZE).text()
    assert f"+2 x link_cost(radio)[0, 2] = 2 x {dear} = {2 * dear}\n" in maximised


def test_normalised_divides_by_the_static_range():
    table = np.linspace(1.0, 5.0, 10_000).reshape(100, 100)
    channel = Channel("radio", GRID, tables={None: table})
    objective = (
        ObjectiveTerm(TermKind.EFFORT, 1.0, ("a",), normalised=True),
        ObjectiveTerm(
            TermKind.LINK_COST, 1.0, channel="radio", pairs=(("a", "b"),), normalised=True
        ),
    )
    report = judged(
        None, channels=[channel], objective=objective, inputs=STILL + np.array([0.25, 0.0])
    )
    raw = report.terms[1].low * 4.0 * T
    assert report.terms[0].low == pytest.approx(T * 0.25 / (T * 2.0))
    assert T * 1.0 < raw < T * 5.0


@pytest.mark.parametrize(
    ("objective", "bound", "found"),
    [
        (1.0, 1.0, []),
        (1.5, 1.0, []),
        (0.9, 0.9, ["objective"]),
        (1.2, 1.1, ["bound"]),
        (None, None, []),
    ],
)
def test_claims_are_checked(objective, bound, found):
    terms = (ObjectiveTerm(TermKind.EFFORT, 1.0, ("a",)),)
    push = STILL + np.array([0.25, 0.0])
    claim = SolveInfo(objective=objective, bound=bound)
    report = judged(None, inputs=push, objective=terms, solve=claim)
    assert [v.kind for v in report.violations] == found
