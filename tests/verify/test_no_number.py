"""Values that are no numbers: no preference is kept and no objective is reached by them."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stlc.ir.nodes import Always, Linear, Role, Signal
from stlc.ir.requirement import Requirement
from stlc.mission import ObjectiveTerm, TermKind
from stlc.plan import SolveInfo
from stlc.preferences import Measure, Preference
from stlc.sense import Sense
from stlc.verify import objective, preferences
from stlc.verify.objective import objective_violations, total
from stlc.verify.preferences import violation
from stlc.verify.report import TermReport
from stlc.verify.trace import Trace

X, Y = (Linear(((Signal("r", Role.STATE, k), 1.0),), 0.0) for k in (0, 1))
LOST = Trace(2, {("r", Role.STATE): np.array([[3.0, 2.0], [math.nan, 2.0]])})
"""x is lost after the start, y is not."""


@pytest.mark.parametrize("measure", list(Measure))
@pytest.mark.parametrize(("formula", "known"), [(Always(X, 0, 1), False), (Always(Y, 0, 1), True)])
def test_a_preference_whose_value_is_lost_is_not_kept(
    measure: Measure, formula: Always, known: bool
) -> None:
    found = violation(Preference("p", formula, measure=measure, parts=(Y, formula)), LOST)
    assert found == ((0.0, 0.0) if known else pytest.approx((math.nan, math.nan), nan_ok=True))


@pytest.mark.parametrize("ends", [(math.nan, 1.0), (1.0, math.nan)])
def test_a_violation_lost_in_one_way_of_reading_lengths_is_lost(
    ends: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    read = iter(ends)
    monkeypatch.setattr(preferences, "_violation", lambda *_: next(read))
    assert all(map(math.isnan, violation(Preference("p", X), LOST)))


@pytest.mark.parametrize("order", [1, -1])
def test_the_least_robustness_is_lost_with_any_of_them(order: int) -> None:
    needs = [Requirement("x", Always(X, 0, 1)), Requirement("y", Always(Y, 0, 1))][::order]
    subject: Any = SimpleNamespace(mission=SimpleNamespace(requirements=needs))
    every = ObjectiveTerm(TermKind.ROBUSTNESS, 1.0)
    assert math.isnan(objective._robustness(subject, every, LOST, faces=False))
    one = ObjectiveTerm(TermKind.ROBUSTNESS, 1.0, requirement="y")
    assert objective._robustness(subject, one, LOST, faces=False) == 2.0


def test_an_objective_that_is_lost_is_not_reached() -> None:
    terms = [TermReport("effort", 1.0, 1.0, 1.0), TermReport("robustness", -1.0, math.nan, 0.0)]
    assert total(terms) is None
    claim = SolveInfo("optimal", 0.0, 0.0, 0.0, "highs", "1", "auto")
    (found,) = objective_violations(claim, total(terms), terms, Sense.MINIMIZE)
    assert found.message == "the objective can't be judged: robustness"
    assert found.amount == math.inf
