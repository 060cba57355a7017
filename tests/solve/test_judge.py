"""Points that use up a solver's tolerance: certified, but short of the mission until sharpened."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stlc import api
from stlc.backends import get
from stlc.backends.base import Solution, SolveOptions, Status
from stlc.milp.compile import Compiled
from stlc.milp.model import Model
from stlc.solve.certify import EXACT, certify, sharpened
from stlc.solve.judge import Judge

FAR = """step 1 s
workspace box [1000, 1010] x [1000, 1010]
agent r : double_integrator { start (1001, 1001); control |u| <= 1; speed <= 2 }
region goal = box [1006, 1007] x [1004, 1005]
require reach: eventually[1, 8] r in goal
minimize effort
"""
TOLERATED = 0.9e-6


def spent(model: Model) -> Solution:
    """The optimum where every row gives way by almost all that is tolerated."""
    loose = replace(
        model, row_lower=model.row_lower - TOLERATED, row_upper=model.row_upper + TOLERATED
    )
    x = get("highs").solve(loose, SolveOptions(gap=0.0, extra=EXACT)).x
    assert x is not None
    return Solution(Status.FEASIBLE, x, model.objective(x), solver="careless")


@pytest.fixture(scope="module")
def compiled() -> Compiled:
    return api.compile(api.loads(FAR))


def test_a_point_at_the_end_of_its_tolerance_becomes_a_plan(compiled: Compiled) -> None:
    """Weights of witness times carry 1e-6 to a coordinate a thousand times as large."""
    claim = spent(compiled.model)
    certified = certify(compiled.model, claim)
    assert not certified.polished
    judge = Judge(api.loads(FAR), compiled)
    assert not judge._verified(certified)[1].ok
    plan, report = judge.accept(claim)
    assert report.ok
    assert report.requirements[0].robustness >= -1e-8
    assert plan.certificate.as_dict()["continuous_part_solved_again"] is True


def test_what_can_not_be_kept_more_exactly_stays_as_it_is(compiled: Compiled) -> None:
    claim = spent(compiled.model)
    certified = certify(compiled.model, claim)
    impossible = np.full(compiled.model.rows, 1e5)
    closed = replace(compiled.model, row_lower=impossible, row_upper=impossible)
    assert sharpened(closed, certified) is certified
