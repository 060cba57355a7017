"""Steps and times that reports name: within windows, and within the plan."""

import numpy as np
import pytest

from stlc.api import loads, verify
from stlc.plan import make_plan

HELD = """
horizon 6
agent a : single_integrator {{ start (0, 0); control |u| <= 9 }}
require r: {}
"""


@pytest.mark.parametrize(
    ("formula", "says", "step"),
    [
        ("(a.x <= 3) until[2, 3] (a.x >= 2)", "a.x >= 2", 3),
        ("not ((a.x <= 3) until[2, 3] (a.x >= 2))", "a.x >= 2", 3),
        ("(a.x >= 3) release[2, 4] (a.x <= 2)", "a.x <= 2", 3),
        ("not ((a.x >= 3) release[2, 4] (a.x <= 2))", "a.x <= 2", 3),
    ],
)
def test_ties_are_decided_within_the_window(formula, says, step):
    """At the last step both predicates are as near their thresholds as at the one that decides."""
    there = loads(HELD.format(formula))
    x = np.array([[0, 0], [0.5, 0], [1, 0], [2, 0], [9, 0], [3, 0], [2, 0]], dtype=float)
    report = verify(there, make_plan(there, {"a": x}, {"a": np.diff(x, axis=0)}))
    (found,) = report.requirements
    assert found.robustness == pytest.approx(0.0)
    assert (found.says, found.critical[0]) == (says, step)


PASSING = """
horizon 3
agent b : single_integrator { start (9, 1); control |u| <= 1 }
obstacle m = box [0, 2] x [3, 4] velocity (1, 0)
require mv: always b outside m swept
"""


def test_nothing_comes_nearer_after_the_end_of_a_plan():
    there = loads(PASSING)
    runs = {"b": np.tile([9.0, 1.0], (4, 1))}
    report = verify(there, make_plan(there, runs, {"b": np.zeros((3, 2))}))
    assert [c.what for c in report.clearances] == ["body", "buffer"]
    for clearance in report.clearances:
        assert clearance.value == pytest.approx(np.hypot(4.0, 2.0))
        assert clearance.time == pytest.approx(3.0)
